// prepared_tree.h: a tree whose source gives out images that are there already: nothing but the stages takes time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "daemon/control/inputs.h"
#include "daemon/sources/source.h"
#include "daemon/stages/machine.h"
#include "tests/bench/frames.h"

namespace vdisp::bench {

/// Parameters, threads and instruction set of a tree.
struct Setup {
  Config config;
  std::string cpu = "auto";
};

/// Runs real stages under the real driver. The images of the source rotate from step to step and are never copied.
class PreparedTree {
 public:
  /// Adds stages behind the prepared images.
  using Grow = std::function<void(Driver&, std::unique_ptr<StereoSource>, Machine&, const Config&, Inputs&)>;
  /// `names` are the source's topics, as many as a set has images. What grow() adds has to take the source as its first stage.
  PreparedTree(Setup setup, std::vector<Set> sets, std::vector<std::string> names, std::optional<Calibration> calibration,
               const Grow& grow);
  PreparedTree(const PreparedTree&) = delete;
  PreparedTree& operator=(const PreparedTree&) = delete;

  /// The next set; not for timing.
  void next() { current_ = (current_ + 1) % sets_.size(); }
  /// One frame. Throws std::runtime_error where the tree gave none.
  void step();
  /// What a stage made of the last frame.
  const Image& image(const std::string& topic) const;

 private:
  class Source;
  class Rotating;
  Config config_;
  Inputs inputs_{config_};
  Machine machine_;
  std::vector<Set> sets_;
  std::vector<std::vector<std::unique_ptr<Picture>>> headers_;  // what the driver clears when it loans a prepared image
  size_t current_ = 0;
  Driver driver_{1};
  std::vector<std::pair<std::string, Outlet*>> outlets_;  // owned by the driver
};

}  // namespace vdisp::bench
