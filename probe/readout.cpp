// readout.cpp: pixels, records and maps in words.
// SPDX-License-Identifier: Apache-2.0
#include "probe/readout.h"

#include <cmath>
#include <cstdio>
#include <cstring>

#include "ipc/dump.h"
#include "ipc/records.h"
#include "probe/drive_text.h"
#include "probe/format.h"
#include "probe/scales.h"

namespace vdisp {
namespace {

/// Depth of a disparity in px, and where the column lies at it.
std::string metres(const CameraGeometry& camera, double disparity, std::optional<int> column = {}) {
  if (!(camera.f > 0) || !(camera.baseline > 0)) return "  no calibration: no metres";
  const double true_disparity = disparity - static_cast<double>(camera.cx_offset);
  if (true_disparity <= 0) return "  at infinity";
  const double z = static_cast<double>(camera.f) * static_cast<double>(camera.baseline) / true_disparity;
  if (!column) return format("  Z %.2f m", z);
  return format("  Z %.2f m  X %+.2f m", z, (*column - static_cast<double>(camera.cx)) * z / static_cast<double>(camera.f));
}

std::string disparity_words(const Image& image, int column, int row) {
  const int16_t d = image.row<int16_t>(row)[column];
  if (const uint8_t code = rejected_code(d)) return "none: " + std::string(name(Rejected{code}));
  return format("%.2f px", d / 16.0) + metres(image.camera, d / 16.0, column);
}

std::string place_words(const GridGeometry& grid, int column, int row) {
  const Place place = place_of(grid, column, row);
  if (grid.frame == grid_of_odometry)
    return format("  odometry x %+.2f m  y %+.2f m  (cell of %.2f m)", place.z, -place.x, static_cast<double>(grid.cell));
  return format("  z %.2f m  x %+.2f m  (cell of %.2f m)", place.z, place.x, static_cast<double>(grid.cell));
}

std::string map_words(const Image& image, int column, int row) {
  const int16_t count = image.row<int16_t>(row)[column];
  const char* meaning = is_obstacle(image.grid, count)     ? "obstacle"
                        : count > 0                        ? "fewer points than an obstacle"
                        : in_view(image.grid, column, row) ? "nothing seen"
                                                           : "out of view";
  return format("%d points, %s", count, meaning) + place_words(image.grid, column, row);
}

// The row under the cursor is not asked for: a curve has one row for each column.
std::string line_words(const Image& image, int column) {
  const double disparity = column / 16.0 + image.camera.min_disparity;
  const int16_t row = image.row<int16_t>(0)[column];
  const std::string at = format("disparity %.2f px: ", disparity);
  return at + (row == line_none ? std::string("no line here") : format("row %d", row)) + metres(image.camera, disparity);
}

/// The eight neighbours, row by row: 1 where the centre is brighter.
std::string census_words(uint8_t code) {
  std::string bits;
  for (int i = 7; i >= 0; --i) bits += (code >> i & 1) ? '1' : '0';
  return format("%d: ", code) + bits.substr(0, 3) + " " + bits.substr(3, 1) + "." + bits.substr(4, 1) + " " + bits.substr(5);
}

/// Figure 9: its number is column, row and value.
std::string feature_words(const Image& image, int column, int row) {
  const uint8_t value = image.row<uint8_t>(row)[column];
  if (image.spec.height > 2) return format("%d  feature %d", value, column << 14 | row << 8 | value);
  const int high = image.spec.height > 1 ? image.row<uint8_t>(1)[column] : 0, at = image.row<uint8_t>(0)[column];
  const std::string number = format("  feature %d", column << 14 | at << 8 | high);
  if (at == 0) return "no obstacle" + number;
  const double least = static_cast<double>(at) * image.camera.disparities / contour_rows;
  return format("obstacle at row %d", at) + (image.spec.height > 1 ? format(", height %d", high) : "") + metres(image.camera, least) +
         number;
}

std::string value_words(std::string_view topic, const Image& image, int column, int row) {
  switch (image.spec.pixel) {
    case Pixel::gray8: {
      const uint8_t value = image.row<uint8_t>(row)[column];
      if (is_reason(topic)) return std::string(name(CellReason{value})) + place_words(image.grid, column, row);
      if (is_true_cells(topic)) return std::string(name(TruthCell{value})) + place_words(image.grid, column, row);
      if (is_census(topic)) return census_words(value);
      if (is_features(topic)) return feature_words(image, column, row);
      return is_surface(topic) ? std::string(name(Surface{value})) : std::to_string(value);
    }
    case Pixel::mask8: return image.row<uint8_t>(row)[column] ? "set" : "not set";
    case Pixel::rgb8: {
      const uint8_t* rgb = image.row<uint8_t>(row) + 3 * column;
      return format("%d %d %d", rgb[0], rgb[1], rgb[2]);
    }
    case Pixel::disparity16: return disparity_words(image, column, row);
    case Pixel::count16: {
      if (is_grid(topic)) return map_words(image, column, row);
      if (is_depth_map(topic))
        return format("%d pixels at %d px", image.row<int16_t>(row)[column], row) + metres(image.camera, row, column);
      const double disparity = column / 16.0 + image.camera.min_disparity;
      return format("%d votes for disparity %.2f px", image.row<int16_t>(row)[column], disparity) + metres(image.camera, disparity);
    }
    case Pixel::height16: {
      const int16_t mm = image.row<int16_t>(row)[column];
      return mm == height_unknown ? "height unknown" : format("%+.3f m over the floor", mm / 1000.0);
    }
    case Pixel::int8: {
      const int8_t percent = image.row<int8_t>(row)[column];
      const std::string meaning = percent < 0 ? "unknown" : format("%d %% occupied", percent);
      return is_grid(topic) ? meaning + place_words(image.grid, column, row) : meaning;
    }
    default: return {};
  }
}

std::vector<std::string> floor_text(const FloorModel& floor) {
  constexpr double degrees = 180 / M_PI;
  const char* state = floor.state == FloorState::found ? "found" : floor.state == FloorState::held ? "held" : "lost";
  std::vector<std::string> lines{std::string("floor       ") + state,
                                 "line        row = " + or_dash("%.4f", floor.a) + " * column + " + or_dash("%.2f", floor.b),
                                 "pitch       " + or_dash("%.2f deg", floor.pitch_rad, degrees) + or_dash("  (%.4f rad)", floor.pitch_rad),
                                 "roll        " + or_dash("%.2f deg", floor.roll_rad, degrees),
                                 "height      " + or_dash("%.3f m", floor.height_m),
                                 "confidence  " + or_dash("%.2f", floor.confidence),
                                 "points      " + std::to_string(floor.points)};
  if (floor.reason != Reason::none) lines.push_back("reason      " + std::string(describe(floor.reason)));
  if (floor.imu != ImuUse::none) lines.push_back("IMU         " + std::string(describe(floor.imu)));
  if (std::isfinite(floor.gravity_pitch_rad))
    lines.push_back("by gravity  pitch" + or_dash(" %.2f deg", floor.gravity_pitch_rad, degrees) + ", roll" +
                    or_dash(" %.2f deg", floor.gravity_roll_rad, degrees) + (floor.gravity_differs ? ": differs" : ""));
  if (floor.mounting_differs) lines.push_back("mounting    differs from [mounting]");
  return lines;
}

std::vector<std::string> scene_text(const TruthScene& scene) {
  constexpr double degrees = 180 / M_PI;
  static constexpr const char* kinds[] = {"?", "box", "post", "wall", "rock", "beam"};
  std::vector<std::string> lines{
      "pitch       " + or_dash("%.2f deg", scene.pitch_rad, degrees), "roll        " + or_dash("%.2f deg", scene.roll_rad, degrees),
      "height      " + or_dash("%.3f m", scene.height_m), "slope       " + or_dash("%.2f deg", scene.slope_rad, degrees),
      format("rover       x %+.2f m  y %+.2f m  yaw %+.1f deg", scene.x_m, scene.y_m, scene.yaw_rad * degrees)};
  if (scene.drop.depth > 0) lines.push_back(format("drop        %.2f m", static_cast<double>(scene.drop.depth)));
  for (uint32_t i = 0; i < std::min(scene.count, TruthScene::capacity); ++i) {
    const TruthObject& object = scene.objects[i];
    const auto kind = static_cast<uint32_t>(object.kind);
    lines.push_back(format("%2u %-4s  x %+.2f  z %.2f  %.2fx%.2fx%.2f m", i + 1, kinds[kind < std::size(kinds) ? kind : 0],
                           static_cast<double>(object.x), static_cast<double>(object.z), static_cast<double>(object.width),
                           static_cast<double>(object.depth), static_cast<double>(object.height)));
  }
  return lines;
}

void add_tally(std::vector<std::string>& lines, const InputTally& tally) {
  lines.push_back("accepted    " + std::to_string(tally.accepted));
  lines.push_back("refused     " + std::to_string(tally.refused));
  if (tally.last_refusal != Refusal::none) lines.push_back("last one    " + std::string(describe(tally.last_refusal)));
}

std::vector<std::string> odometry_text(const Odometry& o) {
  constexpr double degrees = 180 / M_PI;
  std::vector<std::string> lines{"x           " + or_dash("%.3f m", o.x),
                                 "y           " + or_dash("%.3f m", o.y),
                                 "yaw         " + or_dash("%.2f deg", o.yaw, degrees),
                                 "z           " + or_dash("%.3f m", o.z),
                                 "pitch       " + or_dash("%.2f deg", o.pitch, degrees),
                                 "roll        " + or_dash("%.2f deg", o.roll, degrees),
                                 "speed       " + or_dash("%.3f m/s", o.speed),
                                 "turn rate   " + or_dash("%.3f rad/s", o.turn_rate),
                                 "age         " + or_dash("%.3f s", o.age_s),
                                 "frame       " + std::to_string(o.frame)};
  add_tally(lines, o.tally);
  return lines;
}

std::vector<std::string> imu_text(const Imu& imu) {
  constexpr double degrees = 180 / M_PI;
  const auto& a = imu.acceleration;
  std::vector<std::string> lines{"pitch       " + or_dash("%.2f deg", imu.pitch, degrees),
                                 "roll        " + or_dash("%.2f deg", imu.roll, degrees),
                                 "acceleration" + or_dash(" %.2f", a[0]) + or_dash(" %.2f", a[1]) + or_dash(" %.2f m/s2", a[2]),
                                 "age         " + or_dash("%.3f s", imu.age_s)};
  add_tally(lines, imu.tally);
  return lines;
}

std::vector<std::string> order_text(const DriveOrder& drive) {
  std::vector<std::string> lines{"speed       " + or_dash("%.3f m/s", drive.speed), "turn rate   " + or_dash("%.3f rad/s", drive.turn_rate),
                                 "age         " + or_dash("%.3f s", drive.age_s)};
  add_tally(lines, drive.tally);
  return lines;
}

std::vector<std::string> events_text(const Events& events) {
  std::vector<std::string> lines{"age         " + or_dash("%.3f s", events.age_s)};
  for (uint32_t i = 0; i < std::min(events.count, Events::capacity); ++i) lines.emplace_back(events.entries[i].text());
  add_tally(lines, events.tally);
  return lines;
}

std::vector<std::string> changes_text(const MapChanges& changes) {
  static constexpr const char* whole[] = {"", "the first grid", "after blindness", "the grid has moved", "more than the list holds"};
  const auto why = static_cast<uint32_t>(changes.whole);
  const auto number = [](uint64_t value) { return std::to_string(value); };
  std::vector<std::string> lines{"generation  " + number(changes.generation) + ", before " + number(changes.previous),
                                 "changed     " + number(changes.changed) + " cells, " + number(changes.count) + " listed"};
  if (why != 0)
    lines.push_back(std::string("read all    ") + (why < std::size(whole) ? whole[why] : "for a reason not known to this version"));
  constexpr uint32_t shown = 12;
  const uint32_t count = std::min(changes.count, MapChanges::capacity);
  for (uint32_t i = 0; i < std::min(count, shown); ++i) {
    const ChangedCell& cell = changes.cells[i];
    lines.push_back(format("row %3d  column %3d  ", cell.row, cell.column) + (cell.value < 0 ? "unknown" : format("%d %%", cell.value)));
  }
  if (count > shown) lines.push_back("and " + number(count - shown) + " more");
  return lines;
}

std::vector<std::string> memory_text(const Memory& memory) {
  const bool fused = memory.state == MemoryState::fused;
  std::vector<std::string> lines{"memory      " +
                                 (fused ? "since " + or_dash("%.1f s", memory.since_s) : std::string("none: the map is of the frame"))};
  if (memory.cause != MemoryCause::none) lines.push_back((fused ? "forgotten   " : "because     ") + std::string(describe(memory.cause)));
  lines.push_back(format("forgotten   %u times", memory.forgotten));
  lines.push_back("x           " + or_dash("%+.3f m", memory.x));
  lines.push_back("y           " + or_dash("%+.3f m", memory.y));
  lines.push_back("yaw         " + or_dash("%+.4f rad", memory.yaw));
  lines.push_back("lag         " + or_dash("%.3f s", memory.lag_s));
  return lines;
}

std::vector<std::string> tracks_text(const Tracks& tracks) {
  const uint32_t count = std::min(tracks.count, Tracks::capacity);
  std::vector<std::string> lines{format("%u obstacles in the %s frame", count, tracks.frame == grid_of_odometry ? "odometry" : "rover's")};
  for (uint32_t i = 0; i < count; ++i) {
    const Track& t = tracks.tracks[i];
    lines.push_back(format("%4u  %+.2f %+.2f m  %+.2f %+.2f m/s  %.1f s%s", t.id, static_cast<double>(t.x), static_cast<double>(t.y),
                           static_cast<double>(t.speed_x), static_cast<double>(t.speed_y), static_cast<double>(t.age_s),
                           t.flags & Track::moving ? "  moving" : ""));
  }
  return lines;
}

std::vector<std::string> cameras_text(const CameraStatus& status) {
  const auto number = [](uint64_t value) { return std::to_string(value); };
  std::vector<std::string> lines{"pairs       " + number(status.pairs) + ", " + number(status.skipped) + " too many for the tree",
                                 "apart       " + or_dash("%+.2f ms", status.apart_ms), "age         " + or_dash("%.1f ms", status.age_ms)};
  if (status.exchanged) lines.push_back("views       exchanged");
  for (uint32_t side = 0; side < 2; ++side) {
    const CameraView& view = status.view[side];
    const bool both = status.cameras == 1;
    if (!both || side == 0)
      lines.push_back((both        ? "camera      "
                       : side == 0 ? "left        "
                                   : "right       ") +
                      number(view.frames) + " frames, " + number(view.incomplete) + " incomplete, " + number(view.unpaired) +
                      " unpaired, " + number(view.refused) + " refused, opened " + number(view.opened) + " times" +
                      (view.open ? "" : ", not open"));
    lines.push_back(format("  %-5s     ", side == 0 ? "left" : "right") + "floor level " + or_dash("%.0f", view.floor_level) + ", dark " +
                    or_dash("%.0f %%", view.dark, 100) + ", bright " + or_dash("%.0f %%", view.bright, 100) + ", exposure " +
                    or_dash("%.0f us", view.exposure_us) + ", gain " + or_dash("%.1f dB", view.gain_db));
  }
  return lines;
}

std::vector<std::string> watch_text(const CalibrationWatch& watch) {
  constexpr double degrees = 180 / M_PI;
  return {"calibration " + std::string(watch.state == CalibrationState::drifted ? "HAS DRIFTED" : name(watch.state)),
          "rows        " + or_dash("median %.2f px", watch.median_px) + or_dash(", 90 %% within %.2f px", watch.p90_px) +
              or_dash(", limit %.2f px", watch.limit_px),
          "shift       " + or_dash("%+.2f", watch.shift_px) + or_dash(" +- %.2f px", watch.shift_deviation_px) + " (right view, down)",
          "rotation    " + or_dash("%+.3f", watch.rotation_rad, degrees) + or_dash(" +- %.3f deg", watch.rotation_deviation_rad, degrees) +
              " (right camera, about its view)",
          format("points      %u of the last %.1f s", watch.points, watch.window_s),
          "drifted     " + std::to_string(watch.drifts) + " times" +
              (watch.state == CalibrationState::drifted ? "; vdisp-calibrate check tells more" : "")};
}

}  // namespace

std::string spec_words(const ImageSpec& spec) {
  if (spec.pixel == Pixel::record) return "record " + std::to_string(spec.width) + " bytes";
  return std::string(name(spec.pixel)) + " " + std::to_string(spec.width) + "x" + std::to_string(spec.height);
}

std::string read_out(std::string_view topic, const Image& image, int column, int row) {
  if (!image.valid() || image.spec.pixel == Pixel::record || column < 0 || row < 0 || column >= image.spec.width) return {};
  const std::string where = format("row %d  column %d   ", row, column);
  if (image.spec.pixel == Pixel::line16) return where + line_words(image, column);
  if (is_contour(topic, image)) return where + feature_words(image, column, 0);
  return row < image.spec.height ? where + value_words(topic, image, column, row) : std::string();
}

std::vector<std::string> record_text(const Image& image) {
  if (!image.valid()) return {"blind: " + std::string(describe(image.reason))};
  if (const FloorModel* floor = record_of<FloorModel>(image)) return floor_text(*floor);
  if (const TruthScene* scene = record_of<TruthScene>(image)) return scene_text(*scene);
  if (const Odometry* odometry = record_of<Odometry>(image)) return odometry_text(*odometry);
  if (const Imu* imu = record_of<Imu>(image)) return imu_text(*imu);
  if (const DriveOrder* drive = record_of<DriveOrder>(image)) return order_text(*drive);
  if (const Events* events = record_of<Events>(image)) return events_text(*events);
  if (const MapChanges* changes = record_of<MapChanges>(image)) return changes_text(*changes);
  if (const Memory* memory = record_of<Memory>(image)) return memory_text(*memory);
  if (const Tracks* tracks = record_of<Tracks>(image)) return tracks_text(*tracks);
  if (auto lines = drive_text(image); !lines.empty()) return lines;
  if (const CameraStatus* status = record_of<CameraStatus>(image)) return cameras_text(*status);
  if (const CalibrationWatch* watch = record_of<CalibrationWatch>(image)) return watch_text(*watch);
  return {format("record of type %u, %u bytes, not known to this version", image.spec.record, image.spec.width)};
}

double Place::distance() const { return std::hypot(x, z); }
double Place::bearing_deg() const { return std::atan2(x, z) * 180 / M_PI; }

bool usable(const GridGeometry& grid) {
  const auto within = [](float value, float limit) { return std::abs(value) <= limit; };  // false for NaN
  return grid.cell >= 1e-3f && within(grid.cell, 1e3f) && within(grid.origin_row, 1e5f) && within(grid.origin_column, 1e5f) &&
         within(grid.view_left, 1e3f) && within(grid.view_right, 1e3f);
}

Place rover_of(const GridGeometry& grid) {
  const double x = static_cast<double>(grid.pose_x), y = static_cast<double>(grid.pose_y), yaw = static_cast<double>(grid.pose_yaw);
  return {-(std::sin(yaw) * x - std::cos(yaw) * y), -(std::cos(yaw) * x + std::sin(yaw) * y)};
}

Place place_of(const GridGeometry& grid, double column, double row) {
  const double cell = grid.cell;
  return {(column + 0.5 - static_cast<double>(grid.origin_column)) * cell, (static_cast<double>(grid.origin_row) - row - 0.5) * cell};
}

bool is_obstacle(const GridGeometry& grid, int16_t count) { return count > 0 && static_cast<uint32_t>(count) >= grid.min_count; }

bool in_view(const GridGeometry& grid, int column, int row) {
  const Place place = place_of(grid, column, row);
  return place.z > 0 && place.x >= static_cast<double>(grid.view_left) * place.z &&
         place.x <= static_cast<double>(grid.view_right) * place.z;
}

std::optional<Place> nearest_obstacle(const Image& map) {
  std::optional<Place> nearest;
  for (int y = 0; y < map.spec.height; ++y) {
    for (int x = 0; x < map.spec.width; ++x) {
      if (!is_obstacle(map.grid, map.row<int16_t>(y)[x])) continue;
      const Place place = place_of(map.grid, x, y);
      if (!nearest || place.distance() < nearest->distance()) nearest = place;
    }
  }
  return nearest;
}

}  // namespace vdisp
