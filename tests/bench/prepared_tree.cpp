// prepared_tree.cpp: the prepared images are the loans of the source's own outlets.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/prepared_tree.h"

#include <algorithm>
#include <stdexcept>

namespace vdisp::bench {

class PreparedTree::Source final : public StereoSource {
 public:
  Source(PreparedTree& tree, std::optional<Calibration> calibration) : tree_(tree), calibration_(std::move(calibration)) {}
  std::vector<ImageSpec> open() override {
    std::vector<ImageSpec> specs;
    for (const auto& picture : tree_.sets_.at(0)) specs.push_back(picture->spec());
    return specs;
  }
  /// The rows are there; only the header was cleared.
  Outcome grab(std::span<Image* const> out) noexcept override {
    for (size_t i = 0; i < out.size(); ++i) {
      const uint64_t sequence = out[i]->sequence, epoch = out[i]->epoch;
      out[i]->describe_like(tree_.headers_[tree_.current_][i]->image());
      out[i]->sequence = sequence;
      out[i]->epoch = epoch;
    }
    return Outcome::valid;
  }
  std::optional<Calibration> calibration() const override { return calibration_; }
  int64_t period_ns() const override { return 0; }

 private:
  PreparedTree& tree_;
  std::optional<Calibration> calibration_;
};

class PreparedTree::Rotating final : public Outlet {
 public:
  Rotating(PreparedTree& tree, size_t place) : tree_(tree), place_(place) {}
  bool watched() const noexcept override { return false; }
  Image& loan() noexcept override { return tree_.sets_[tree_.current_][place_]->image(); }
  void publish() noexcept override {}
  uint64_t drops() const noexcept override { return 0; }

 private:
  PreparedTree& tree_;
  size_t place_;
};

PreparedTree::PreparedTree(Setup setup, std::vector<Set> sets, std::vector<std::string> names, std::optional<Calibration> calibration,
                           const Grow& grow)
    : config_(std::move(setup.config)), machine_(config_.main.threads, setup.cpu), sets_(std::move(sets)) {
  for (const Set& set : sets_) {
    headers_.emplace_back();
    for (const auto& picture : set) {
      headers_.back().push_back(std::make_unique<Picture>(Pixel::gray8, 1, 1));
      headers_.back().back()->image().describe_like(picture->image());
    }
  }
  grow(driver_, std::make_unique<Source>(*this, std::move(calibration)), machine_, config_, inputs_);
  driver_.connect([&](const std::string& topic, const ImageSpec& spec) {
    const auto place = std::find(names.begin(), names.end(), topic);
    std::unique_ptr<Outlet> outlet;
    if (place != names.end()) {
      outlet = std::make_unique<Rotating>(*this, static_cast<size_t>(place - names.begin()));
    } else {
      outlet = std::make_unique<BufferOutlet>(spec);
    }
    outlets_.emplace_back(topic, outlet.get());
    return outlet;
  });
}

void PreparedTree::step() {
  if (driver_.step() != Outcome::valid) throw std::runtime_error("the tree gave no frame");
}

const Image& PreparedTree::image(const std::string& topic) const {
  for (const auto& [name, outlet] : outlets_) {
    if (name == topic) return outlet->loan();
  }
  throw std::out_of_range("no topic " + topic);
}

}  // namespace vdisp::bench
