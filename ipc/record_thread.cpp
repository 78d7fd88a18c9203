// record_thread.cpp: a short ring between the loop and the disk.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/record_thread.h"

namespace vdisp {
namespace {
constexpr size_t ring = 16;
}

RecordThread::RecordThread(const std::filesystem::path& folder, const RecordingInfo& info,
                           const std::vector<std::pair<std::string, std::string>>& texts, const ImageSpec& camera,
                           std::function<void()> begin)
    : taker_(camera), writer_(folder, info, texts) {
  for (size_t i = 0; i < ring; ++i) steps_.emplace_back(camera);
  taker_.begin(steps_[0]);
  thread_ = std::thread([this, begin = std::move(begin)] {
    if (begin) begin();
    write();
  });
}

RecordThread::~RecordThread() { stop(); }

void RecordThread::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Label RecordThread::finish_step() {
  const bool taken = taker_.finish();
  const Label label = steps_[filled_ % ring].views.label;
  std::unique_lock lock(mutex_);
  if (taken) {
    ++filled_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return failed_ || filled_ - written_ < ring; });
  }
  if (failed_) throw WriteError(*failed_);
  taker_.begin(steps_[filled_ % ring]);
  return label;
}

void RecordThread::finish() {
  stop();
  if (failed_) throw WriteError(*failed_);
}

void RecordThread::write() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return ending_ || filled_ > written_; });
    if (filled_ == written_) return;
    const TakenStep& taken = steps_[written_ % ring];
    lock.unlock();
    std::optional<WriteError> failed;
    try {
      writer_.add(taken.step, taken.step.has_pair() ? &taken.views : nullptr);
    } catch (const WriteError& error) {
      failed = error;
    } catch (const std::exception& error) {
      failed.emplace(75, writer_.folder().string() + ": " + error.what());
    }
    lock.lock();
    ++written_;
    if (failed) failed_ = failed;
    changed_.notify_all();
    if (failed_) return;
  }
}

}  // namespace vdisp
