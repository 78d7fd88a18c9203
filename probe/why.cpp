// why.cpp: vdisp-probe why: the verdict on one cell of the map, or on one pixel, back to disparities, floor and thresholds.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "probe/evidence.h"
#include "probe/format.h"
#include "probe/frame_set.h"
#include "probe/height_limits.h"
#include "probe/readout.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

using nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1e3) / 1e3; }

enum Stage { disparity, surface, height, standing, floor_model, occupancy, reason, count_map, stages };
constexpr std::array<const char*, stages> stage_names{"disparity",   "surface",   "height", "standing",
                                                      "floor_model", "occupancy", "reason", "map"};

/// The images of one frame. Floor and grid are to be looked at where the frame is not blind.
struct Frame {
  const FrameSet& set;
  const Image& operator[](Stage stage) const { return set.image(stage); }
  const FloorModel* floor() const { return record_of<FloorModel>((*this)[floor_model]); }
  /// Why there is no verdict in this frame; none if there is one.
  Reason blind() const {
    for (Stage stage : {occupancy, reason, count_map, surface, height, standing, floor_model, disparity})
      if (!(*this)[stage].valid()) return (*this)[stage].reason;
    return Reason::none;
  }
};

/// Lines of words, and the same as JSON.
struct Account {
  std::string text;
  ordered_json json;
  void line(const char* title, const std::string& words) { text += format("%-13s", title) + words + "\n"; }
};

void tell_frame(const Frame& frame, Account& account) {
  const Image& image = frame[occupancy];
  const bool synthetic = (image.flags & flag_synthetic) != 0;
  account.line("frame", std::to_string(image.sequence) + (synthetic ? ", synthetic" : ""));
  account.json["sequence"] = image.sequence;
  account.json["synthetic"] = synthetic;
  const Reason why = frame.blind();
  account.json["state"] = why == Reason::none ? "fresh" : "blind";
  account.json["reason"] = name(why);
  if (why != Reason::none) account.line("BLIND", std::string(describe(why)));
}

void tell_floor(const FloorModel& floor, Account& account) {
  constexpr double degrees = 180 / M_PI;
  const char* state = floor.state == FloorState::held ? "held" : "found";
  account.line("floor", format("%s, camera %.3f m over it, pitch %.2f deg, roll %.2f deg", state, floor.height_m, floor.pitch_rad * degrees,
                               floor.roll_rad * degrees));
  account.json["floor"] = {{"state", state},
                           {"height_m", rounded(floor.height_m)},
                           {"pitch_deg", rounded(floor.pitch_rad * degrees)},
                           {"roll_deg", rounded(floor.roll_rad * degrees)}};
}

/// What occupancy, reason and map say of a cell.
void tell_verdict(const Frame& frame, const MapCell& cell, Account& account) {
  const GridGeometry& grid = frame[occupancy].grid;
  const Place place = place_of(grid, cell.column, cell.row);
  const int percent = frame[occupancy].row<int8_t>(cell.row)[cell.column];
  const CellReason why{frame[reason].row<uint8_t>(cell.row)[cell.column]};
  const int points = frame[count_map].row<int16_t>(cell.row)[cell.column], around = points_around(frame[count_map], cell);
  account.line("cell", format("row %d  column %d   z %.2f m  x %+.2f m   %.2f m away, bearing %+.0f deg", cell.row, cell.column, place.z,
                              place.x, place.distance(), place.bearing_deg()));
  account.line("verdict", std::string(name(why)) + ": " + std::string(describe(why)));
  account.line("occupancy", (percent < 0 ? "unknown" : std::to_string(percent) + " %") + "   (free up to " + std::to_string(free_up_to) +
                                " %, an obstacle from " + std::to_string(occupied_from) + " % on)");
  account.line("map",
               format("%d points   (an obstacle from %u on); with its nearer and farther neighbours %d", points, grid.min_count, around));
  account.json["cell"] = {{"row", cell.row},
                          {"column", cell.column},
                          {"x", rounded(place.x)},
                          {"z", rounded(place.z)},
                          {"distance", rounded(place.distance())},
                          {"bearing_deg", rounded(place.bearing_deg())},
                          {"verdict", name(why)},
                          {"occupancy", percent < 0 ? ordered_json(nullptr) : ordered_json(percent)},
                          {"free_up_to", free_up_to},
                          {"occupied_from", occupied_from},
                          {"points", points},
                          {"points_around", around},
                          {"min_count", grid.min_count}};
}

