// comparison.cpp: pairs out of shared memory, a calibration of their rectified geometry, and two runs of vdispd over them.
// SPDX-License-Identifier: Apache-2.0
#include "probe/comparison.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "ipc/dump.h"
#include "ipc/dump_json.h"
#include "ipc/png.h"
#include "probe/config_text.h"
#include "probe/daemon_program.h"
#include "probe/format.h"
#include "probe/frame_set.h"
#include "probe/samples.h"

extern char** environ;

namespace vdisp {
namespace {

namespace fs = std::filesystem;

/// Gone with everything in it when the comparison is done.
class Folder {
 public:
  Folder() {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "vdisp-compare-XXXXXX").string();
    if (error || !mkdtemp(name.data()))
      throw ProbeError(73, "no folder for the frames in $TMPDIR or /tmp: " + std::string(std::strerror(errno)));
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// What belongs to the daemon and its pairs, and not to the stages behind them.
bool of_the_daemon(const std::string& key) {
  if (key == "main.detectors" || key == "main.threads") return false;
  for (const char* section : {"main.", "camera.", "ipc.", "control.", "recorder.", "drive.", "sim."})
    if (key.starts_with(section)) return true;
  for (const char* pair : {"source", "left", "right", "recording", "rate", "loop", "paramfile", "odometry", "width", "height", "bayer"})
    if (key == std::string("image source.") + pair) return true;
  return false;
}

void write_pair(const fs::path& folder, uint64_t number, const FrameSet& set) {
  for (size_t side = 0; side < 2; ++side) {
    const Image& image = set.image(side);
    write_file(folder / set.name(side) / (frame_name(number) + ".png"),
               encode_png(PngKind::gray8, image.spec.width, image.spec.height, [&](int y) { return image.row<uint8_t>(y); }));
  }
}

/// The images are rectified: a calibration that says no more than where their metres are. False: they have none.
bool write_calibration(const fs::path& file, const Image& left) {
  const CameraGeometry& camera = left.camera;
  if (!(camera.f > 0)) return false;
  const auto number = [](float value) { return format("%.9g", static_cast<double>(value)); };
  const auto matrix = [&](const char* name, float cx, float tx) {
    return std::string(name) + ": !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ " + number(camera.f) + ", 0., " +
           number(cx) + ", " + number(tx) + ", 0., " + number(camera.f) + ", " + number(camera.cy) + ", 0., 0., 0., 1., 0. ]\n";
  };
  write_file(file, format("%%YAML:1.0\n---\nimage_width: %d\nimage_height: %d\n", left.spec.width, left.spec.height) +
                       matrix("P1", camera.cx, 0) + matrix("P2", camera.cx - camera.cx_offset, -camera.f * camera.baseline));
  return true;
}

/// As many pairs as are wanted, as they come. Their rate in Hz, 0 where it is not known.
double take_pairs(const Options& options, const fs::path& folder, Comparison& comparison, bool& metres) {
  Client client(options.name);
  attach(client, options);
  comparison.picture_rows = picture_rows_of(topics_of(client));
  FrameSet set(client, {"left", "right"});
  for (const char* side : {"left", "right"}) fs::create_directory(folder / side);
  int64_t begin = 0, end = 0;
  uint64_t taken = 0;
  for (uint64_t tries = 0; taken < options.frames; ++tries) {
    if (!set.next()) throw ProbeError(69, "stopped");
    const Image& left = set.image(0);
    if (!left.valid() || !set.image(1).valid()) {
      if (tries > 100 + options.frames) throw ProbeError(69, "the daemon has no pairs: " + std::string(describe(left.reason)));
      set.release();
      continue;
    }
    write_pair(folder, taken, set);
    if (taken++ == 0) comparison.first = left.sequence, begin = left.timestamp_ns;
    comparison.last = left.sequence;
    end = left.timestamp_ns;
    if (taken == options.frames) metres = write_calibration(folder / "rectified.yml", left);
    set.release();
  }
  comparison.frames = taken;
  return end > begin ? std::clamp(static_cast<double>(taken - 1) * 1e9 / static_cast<double>(end - begin), 0.1, 1000.0) : 0;
}

/// Sections and keys as the daemon has them now, but for what the pairs need.
void write_config(const fs::path& folder, const std::vector<ParameterInfo>& all, double rate, bool metres) {
  const std::map<std::string, std::string> own{
      {"main.middleware", "none"},
      {"main.period", "0"},
      {"main.debug", "0"},
      {"main.metrics", "\"\""},
      {"image source.source", "files"},
      {"image source.left", in_quotes((folder / "left").string() + "/%06d.png")},
      {"image source.right", in_quotes((folder / "right").string() + "/%06d.png")},
      {"image source.recording", "\"\""},
      {"image source.rate", format("%.6g", rate)},
      {"image source.loop", "no"},
      {"image source.paramfile", metres ? in_quotes((folder / "rectified.yml").string()) : "\"\""},
      {"image source.odometry", "\"\""},
      {"image source.width", "0"},
      {"image source.height", "0"},
      {"image source.bayer", "none"},
  };
  ConfigText text;
  for (const ParameterInfo& info : all) {
    const auto other = own.find(info.key);
    if (other != own.end()) {
      text.add(info.key, other->second);
    } else if (!of_the_daemon(info.key)) {
      text.add(info.key, written(info));
    }
  }
  write_file(folder / "vdisp.cfg", text.text());
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void run_daemon(const fs::path& folder, const std::string& dump, uint64_t frames, const std::vector<std::string>& sets) {
  std::vector<std::string> words{daemon_program(),       "-c",     (folder / "vdisp.cfg").string(), "--frames",
                                 std::to_string(frames), "--dump", (folder / dump).string(),        "--images"};
  for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string said = (folder / (dump + ".log")).string();
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error) throw ProbeError(69, words[0] + " cannot be run: " + std::strerror(error) + "; it must be beside vdisp-probe or in $PATH");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    if (stopped()) kill(child, SIGTERM);
  }
  if (stopped()) throw ProbeError(69, "stopped");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  std::istringstream lines(text_of(said));
  std::string first;
  std::getline(lines, first);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 75;
  throw ProbeError(code == 127 ? 69 : code, first.empty() ? words[0] + " ended with " + std::to_string(code) : first);
}

/// Keys by their full names, and what is changed, in words.
std::vector<std::string> known_sets(Control& control, const Options& options, std::vector<std::string>& changes) {
  std::vector<std::string> sets;
  for (const std::string& set : options.sets) {
    const size_t equals = set.find('=');
    if (equals == std::string::npos) throw ProbeError(64, "'" + set + "' must be KEY=VALUE, such as thresh=14");
    ParameterInfo info;
    require_done(control, options, [&] { return control.get(set.substr(0, equals), info); });
    if (of_the_daemon(info.key))
      throw ProbeError(64, info.key +
                               " cannot be compared on a frame that was taken already: what makes the rectified pair, and the daemon "
                               "itself, are as they are");
    sets.push_back(info.key + set.substr(equals));
    changes.push_back(info.key + ": " + info.value + " -> " + set.substr(equals + 1));
  }
  return sets;
}

uint64_t count_differing(const Image& a, const Image& b) {
  const uint32_t bytes = pixel_bytes(a.spec.pixel);
  uint64_t differing = 0;
  for (int y = 0; y < a.spec.height; ++y) {
    const std::byte *one = a.row<std::byte>(y), *other = b.row<std::byte>(y);
    for (int x = 0; x < a.spec.width; ++x) differing += std::memcmp(one + x * bytes, other + x * bytes, bytes) != 0;
  }
  return differing;
}

uint64_t count_measured(const Image& image) {
  uint64_t count = 0;
  for (int y = 0; y < image.spec.height; ++y)
    count += static_cast<uint64_t>(std::count_if(image.row<int16_t>(y), image.row<int16_t>(y) + image.spec.width,
                                                 [](int16_t pixel) { return dumped_code(pixel) == 0; }));
  return count;
}

uint64_t count_obstacles(const Image& image) {
  uint64_t count = 0;
  for (int y = 0; y < image.spec.height; ++y)
    count += static_cast<uint64_t>(
        std::count_if(image.row<int8_t>(y), image.row<int8_t>(y) + image.spec.width, [](int8_t cell) { return cell >= occupied_from; }));
  return count;
}

Count count_of(const Image& before, const Image& after) {
  if (!before.valid() || !after.valid()) return {};
  if (before.spec.pixel == Pixel::disparity16) return {"px have a disparity", count_measured(before), count_measured(after)};
  if (before.spec.pixel == Pixel::int8) return {"cells are obstacles", count_obstacles(before), count_obstacles(after)};
  return {};
}

}  // namespace

StoredImage::StoredImage(const fs::path& file) {
  const std::string bytes = text_of(file);
  const size_t rounded = (std::max(bytes.size(), sizeof(Image)) + 63) & ~size_t{63};
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(64, rounded)));
  if (!memory_) throw std::bad_alloc();
  std::memset(memory_.get(), 0, rounded);
  std::memcpy(memory_.get(), bytes.data(), bytes.size());
  const Image& found = image();
  if (found.magic != Image::magic_value || found.version != Image::version_value || found.spec.bytes() != bytes.size())
    throw ProbeError(74, file.string() + ": not a whole image of this version");
}

