// dump.cpp: one file for each picture, one JSON file for the rest.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/dump.h"

#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "ipc/dump_json.h"
#include "ipc/records.h"

namespace vdisp {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* line_csv_header = "column,row\n";
constexpr uint8_t map_occupied = 0, map_unknown = 205;  // map_server's own values

/// A PNG whose samples are made from int16 pixels, row by row.
template <class Sample, class Convert>
std::string converted(const Image& image, Convert convert) {
  std::vector<Sample> line(image.spec.width);
  return encode_png(sizeof(Sample) == 2 ? PngKind::gray16 : PngKind::gray8, image.spec.width, image.spec.height, [&](int y) {
    const int16_t* row = image.row<int16_t>(y);
    for (int x = 0; x < image.spec.width; ++x) line[x] = static_cast<Sample>(convert(row[x]));
    return line.data();
  });
}

std::string plain(PngKind kind, const Image& image) {
  return encode_png(kind, image.spec.width, image.spec.height, [&](int y) { return image.row<uint8_t>(y); });
}

std::string line_csv(const Image& image) {
  std::string text = line_csv_header;
  const int16_t* row = image.row<int16_t>(0);
  for (int x = 0; x < image.spec.width; ++x) {
    if (row[x] != line_none) text += std::to_string(x + 16 * image.camera.min_disparity) + "," + std::to_string(row[x]) + "\n";
  }
  return text;
}

std::string map_pgm(const Image& image) {
  std::string bytes = "P5\n" + std::to_string(image.spec.width) + " " + std::to_string(image.spec.height) + "\n255\n";
  for (int y = 0; y < image.spec.height; ++y) {
    const int16_t* row = image.row<int16_t>(y);
    for (int x = 0; x < image.spec.width; ++x) {
      const bool occupied = row[x] > 0 && static_cast<uint32_t>(row[x]) >= image.grid.min_count;
      bytes += static_cast<char>(occupied ? map_occupied : map_unknown);
    }
  }
  return bytes;
}

// The origin is the lower left corner of the map with the camera at (0, 0), x to the right and y ahead, as the picture shows it.
std::string map_yaml(const std::string& pgm, const GridGeometry& grid, int rows) {
  const auto text = [](double value) { return ordered_json(std::round(value * 1e6) / 1e6 + 0.0).dump(); };  // + 0.0: no "-0.0"
  const double cell = grid.cell;
  return "image: " + pgm + "\nresolution: " + text(cell) + "\norigin: [" + text(-cell * grid.origin_column) + ", " +
         text(-cell * (rows - static_cast<double>(grid.origin_row))) + ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

}  // namespace

struct FrameDump::Json {
  bool seen = false;
  ordered_json head, floor, records = ordered_json::object(), stages = ordered_json::object(), rejected = ordered_json::object();
  ordered_json timing = ordered_json::object();
};

FrameDump::FrameDump(fs::path folder) : folder_(std::move(folder)), json_(std::make_unique<Json>()) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  part_ = part_of(folder_);
  std::error_code error;
  if (fs::exists(folder_, error)) throw WriteError(73, folder_.string() + " exists already; name an empty or a new folder for the dump");
  fs::remove_all(part_, error);
  fs::create_directories(part_, error);
  if (error) throw write_error("cannot create", folder_, error.value());
}

FrameDump::~FrameDump() {
  std::error_code ignored;
  if (!part_.empty()) fs::remove_all(part_, ignored);
}

void FrameDump::add_file(const std::string& file, std::string_view bytes) {
  const fs::path path = part_ / file;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) throw write_error("cannot create", path.parent_path(), error.value());
  write_file(path, bytes);
}