/// "floor 120, obstacle 3", and as JSON.
template <class NameOf>
std::pair<std::string, ordered_json> counts_of(const std::array<int, 256>& counts, NameOf name_of_code) {
  std::string words;
  ordered_json json = ordered_json::object();
  for (size_t code = 0; code < counts.size(); ++code) {
    const std::string meaning(name_of_code(static_cast<uint8_t>(code)));
    if (counts[code] == 0 || meaning.empty()) continue;
    words += (words.empty() ? "" : ", ") + meaning + " " + std::to_string(counts[code]);
    json[meaning] = counts[code];
  }
  return {words.empty() ? "-" : words, json};
}

void tell_standing(const Standing& at, Account& account) {
  ordered_json& json = account.json["standing"] = {{"pixels", at.pixels}, {"filled", at.filled}};
  if (at.pixels == 0) return account.line("standing", "no pixel of an obstacle stands in it");
  account.line("standing", format("%d pixels of obstacles stand in it: rows %d to %d, columns %d to %d, %.2f to %.2f px", at.pixels, at.top,
                                  at.bottom, at.left, at.right, at.least, at.most));
  if (at.filled > 0) account.line("filled", format("%d of them have no match of their own: an even surface between its edges", at.filled));
  json.update({{"rows", {at.top, at.bottom}}, {"columns", {at.left, at.right}}, {"disparities", {rounded(at.least), rounded(at.most)}}});
}

void tell_view(const Frame& frame, const CellView& view, Account& account) {
  ordered_json& json = account.json["view"];
  if (view.empty()) {
    account.line("in the image", "its floor lies outside the left view");
    json = nullptr;
    return;
  }
  const Tally tally = tally_of(frame[disparity], frame[surface], view);
  const auto [surfaces, surfaces_json] = counts_of(tally.surfaces, [](uint8_t code) { return name(Surface{code}); });
  const auto [rejected, rejected_json] = counts_of(tally.rejected, [](uint8_t code) { return code ? name(Rejected{code}) : ""; });
  const int all = (view.right - view.left) * (view.bottom - view.top);
  account.line("in the image", format("its floor lies in rows %d to %d, columns %d to %d: %d pixels; floor has %.2f to %.2f px there",
                                      view.top, view.bottom - 1, view.left, view.right - 1, all, view.disparity_far, view.disparity_near));
  account.line("surface", surfaces);
  account.line("depth", format("as the cell %d, nearer %d, farther %d   (within %.0f px and %.0f %%)", tally.there, tally.nearer,
                               tally.farther, depth_off, 100 * depth_share));
  account.line("no disparity", rejected);
  json = {{"rows", {view.top, view.bottom - 1}},
          {"columns", {view.left, view.right - 1}},
          {"pixels", all},
          {"floor_disparities", {rounded(view.disparity_far), rounded(view.disparity_near)}},
          {"surface", surfaces_json},
          {"depth", {{"as_cell", tally.there}, {"nearer", tally.nearer}, {"farther", tally.farther}}},
          {"rejected", rejected_json}};
}

void tell_cell(const Frame& frame, const MapCell& cell, Account& account) {
  const FloorModel* floor = frame.floor();
  if (frame.blind() != Reason::none || !floor) return;
  tell_verdict(frame, cell, account);
  const Reprojection reprojection(frame[disparity], *floor, frame[occupancy]);
  if (!reprojection.possible()) return;
  tell_standing(standing_in(cell, frame[standing], frame[surface], reprojection), account);
  tell_view(frame, reprojection.view_of(cell), account);
  tell_floor(*floor, account);
}

/// The disparity, or why there is none; nothing is known without the matcher.
std::optional<double> tell_disparity(const Frame& frame, int row, int column, Account& account) {
  ordered_json& json = account.json["pixel"] = {{"row", row}, {"column", column}};
  account.line("pixel", format("row %d  column %d", row, column));
  if (!frame[disparity].valid()) return {};
  const int16_t raw = frame[disparity].row<int16_t>(row)[column];
  if (const uint8_t code = rejected_code(raw)) {
    account.line("disparity", "none: " + std::string(name(Rejected{code})));
    json.update({{"disparity", nullptr}, {"rejected", name(Rejected{code})}});
    return {};
  }
  account.line("disparity", format("%.2f px", raw / 16.0));
  json["disparity"] = rounded(raw / 16.0);
  return raw / 16.0;
}

/// Its height over the local floor with the limits, and what else made it this surface.
void tell_height(std::optional<double> height, Surface what, const HeightLimits& limits, Account& account) {
  const std::string from = limits.known()
                               ? format("   (an obstacle from %.3g m on, passed below from %.3g m on)", limits.max_height, limits.clearance)
                               : "   (limits not known: the control socket of this daemon does not answer)";
  if (height) account.line("height", format("%+.3f m over the local floor", *height) + from);
  const std::string also = beyond_height(height.value_or(NAN), what, limits);
  account.line("surface", std::string(name(what)) + (also.empty() ? "" : ": " + also));
  account.json["pixel"].update({{"height", height ? ordered_json(*height) : ordered_json(nullptr)},
                                {"max_height", limits.max_height},
                                {"clearance", limits.clearance},
                                {"surface", name(what)},
                                {"because", also.empty() ? ordered_json(nullptr) : ordered_json(also)}});
}

