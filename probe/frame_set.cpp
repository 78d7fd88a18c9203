// frame_set.cpp: subscribes to a set of topics and waits for frames in which all of them are there.
// SPDX-License-Identifier: Apache-2.0
#include "probe/frame_set.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace vdisp {
namespace {

constexpr std::chrono::seconds patience{10};

std::vector<std::string> choose(const std::vector<CatalogueEntry>& entries, const std::vector<std::string>& wanted) {
  std::vector<std::string> offered;
  for (const CatalogueEntry& entry : entries) {
    if (name_of(entry) != "catalogue" && name_of(entry) != "heartbeat") offered.emplace_back(name_of(entry));
  }
  if (wanted.empty()) return offered;
  for (const std::string& topic : wanted) require(entries, topic);
  return wanted;
}

}  // namespace

int picture_rows_of(const std::vector<CatalogueEntry>& entries) {
  for (const CatalogueEntry& entry : entries) {
    if (entry.spec.pixel == Pixel::disparity16) return entry.spec.height;
  }
  return 0;
}

FrameSet::FrameSet(Client& client, const std::vector<std::string>& wanted) : client_(client) {
  const std::vector<CatalogueEntry> entries = topics_of(client);
  names_ = choose(entries, wanted);
  picture_rows_ = picture_rows_of(entries);
  for (const std::string& name : names_) topics_.push_back(client.subscribe(name));
  readings_.resize(names_.size());
}

FrameSet::~FrameSet() {
  for (Client::Topic topic : topics_) client_.unsubscribe(topic);
}

bool FrameSet::next() {
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < patience) {
    if (stopped()) return false;
    if (!client_.wait_set(topics_, readings_, Client::Time(250))) continue;
    const bool all = std::all_of(readings_.begin(), readings_.end(), [](const Reading& r) { return r.image != nullptr; });
    if (!all) continue;
    const Image& first = image(0);
    if (last_sequence_ == first.sequence && last_epoch_ == first.epoch) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    last_sequence_ = first.sequence;
    last_epoch_ = first.epoch;
    return true;
  }
  const bool daemon = client_.connection() == Connection::connected;
  throw ProbeError(69, daemon ? "the daemon made no whole frame of these stages within 10 s; see vdisp-probe stats" : client_.message());
}

void FrameSet::release() {
  for (Client::Topic topic : topics_) client_.release(topic);
}

}  // namespace vdisp
