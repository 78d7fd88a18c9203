// flight_folder.cpp: names sort by time, so the oldest is the first.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/flight_folder.h"

#include <sys/statvfs.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "ipc/png.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t mib = 1 << 20;
constexpr std::string_view begins = "flight-";

/// "flight-" and a time to the ms; not what somebody else put there.
bool is_ours(const std::string& name) {
  constexpr std::string_view form = "flight-dddddddd-dddddd-ddd-";
  if (name.size() <= form.size()) return false;
  return std::equal(form.begin(), form.end(), name.begin(), [](char f, char c) { return f == 'd' ? c >= '0' && c <= '9' : f == c; });
}

std::string stamped(FlightCause cause) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  std::tm utc{};
  gmtime_r(&now.tv_sec, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d-%H%M%S-", &utc);
  const std::string ms = std::to_string(now.tv_nsec / 1'000'000);
  return std::string(begins) + text + std::string(3 - ms.size(), '0') + ms + "-" + std::string(name(cause));
}

/// Oldest first.
std::vector<fs::path> ours(const FlightRoom& room) {
  std::error_code error;
  std::vector<fs::path> there;
  for (fs::directory_iterator i(room.folder, error), end; !error && i != end; i.increment(error))
    if (is_ours(i->path().filename().string())) there.push_back(i->path());
  std::sort(there.begin(), there.end());
  return there;
}

}  // namespace

fs::path find_flight_folder(const FlightRoom& room, FlightCause cause, uint64_t needed) {
  std::error_code error;
  fs::create_directories(room.folder, error);
  if (error) throw write_error("cannot create", room.folder, error.value());
  struct statvfs disk {};
  if (statvfs(room.folder.c_str(), &disk) == 0) {
    const uint64_t free = static_cast<uint64_t>(disk.f_bavail) * disk.f_frsize;
    if (free < needed + room.least_free)
      throw WriteError(74, room.folder.string() + ": " + std::to_string(free / mib) + " MiB are free, needed are " +
                               std::to_string(needed / mib + 1) + " and the " + std::to_string(room.least_free / mib) +
                               " of [recorder] free; free some space or lower it");
  }
  const std::string wanted = stamped(cause);
  fs::path path = room.folder / wanted;
  for (int again = 2; fs::exists(path, error); ++again) path = room.folder / (wanted + "-" + std::to_string(again));
  return path;
}

void drop_oldest(const FlightRoom& room, const fs::path& whole) {
  std::error_code error;
  std::vector<fs::path> others = ours(room);
  std::erase(others, whole);  // by its name it may be the oldest: the wall clock is set now and then
  for (size_t i = 0; i + static_cast<size_t>(room.keep) < others.size() + 1; ++i) fs::remove_all(others[i], error);
}

void drop_broken(const FlightRoom& room, const fs::path& folder) {
  std::error_code error;
  if (ours(room).size() > static_cast<size_t>(room.keep)) fs::remove_all(folder, error);
}

}  // namespace vdisp