void tell_pixel(const Frame& frame, int row, int column, const HeightLimits& limits, Account& account) {
  const std::optional<double> d = tell_disparity(frame, row, column, account);
  const FloorModel* floor = frame.floor();
  if (frame.blind() != Reason::none || !floor) return;
  const Reprojection reprojection(frame[disparity], *floor, frame[occupancy]);
  if (!reprojection.possible()) return;
  const int16_t mm = frame[height].row<int16_t>(row)[column];
  const Surface what{frame[surface].row<uint8_t>(row)[column]};
  const bool filled = what == Surface::filled;
  const double by_edges = filled ? frame[standing].row<int16_t>(row)[column] / 16.0 : NAN;
  const double depth = d ? reprojection.depth(*d).value_or(NAN) : NAN;  // NaN is null in JSON
  const auto on_floor = reprojection.floor_disparity(column, row);
  if (depth > 0) account.line("depth", format("%.2f m along the view", depth));
  tell_height(mm == height_unknown ? std::nullopt : std::optional(mm / 1000.0), what, limits, account);
  if (filled) account.line("filled", format("%.2f px by the edges of the even surface that it is part of", by_edges));
  account.line("plane", on_floor ? format("floor would have %.2f px here", *on_floor) : "above the horizon: no floor here");
  account.json["pixel"].update(
      {{"depth", rounded(depth)}, {"filled_disparity", rounded(by_edges)}, {"floor_disparity", rounded(on_floor.value_or(NAN))}});
  tell_floor(*floor, account);
  // What has no disparity may be floor: the cell that would be seen here.
  const auto at = d ? d : filled ? std::optional(by_edges) : on_floor;
  const auto cell = at ? reprojection.cell_of(column, row, *at) : std::nullopt;
  if (!cell) return account.line("cell", at ? "none: it stands outside the map" : "none: no disparity, and no floor here");
  if (!d && !filled) account.line("as floor", "it would lie in this cell:");
  tell_verdict(frame, *cell, account);
}

void require_inside(const Options& options, const Image& image, const char* what, const char* other) {
  if (options.row < image.spec.height && options.column < image.spec.width) return;
  throw ProbeError(64, format("row %d, column %d: the %s has rows 0 to %d and columns 0 to %d; %s", options.row, options.column, what,
                              image.spec.height - 1, image.spec.width - 1, other));
}

void require_verdicts(const std::vector<CatalogueEntry>& topics) {
  for (const char* needed : {"surface", "reason"})
    if (std::none_of(topics.begin(), topics.end(), [&](const CatalogueEntry& entry) { return name_of(entry) == needed; }))
      throw ProbeError(
          64, std::string("the daemon has no stage '") + needed + "', which explains the map; [Floor] model must be plane or profile");
}

/// Throws where the images do not belong together.
void require_fitting(const Frame& frame) {
  constexpr std::array<Pixel, stages> kinds{Pixel::disparity16, Pixel::gray8, Pixel::height16, Pixel::disparity16,
                                            Pixel::record,      Pixel::int8,  Pixel::gray8,    Pixel::count16};
  const auto fits = [&](Stage stage) {
    const Image& like = stage < floor_model ? frame[disparity] : frame[occupancy];
    const bool size = stage == floor_model || (frame[stage].spec.width == like.spec.width && frame[stage].spec.height == like.spec.height);
    return frame[stage].spec.pixel == kinds[stage] && size;
  };
  for (int i = 0; i < stages; ++i)
    if (const auto stage = static_cast<Stage>(i); !fits(stage))
      throw ProbeError(69, std::string("stage '") + stage_names[i] + "' is " + spec_words(frame[stage].spec) +
                               ", which this version cannot explain; daemon and probe must be of one version");
}

}  // namespace

int why(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  require_verdicts(topics_of(client));
  FrameSet set(client, {stage_names.begin(), stage_names.end()});
  if (!set.next()) return 0;
  const Frame frame{set};
  require_fitting(frame);
  Account account;
  tell_frame(frame, account);
  if (options.pixel) {
    require_inside(options, frame[disparity], "left view", "for a cell of the map leave --pixel out");
    tell_pixel(frame, options.row, options.column, limits_of(options.control), account);
  } else {
    require_inside(options, frame[occupancy], "map", "for a pixel of the left view use --pixel");
    tell_cell(frame, {options.row, options.column}, account);
  }
  print(options.json ? account.json.dump() + "\n" : account.text);
  return 0;
}

}  // namespace vdisp