void FrameDump::add(std::string_view topic_view, const Image& image) {
  const std::string topic(topic_view);
  for (const ImageSpec& own :
       {record_spec<Catalogue>(), record_spec<Heartbeat>(), record_spec<RecorderStatus>(), record_spec<CalibrationText>()})
    if (image.spec == own) return;
  // What comes in has a time and a state of its own, and what cameras deliver none: they say nothing of the frame.
  const bool incoming = topic.starts_with("in/"), of_frame = !incoming && image.spec != record_spec<CameraStatus>();
  if (!json_->seen && of_frame) {
    json_->seen = true;
    json_->head = {{"sequence", image.sequence},
                   {"timestamp_ns", image.timestamp_ns},
                   {"files", nullptr},
                   {"valid", true},
                   {"reason", name(Reason::none)},
                   {"config_generation", image.config_generation},
                   {"synthetic", (image.flags & flag_synthetic) != 0}};
  }
  if (of_frame && !image.valid() && json_->head["valid"] == true) {
    json_->head["valid"] = false;
    json_->head["reason"] = name(image.reason);
  }
  json_->stages[topic] = {{"valid", image.valid()}, {"reason", name(image.reason)}};
  if (image.spec == record_spec<FloorModel>()) json_->floor = floor_json(image);
  if (image.spec.pixel == Pixel::line16 && !image.valid()) add_file(topic + ".csv", line_csv_header);
  if (incoming) json_->records[topic.substr(3)] = input_json(image);
  if (!image.valid()) return;
  if (const TruthScene* scene = record_of<TruthScene>(image)) json_->records["truth_scene"] = scene_json(*scene);
  if (const MapChanges* changes = record_of<MapChanges>(image)) json_->records[topic] = changes_json(*changes);
  if (const Memory* memory = record_of<Memory>(image)) json_->records[topic] = memory_json(*memory);
  if (const Tracks* tracks = record_of<Tracks>(image)) json_->records[topic] = tracks_json(*tracks);
  if (const SnowScores* scores = record_of<SnowScores>(image)) json_->records[topic] = scores_json(*scores);
  if (const Decision* decision = record_of<Decision>(image)) json_->records[topic] = decision_json(*decision);
  if (const DriveCommand* command = record_of<DriveCommand>(image)) json_->records["drive_command"] = command_json(*command);
  if (const CrossCheck* check = record_of<CrossCheck>(image)) json_->records[topic] = check_json(*check);
  if (const CalibrationWatch* watch = record_of<CalibrationWatch>(image)) json_->records["row_error"] = watch_json(*watch);
  if (const CameraStatus* cameras = record_of<CameraStatus>(image)) json_->records["camera_status"] = cameras_json(*cameras);
  if (image.spec.pixel != Pixel::record) add_picture(topic, image);
}

void FrameDump::add_picture(const std::string& topic, const Image& image) {
  const bool grid = is_grid(topic);
  if (grid) json_->stages[topic]["grid"] = grid_json(image.grid);
  if (!grid && image.camera.f > 0) json_->stages[topic]["camera"] = camera_json(image.camera);
  if (topic == "surface") json_->stages[topic]["filled"] = filled_pixels(image);
  switch (image.spec.pixel) {
    case Pixel::gray8:
    case Pixel::mask8: return add_file(topic + ".png", plain(PngKind::gray8, image));
    case Pixel::int8: return add_file(topic + ".png", plain(PngKind::gray8, image));  // -1 reads as 255
    case Pixel::rgb8: return add_file(topic + ".png", plain(PngKind::rgb8, image));
    case Pixel::line16: return add_file(topic + ".csv", line_csv(image));
    case Pixel::height16: return add_file(topic + ".png", converted<uint16_t>(image, [](int height) { return height + 32768; }));
    case Pixel::disparity16:
      json_->rejected[topic] = rejected_json(image);
      add_file(topic + ".png", converted<uint16_t>(image, [](int d) { return d < 0 ? 0 : d; }));
      return add_file(topic + "_reason.png", converted<uint8_t>(image, dumped_code));
    case Pixel::count16:
      add_file(topic + ".png", converted<uint16_t>(image, [](int count) { return count < 0 ? 0 : count; }));
      if (!grid) return;
      add_file(topic + ".pgm", map_pgm(image));
      return add_file(topic + ".yaml", map_yaml(fs::path(topic).filename().string() + ".pgm", image.grid, image.spec.height));
    default: return;
  }
}

void FrameDump::add_timing(std::string_view stage, int64_t ns) { json_->timing[std::string(stage)] = ns; }

void FrameDump::finish(const std::string& left, const std::string& right) {
  ordered_json frame = json_->head;
  const auto known = [](const std::string& file) { return file.empty() ? ordered_json(nullptr) : ordered_json(file); };
  frame["files"] = {{"left", known(left)}, {"right", known(right)}};
  frame["floor"] = json_->floor;
  frame.update(json_->records);
  frame["rejected"] = json_->rejected;
  frame["stages"] = json_->stages;
  add_file("frame.json", frame.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
  if (!json_->timing.empty()) add_file("timing.json", json_->timing.dump(1) + "\n");
  if (rename(part_.c_str(), folder_.c_str()) != 0) throw write_error("cannot create", folder_, errno);
  part_.clear();
}

bool is_grid(std::string_view topic) {
  const std::string_view last = topic.substr(topic.rfind('/') + 1);  // npos + 1 is 0
  return last == "map" || last == "occupancy" || last == "reason" || last == "fused" || last == "fused_reason" || last.starts_with("map_");
}

std::string frame_name(uint64_t number) {
  const std::string digits = std::to_string(number);
  return digits.size() < 6 ? std::string(6 - digits.size(), '0') + digits : digits;
}

}  // namespace vdisp
