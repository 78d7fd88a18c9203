// aravis_list.cpp: Aravis keeps one list for the process; it is read under one lock.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/aravis_list.h"

#include <arv.h>

#include <algorithm>
#include <mutex>
#include <tuple>

#include "daemon/core/clock.h"
#include "daemon/sources/camera.h"
#include "daemon/sources/gige_knock.h"
#include "daemon/sources/usb_vision.h"

namespace vdisp {
namespace {

constexpr int64_t young_ns = 500'000'000;

std::string text(const char* words) { return words ? words : ""; }

}  // namespace

void prepare_aravis() {
  static std::once_flag once;  // as GLib's handlers, of the process
  std::call_once(once, [] {
    g_log_set_always_fatal(static_cast<GLogLevelFlags>(G_LOG_LEVEL_ERROR | G_LOG_FLAG_RECURSION));  // whatever G_DEBUG says
    g_log_set_default_handler([](const char*, GLogLevelFlags, const char*, void*) {}, nullptr);
    g_log_set_writer_func([](GLogLevelFlags, const GLogField*, gsize, void*) { return G_LOG_WRITER_HANDLED; }, nullptr, nullptr);
    g_set_printerr_handler([](const char*) {});
  });
}

std::string AttachedCamera::words() const {
  return (gige ? "GigE camera " : "USB3 camera ") + id + (address.empty() ? "" : " at " + address);
}

bool AttachedCamera::called(std::string_view name) const {
  return !name.empty() && (name == serial || name == address || name == id || name == physical || name == vendor + "-" + serial);
}

bool AttachedCamera::same_as(const AttachedCamera& other) const {
  if (gige != other.gige || std::tie(vendor, model, serial) != std::tie(other.vendor, other.model, other.serial)) return false;
  // Those without a serial number are told by their MAC address; stand-ins have neither, and are where they were.
  return !serial.empty() || (physical == other.physical && address == other.address);
}

std::vector<AttachedCamera> attached_aravis_cameras() {
  // The list of Aravis is the process's: both cameras' threads read it, one after the other.
  static std::mutex mutex;
  static std::vector<AttachedCamera> last;
  static int64_t last_ns = INT64_MIN / 2;
  prepare_aravis();
  const int64_t asked_ns = monotonic_ns();
  const std::lock_guard lock(mutex);
  if (last_ns > asked_ns - young_ns) return last;
  last_ns = monotonic_ns();
  arv_update_device_list();
  std::vector<AttachedCamera> found;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    found.push_back({text(arv_get_device_id(i)), text(arv_get_device_physical_id(i)), text(arv_get_device_address(i)),
                     text(arv_get_device_vendor(i)), text(arv_get_device_model(i)), text(arv_get_device_serial_nbr(i)),
                     text(arv_get_device_protocol(i)) == "GigEVision"});
  for (AttachedCamera& camera : found)
    if (!camera.gige) camera.address.clear();  // of USB it is the GUID once more
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return std::tie(a.id, a.physical, a.address) < std::tie(b.id, b.physical, b.address); });
  return last = found;
}

std::string list_of(const std::vector<AttachedCamera>& cameras) {
  std::string list;
  for (const AttachedCamera& camera : cameras) list += (list.empty() ? "" : ", ") + camera.words();
  return list.empty() ? "none" : list;
}

namespace {

/// Cameras that are plugged in and may not be opened are no "absent" ones: a rule is missing, and waiting does not help.
[[noreturn]] void refuse(const std::string& what, const std::vector<AttachedCamera>& attached) {
  const std::string unreadable = unreadable_usb_cameras();
  if (!unreadable.empty()) throw CameraError(CameraFault::denied, what + "; found: " + list_of(attached) + "; " + unreadable);
  throw CameraError(CameraFault::absent, what + "; found: " + list_of(attached));
}

}  // namespace

AttachedCamera find_again(const AttachedCamera& before, bool everywhere) {
  if (before.gige && !before.serial.empty()) {
    const std::optional<AttachedCamera> there = knock_at_gige(before.address);
    if (there && there->same_as(before)) return before;
    if (!everywhere)
      throw CameraError(CameraFault::absent,
                        before.words() + " is gone" + (there ? "; there is now one with serial number " + there->serial : ""));
  }
  const std::vector<AttachedCamera> attached = attached_aravis_cameras();
  for (const AttachedCamera& camera : attached)
    if (camera.same_as(before)) return camera;
  refuse(before.words() + " is gone", attached);
}

AttachedCamera choose(const CameraWish& wish, const std::vector<AttachedCamera>& attached) {
  const std::string key = std::string("[camera] ") + (wish.side == 0 ? "left" : "right");
  std::vector<AttachedCamera> fit;
  for (const AttachedCamera& camera : attached)
    if (wish.name.empty() ? !camera.called(wish.other_name) : camera.called(wish.name)) fit.push_back(camera);
  if (!wish.name.empty()) {
    if (fit.empty()) refuse(key + " = " + wish.name + ": no such GigE Vision or USB3 Vision camera", attached);
    if (fit.size() > 1) refuse(key + " = " + wish.name + " fits several cameras; write the whole name or the address", attached);
    return fit.front();
  }
  const size_t needed = wish.other_name.empty() ? static_cast<size_t>(wish.sides) : 1;
  if (fit.size() == needed) return fit[needed == 1 ? 0 : static_cast<size_t>(wish.side)];
  refuse(std::to_string(needed) + (needed == 1 ? " GigE Vision or USB3 Vision camera is" : " GigE Vision or USB3 Vision cameras are") +
             " needed" + (fit.size() > needed ? "; name which in [camera] left and right" : ""),
         attached);
}

}  // namespace vdisp
