// frame_set.h: images of one and the same frame, for the words that write frames.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "probe/attach.h"

namespace vdisp {

/// Attaches to topics, so that the daemon computes them, and waits for whole frames.
class FrameSet {
 public:
  /// Empty `wanted`: all topics but the daemon's own. Throws ProbeError (64) for a topic that the daemon does not offer.
  FrameSet(Client& client, const std::vector<std::string>& wanted);
  ~FrameSet();
  FrameSet(const FrameSet&) = delete;
  FrameSet& operator=(const FrameSet&) = delete;

  /// The next frame. False when the word was stopped; throws ProbeError (69) where none comes within 10 s.
  bool next();
  void release();

  size_t size() const { return names_.size(); }
  const std::string& name(size_t i) const { return names_[i]; }
  /// Valid until next() or release().
  const Image& image(size_t i) const { return *readings_[i].image; }
  /// Height of the camera's pictures, 0 where no topic tells it.
  int picture_rows() const { return picture_rows_; }

 private:
  Client& client_;
  std::vector<std::string> names_;
  std::vector<Client::Topic> topics_;
  std::vector<Reading> readings_;
  int picture_rows_ = 0;
  std::optional<uint64_t> last_sequence_;
  uint64_t last_epoch_ = 0;
};

/// Height of the camera's pictures, as the catalogue tells it; 0 where it does not.
int picture_rows_of(const std::vector<CatalogueEntry>& entries);

}  // namespace vdisp
