// contests.cpp: both sides of each contest are trees on the same prepared images: our stages in one, OpenCV's in the other.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/contests.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "config/parameters.h"
#include "daemon/stages/disparity.h"
#include "daemon/stages/features.h"
#include "daemon/stages/floor.h"
#include "daemon/stages/limit.h"
#include "daemon/stages/map.h"
#include "daemon/stages/vdisparity.h"
#include "daemon/tree.h"
#include "tests/bench/opencv_stages.h"
#include "tests/bench/prepared_tree.h"
#include "tests/bench/speckle_run.h"

namespace vdisp::bench {
namespace {

using std::make_unique;
using Sets = std::vector<std::string>;
using Source = std::unique_ptr<StereoSource>;

const std::vector<std::string> raw_names{"camera/left", "camera/right"}, view_names{"left", "right"};

Work work_of(std::shared_ptr<PreparedTree> tree, const std::string& result) {
  return {[tree] { tree->next(); }, [tree] { tree->step(); }, [tree, result] { return &tree->image(result); }};
}

/// The paper's parameters on the paper's rover; window 11, uniqueness 10, speckle 100 px / 1 px are the defaults.
Setup ours(int threads, const OurSide& side, const Sets& more) {
  Sets all{"main.middleware=none", "main.threads=" + std::to_string(threads), "mounting.height=0.8"};
  all.insert(all.end(), more.begin(), more.end());
  for (const std::string& set : side.sets) {
    // What the caller sets goes before the contest's own.
    const std::string key = set.substr(0, set.find('=') + 1);
    std::erase_if(all, [&](const std::string& own) { return own.starts_with(key); });
    all.push_back(set);
  }
  return {config_of(all), side.cpu};
}

/// The rest of the peer's settings are defaults. StereoBM's texture threshold of 10 is a sum over the window: thresh = 1 is 60.
Sets as_peer(int ndisp) { return {"image source.matcher=bm", "image source.ndisp=" + std::to_string(ndisp), "image source.thresh=1"}; }

void add_back_end(Driver& driver, Handle disparity, Machine& machine, const Config& config) {
  const auto votes = driver.add("vdisparity", make_unique<VDisparity>(machine, config), {disparity});
  const auto floor = driver.add_set({"floor", "floor_model"}, make_unique<Floor>(machine, config), {votes}, Need::always);
  const auto limit = driver.add("limit", make_unique<Limit>(config), {floor[0], floor[1]});
  driver.add("map", make_unique<Map>(machine, config), {disparity, limit, floor[1]}, Need::always);
}

Work our_matcher(const Frames& frames, Setup setup) {
  return work_of(std::make_shared<PreparedTree>(std::move(setup), frames.rectified, view_names, frames.calibration,
                                                [](Driver& driver, Source source, Machine& machine, const Config& c, Inputs&) {
                                                  const auto in = driver.add_set(view_names, std::move(source), {}, Need::always);
                                                  driver.add("disparity", make_unique<Disparity>(machine, c), {in[0], in[1]}, Need::always);
                                                }),
                 "disparity");
}

template <class Matcher, class... Arguments>
Work cv_matcher(const Frames& frames, Arguments... arguments) {
  return work_of(std::make_shared<PreparedTree>(Setup{}, frames.rectified, view_names, frames.calibration,
                                                [=](Driver& driver, Source source, Machine&, const Config&, Inputs&) {
                                                  const auto in = driver.add_set(view_names, std::move(source), {}, Need::always);
                                                  driver.add("disparity", make_unique<Matcher>(arguments...), {in[0], in[1]}, Need::always);
                                                }),
                 "disparity");
}

Contest rectify(const Frames& frames, const OurSide& side) {
  Contest contest{"rectify", {6, 8}, {}, {}, {}};
  contest.ours = [&frames, side](int threads) {
    return work_of(std::make_shared<PreparedTree>(ours(threads, side, {}), frames.raw, raw_names, frames.calibration,
                                                  [&frames](Driver& driver, Source source, Machine& machine, const Config& c, Inputs&) {
                                                    const auto in = driver.add_set(raw_names, std::move(source));
                                                    for (Side eye : {Side::left, Side::right})
                                                      driver.add(view_names[static_cast<size_t>(eye)],
                                                                 make_unique<Rectify>(eye, frames.calibration, machine, c),
                                                                 {in[static_cast<size_t>(eye)]}, Need::always);
                                                  }),
                   "left");
  };
  contest.peer = [&frames](int) {
    return work_of(std::make_shared<PreparedTree>(Setup{}, frames.raw, raw_names, frames.calibration,
                                                  [&frames](Driver& driver, Source source, Machine&, const Config&, Inputs&) {
                                                    const auto in = driver.add_set(raw_names, std::move(source));
                                                    for (Side eye : {Side::left, Side::right})
                                                      driver.add(view_names[static_cast<size_t>(eye)],
                                                                 make_unique<CvRectify>(eye, frames.calibration.value()),
                                                                 {in[static_cast<size_t>(eye)]}, Need::always);
                                                  }),
                   "left");
  };
  return contest;
}

/// More is what our matcher is told besides the number of disparities.
Contest matcher(const std::string& name, const Frames& frames, int ndisp, const OurSide& side, const Sets& more, Asked asked) {
  Sets own = as_peer(ndisp);
  own.insert(own.end(), more.begin(), more.end());
  Contest contest{name, asked, {}, {}, {}};
  contest.ours = [&frames, side, own](int threads) { return our_matcher(frames, ours(threads, side, own)); };
  contest.peer = [&frames, ndisp](int) { return cv_matcher<CvBlockMatcher>(frames, ndisp, Filters::all); };
  if (!frames.raw.empty()) contest.pixel_disparities = static_cast<double>(frames.spec().width) * frames.spec().height * ndisp;
  return contest;
}

Contest semi_global(const std::string& name, const Frames& frames, int ndisp, const OurSide& side, Asked asked) {
  Contest contest = matcher(name, frames, ndisp, side, {"image source.matcher=sgm"}, asked);
  contest.ours = [&frames, side, ndisp](int threads) {
    return our_matcher(
        frames, ours(threads, side, {"image source.matcher=sgm", "image source.thresh=0", "image source.ndisp=" + std::to_string(ndisp)}));
  };
  contest.peer = [&frames, ndisp](int) { return cv_matcher<CvSemiGlobal>(frames, ndisp); };
  return contest;
}

/// Smoothing, census and matching as in the second paper, which lays windows only face on. Nobody else has this to compare with.
Contest census(const Frames& frames, const OurSide& side) {
  Contest contest{"census", {0, 0, 0.8, 0.5}, {}, {}, {}};
  contest.ours = [&frames, side](int threads) {
    return our_matcher(
        frames, ours(threads, side,
                     {"image source.matcher=census", "image source.smooth=mean", "image source.align=none", "image source.ndisp=32"}));
  };
  return contest;
}

/// A model with even weights for this configuration, mapped by the tree while it is built. What weights say takes no time.
class EvenModel {
 public:
  EvenModel(const Config& config, const ImageSpec& view)
      : path_(std::filesystem::temp_directory_path() / ("bench-" + std::to_string(getpid()) + ".snow")) {
    const std::vector<float> weights(snow::vector_length, 1.0f);
    snow::ModelParts parts;
    parts.settings = front_end(config, view);
    parts.free = parts.obstacles = parts.left = parts.right = weights;
    snow::write_model(path_, parts);
  }
  ~EvenModel() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  EvenModel(const EvenModel&) = delete;
  EvenModel& operator=(const EvenModel&) = delete;
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// Two raw images to the drive command by the second detector alone: rectification, census, matching, depth map, features, classifiers.
Contest second_detector(const Frames& frames, const OurSide& side) {
  Contest contest{"snow", {0, 0, 1.0, 0.7}, {}, {}, {}};
  contest.ours = [&frames, side](int threads) {
    const Sets own{"main.detectors=snow", "census.scale=1", "snow.model=even"};
    Setup setup = ours(threads, side, own);
    const EvenModel model(setup.config, frames.spec());
    setup.config.snow.model = model.path();
    return work_of(std::make_shared<PreparedTree>(std::move(setup), frames.raw, raw_names, frames.calibration,
                                                  [](Driver& driver, Source source, Machine& machine, const Config& c, Inputs& inputs) {
                                                    build_tree(driver, std::move(source), machine, c, inputs);
                                                  }),
                   "drive");
  };
  return contest;
}

/// Two raw images to the map. The peer is followed by our back end, the paper's: so is ours, unless `more` tells another floor.
Contest tree(const std::string& name, const Frames& frames, int ndisp, const OurSide& side, const Sets& more, Asked asked) {
  Sets own = as_peer(ndisp);
  own.insert(own.end(), more.begin(), more.end());
  if (std::none_of(own.begin(), own.end(), [](const std::string& set) { return set.starts_with("Floor.model="); }))
    own.push_back("Floor.model=line");
  Contest contest{name, asked, asked, {}, {}};
  contest.ours = [&frames, side, own](int threads) {
    return work_of(std::make_shared<PreparedTree>(ours(threads, side, own), frames.raw, raw_names, frames.calibration,
                                                  [](Driver& driver, Source source, Machine& machine, const Config& c, Inputs& inputs) {
                                                    build_tree(driver, std::move(source), machine, c, inputs);
                                                  }),
                   "map");
  };
  contest.peer = [&frames, ndisp](int threads) {
    return work_of(
        std::make_shared<PreparedTree>(
            ours(threads, {}, {"image source.ndisp=" + std::to_string(ndisp)}), frames.raw, raw_names, frames.calibration,
            [&frames, ndisp](Driver& driver, Source source, Machine& machine, const Config& c, Inputs&) {
              const auto in = driver.add_set(raw_names, std::move(source));
              const auto left = driver.add("left", make_unique<CvRectify>(Side::left, frames.calibration.value()), {in[0]});
              const auto right = driver.add("right", make_unique<CvRectify>(Side::right, frames.calibration.value()), {in[1]});
              add_back_end(driver, driver.add("disparity", make_unique<CvBlockMatcher>(ndisp, Filters::all), {left, right}), machine, c);
            }),
        "map");
  };
  return contest;
}

/// Floor, limit, map and v-disparity of the same disparities. OpenCV has no such thing.
Contest back_end(const Frames& frames, const OurSide& side) {
  Contest contest{"backend", {0, 0, 0.4, 0.25}, {}, {}, {}};
  contest.ours = [&frames, side](int threads) {
    return work_of(std::make_shared<PreparedTree>(ours(threads, side, {}), disparities(frames, 48, Filters::all), Sets{"disparity"},
                                                  frames.calibration,
                                                  [](Driver& driver, Source source, Machine& machine, const Config& c, Inputs&) {
                                                    add_back_end(driver, driver.add("disparity", std::move(source)), machine, c);
                                                  }),
                   "map");
  };
  return contest;
}

Contest speckle(const Frames& frames, const OurSide& side) {
  Contest contest{"speckle", {3, 4}, {}, {}, {}};
  contest.ours = [&frames, side](int threads) -> Work {
    auto run = std::make_shared<SpeckleRun>(frames, ours(threads, side, {}));
    return {[run] { run->prepare(); }, [run] { run->ours(); }, [run] { return run->image(); }};
  };
  contest.peer = [&frames, side](int) -> Work {
    auto run = std::make_shared<SpeckleRun>(frames, ours(1, side, {}));
    return {[run] { run->prepare(); }, [run] { run->peer(); }, [run] { return run->image(); }};
  };
  return contest;
}

}  // namespace

std::vector<Contest> contests(const Images& images, const OurSide& side) {
  const Sets aligned{"image source.align=floor"};
  const Sets upright = find_parameter("image source", "align") ? Sets{"image source.align=none"} : Sets{};
  std::vector<Contest> all{
      rectify(images.vga, side),
      matcher("matcher48", images.vga, 48, side, upright, {4, 5}),
      matcher("matcher64", images.vga, 64, side, upright, {4.5, 6}),
      matcher("matcher48_aligned", images.vga, 48, side, aligned, {2.2, 3}),
      speckle(images.vga, side),
      tree("tree48", images.vga, 48, side, upright, {4, 5}),
      back_end(images.vga, side),
      census(images.quarter, side),
      second_detector(images.quarter, side),
      semi_global("sgm64", images.vga, 64, side, {4, 6}),
      tree("tree48_aligned", images.vga, 48, side, aligned, {}),
      tree("tree48_profile", images.vga, 48, side, {"image source.align=floor", "Floor.model=profile"}, {}),
      matcher("matcher128_1280x960", images.large, 128, side, upright, {}),
  };
  for (const auto& [name, frames] : images.recorded) {
    all.push_back(matcher("matcher64_" + name, frames, 64, side, upright, {}));
    all.push_back(matcher("matcher64_aligned_" + name, frames, 64, side, aligned, {}));
    all.push_back(semi_global("sgm64_" + name, frames, 64, side, {}));
  }
  return all;
}

}  // namespace vdisp::bench