Comparison compare_frames(const Options& options) {
  Comparison comparison;
  Control control(options.control, limit_of_all);
  const std::vector<std::string> sets = known_sets(control, options, comparison.changes);
  const Folder folder;
  bool metres = false;
  const double rate = take_pairs(options, folder.path(), comparison, metres);
  std::vector<ParameterInfo> all;
  require_done(control, options, [&] { return control.get_all(all); });
  write_config(folder.path(), all, rate, metres);
  if (nice(10) < 0) errno = 0;  // the daemon that serves goes first
  run_daemon(folder.path(), "new", options.frames, sets);
  run_daemon(folder.path(), "old", options.frames, {});
  const fs::path before = folder.path() / "old" / frame_name(options.frames - 1),
                 after = folder.path() / "new" / frame_name(options.frames - 1);
  std::vector<std::string> topics;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(before))
    if (file.path().extension() == ".image") topics.push_back(file.path().lexically_relative(before).replace_extension().string());
  std::sort(topics.begin(), topics.end());
  for (const std::string& topic : topics) {
    if (topic.starts_with("in/") || !fs::exists(after / (topic + ".image"))) continue;
    ComparedStage stage{topic, StoredImage(before / (topic + ".image")), StoredImage(after / (topic + ".image"))};
    if (stage.comparable()) {
      stage.pixels = static_cast<uint64_t>(stage.before.image().spec.width) * stage.before.image().spec.height;
      stage.differing = count_differing(stage.before.image(), stage.after.image());
    }
    stage.count = count_of(stage.before.image(), stage.after.image());
    comparison.stages.push_back(std::move(stage));
  }
  return comparison;
}

}  // namespace vdisp
