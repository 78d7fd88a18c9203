// dump_json.cpp: what is no picture in a dump, as members of frame.json.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/dump_json.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string>

namespace vdisp {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

// A float says 0.1 where it means 0.1, not 0.10000000149.
ordered_json number(float value) {
  char text[32];
  double shortest = static_cast<double>(value);
  std::from_chars(text, std::to_chars(text, text + sizeof text, value).ptr, shortest);
  return number(shortest);
}

const char* key(Rejected why) {
  switch (why) {
    case Rejected::low_texture: return "low_texture";
    case Rejected::not_unique: return "not_unique";
    case Rejected::left_right: return "left_right";
    case Rejected::speckle: return "speckle";
    case Rejected::outside: return "outside";
    case Rejected::matcher: return "matcher";
    case Rejected::infinity: return "infinity";
  }
  return "unknown";
}

const char* state_word(FloorState state) { return state == FloorState::found ? "found" : state == FloorState::held ? "held" : "lost"; }

const char* model_word(FloorKind kind) { return kind == FloorKind::plane ? "plane" : kind == FloorKind::profile ? "profile" : "line"; }

}  // namespace

ordered_json floor_json(const Image& image) {
  const FloorModel* floor = image.valid() ? record_of<FloorModel>(image) : nullptr;
  ordered_json json;
  json["state"] = floor ? state_word(floor->state) : "lost";
  json["model"] = model_word(floor ? floor->model : FloorKind::line);
  const double none = NAN;
  json["a"] = number(floor ? floor->a : none);
  json["b"] = number(floor ? floor->b : none);
  json["pitch_rad"] = number(floor ? floor->pitch_rad : none);
  json["roll_rad"] = number(floor ? floor->roll_rad : none);
  json["height_m"] = number(floor ? floor->height_m : none);
  json["confidence"] = floor ? number(floor->confidence) : ordered_json(0.0);
  json["reason"] = name(floor ? floor->reason : image.reason);
  json["points"] = floor ? floor->points : 0;
  json["mounting_differs"] = floor && floor->mounting_differs != 0;
  json["tilt"] = number(floor ? floor->tilt : none);
  json["steady_pitch_rad"] = number(floor ? floor->steady_pitch_rad : none);
  json["steady_roll_rad"] = number(floor ? floor->steady_roll_rad : none);
  json["steady_height_m"] = number(floor ? floor->steady_height_m : none);
  json["held_s"] = number(floor ? floor->held_s : none);
  json["gravity_pitch_rad"] = number(floor ? floor->gravity_pitch_rad : none);
  json["gravity_roll_rad"] = number(floor ? floor->gravity_roll_rad : none);
  json["imu"] = name(floor ? floor->imu : ImuUse::none);
  json["gravity_differs"] = floor && floor->gravity_differs != 0;
  json["profile_seen"] = floor ? floor->profile_seen : 0;
  json["profile"] = ordered_json::array();
  for (uint32_t i = 0; floor && i < std::min(floor->profile_count, FloorModel::profile_capacity); ++i) {
    json["profile"].push_back(
        {{"ahead_m", number(static_cast<double>(floor->profile_start_m + static_cast<float>(i) * floor->profile_step_m))},
         {"height_m", number(static_cast<double>(floor->profile_m[i]))}});
  }
  return json;
}

uint64_t filled_pixels(const Image& surface) {
  uint64_t filled = 0;
  for (int v = 0; v < surface.spec.height; ++v) {
    const uint8_t* row = surface.row<uint8_t>(v);
    filled += static_cast<uint64_t>(std::count(row, row + surface.spec.width, static_cast<uint8_t>(Surface::filled)));
  }
  return filled;
}

ordered_json scene_json(const TruthScene& scene) {
  static constexpr const char* kinds[] = {"unknown", "box", "post", "wall", "rock", "beam"};
  ordered_json json{{"pitch_rad", number(scene.pitch_rad)},
                    {"roll_rad", number(scene.roll_rad)},
                    {"height_m", number(scene.height_m)},
                    {"slope_rad", number(scene.slope_rad)},
                    {"rover", {{"x_m", number(scene.x_m)}, {"y_m", number(scene.y_m)}, {"yaw_rad", number(scene.yaw_rad)}}},
                    {"foot_m", number(scene.foot_m)},
                    {"crest_m", number(scene.crest_m)},
                    {"drop", nullptr},
                    {"objects", ordered_json::array()}};
  for (uint32_t i = 0; i < std::min(scene.count, TruthScene::capacity); ++i) {
    const TruthObject& object = scene.objects[i];
    const auto kind = static_cast<uint32_t>(object.kind);
    json["objects"].push_back({{"number", i + 1},
                               {"kind", kinds[kind < std::size(kinds) ? kind : 0]},
                               {"textured", object.textured != 0},
                               {"x", number(object.x)},
                               {"z", number(object.z)},
                               {"width", number(object.width)},
                               {"depth", number(object.depth)},
                               {"height", number(object.height)},
                               {"yaw", number(object.yaw)},
                               {"base", number(object.base)},
                               {"bottom", number(object.bottom)}});
  }
  if (const TruthDrop& drop = scene.drop; drop.depth > 0)
    json["drop"] = {{"depth", number(drop.depth)},
                    {"across", number(drop.across)},
                    {"left", {number(drop.left_x), number(drop.left_z)}},
                    {"right", {number(drop.right_x), number(drop.right_z)}}};
  return json;
}

namespace {
const InputTally* tally_of(const Image& image) {
  if (const Odometry* odometry = record_of<Odometry>(image)) return &odometry->tally;
  if (const Imu* imu = record_of<Imu>(image)) return &imu->tally;
  if (const DriveOrder* drive = record_of<DriveOrder>(image)) return &drive->tally;
  const Events* events = record_of<Events>(image);
  return events ? &events->tally : nullptr;
}
}  // namespace

ordered_json input_json(const Image& image) {
  ordered_json json;
  if (const InputTally* tally = tally_of(image))
    json = {
        {"accepted", tally->accepted}, {"refused", tally->refused}, {"last_refusal", name(tally->last_refusal)}, {"new", tally->in_step}};
  if (!image.valid()) return json;
  json["timestamp_ns"] = image.timestamp_ns;
  const auto three = [](const double(&values)[3]) { return ordered_json{number(values[0]), number(values[1]), number(values[2])}; };
  if (const Odometry* o = record_of<Odometry>(image)) {
    json.update({{"age_s", number(o->age_s)},
                 {"x", number(o->x)},
                 {"y", number(o->y)},
                 {"z", number(o->z)},
                 {"roll", number(o->roll)},
                 {"pitch", number(o->pitch)},
                 {"yaw", number(o->yaw)},
                 {"speed", number(o->speed)},
                 {"turn_rate", number(o->turn_rate)},
                 {"frame", o->frame}});
  } else if (const Imu* i = record_of<Imu>(image)) {
    json.update({{"age_s", number(i->age_s)},
                 {"acceleration", three(i->acceleration)},
                 {"rate", three(i->rate)},
                 {"roll", number(i->roll)},
                 {"pitch", number(i->pitch)}});
  } else if (const DriveOrder* d = record_of<DriveOrder>(image)) {
    json.update({{"age_s", number(d->age_s)}, {"speed", number(d->speed)}, {"turn_rate", number(d->turn_rate)}});
  } else if (const Events* e = record_of<Events>(image)) {
    json["age_s"] = number(e->age_s);
    json["labels"] = ordered_json::array();
    for (uint32_t n = 0; n < std::min(e->count, Events::capacity); ++n) json["labels"].push_back(std::string(e->entries[n].text()));
  }
  return json;
}

ordered_json changes_json(const MapChanges& changes) { return {{"generation", changes.generation}, {"count", changes.count}}; }

ordered_json memory_json(const Memory& memory) {
  return {
      {"state", name(memory.state)}, {"cause", name(memory.cause)}, {"forgotten", memory.forgotten}, {"x", number(memory.x)},
      {"y", number(memory.y)},       {"yaw", number(memory.yaw)},   {"lag_s", number(memory.lag_s)}, {"since_s", number(memory.since_s)}};
}

ordered_json tracks_json(const Tracks& tracks) {
  ordered_json json{{"frame", tracks.frame}, {"tracks", ordered_json::array()}};
  for (uint32_t i = 0; i < std::min(tracks.count, Tracks::capacity); ++i) {
    const Track& t = tracks.tracks[i];
    json["tracks"].push_back({{"id", t.id},
                              {"moving", (t.flags & Track::moving) != 0},
                              {"seen", (t.flags & Track::seen) != 0},
                              {"cut", (t.flags & Track::cut) != 0},
                              {"x", number(t.x)},
                              {"y", number(t.y)},
                              {"speed_x", number(t.speed_x)},
                              {"speed_y", number(t.speed_y)},
                              {"speed_deviation", number(t.speed_deviation)},
                              {"size_x", number(t.size_x)},
                              {"size_y", number(t.size_y)},
                              {"height", number(t.height)},
                              {"age_s", number(t.age_s)},
                              {"unseen_s", number(t.unseen_s)}});
  }
  return json;
}

ordered_json scores_json(const SnowScores& s) {
  return {{"free", number(s.free)},
          {"obstacle", number(s.obstacle)},
          {"left", number(s.left)},
          {"right", number(s.right)},
          {"free_difference", number(s.free_difference)},
          {"left_difference", number(s.left_difference)},
          {"obstacle_sensitivity", number(s.obstacle_sensitivity)},
          {"direction_sensitivity", number(s.direction_sensitivity)},
          {"clear", number(s.clear)},
          {"encoding", s.encoding},
          {"active", s.active}};
}

ordered_json decision_json(const Decision& d) {
  return {{"steering", name(d.steering)},
          {"decider", name(d.decider)},
          {"clearness", number(d.clearness)},
          {"since_s", number(d.since_s)},
          {"changes", d.changes}};
}

ordered_json command_json(const DriveCommand& c) {
  return {{"speed", number(c.speed)},
          {"turn_rate", number(c.turn_rate)},
          {"steering", name(c.steering)},
          {"decider", name(c.decider)},
          {"slowed", c.slowed != 0}};
}

ordered_json check_json(const CrossCheck& c) {
  return {{"agree", c.agree != 0},
          {"map_free", c.map_free != 0},
          {"snow_free", c.snow_free != 0},
          {"corridor_m", number(c.corridor_m)},
          {"disagreeing_s", number(c.disagreeing_s)},
          {"agreed", c.agreed},
          {"only_map_free", c.only_map_free},
          {"only_snow_free", c.only_snow_free}};
}

ordered_json cameras_json(const CameraStatus& status) {
  ordered_json json{{"pairs", status.pairs},           {"skipped", status.skipped},          {"apart_ms", number(status.apart_ms)},
                    {"age_ms", number(status.age_ms)}, {"exchanged", status.exchanged != 0}, {"cameras", status.cameras}};
  const char* const sides[] = {"left", "right"};
  for (size_t side = 0; side < std::size(sides); ++side) {
    const CameraView& view = status.view[side];
    json[sides[side]] = {{"open", view.open != 0},
                         {"opened", view.opened},
                         {"frames", view.frames},
                         {"incomplete", view.incomplete},
                         {"unpaired", view.unpaired},
                         {"refused", view.refused},
                         {"exposure_us", number(view.exposure_us)},
                         {"gain_db", number(view.gain_db)},
                         {"floor_level", number(view.floor_level)},
                         {"dark", number(view.dark)},
                         {"bright", number(view.bright)}};
  }
  return json;
}

ordered_json watch_json(const CalibrationWatch& watch) {
  return {{"state", name(watch.state)},
          {"points", watch.points},
          {"window_s", number(watch.window_s)},
          {"median_px", number(watch.median_px)},
          {"p90_px", number(watch.p90_px)},
          {"shift_px", number(watch.shift_px)},
          {"shift_deviation_px", number(watch.shift_deviation_px)},
          {"rotation_rad", number(watch.rotation_rad)},
          {"rotation_deviation_rad", number(watch.rotation_deviation_rad)},
          {"limit_px", number(watch.limit_px)},
          {"drifts", watch.drifts}};
}

ordered_json camera_json(const CameraGeometry& camera) {
  return {{"f", number(camera.f)},
          {"cx", number(camera.cx)},
          {"cy", number(camera.cy)},
          {"baseline", number(camera.baseline)},
          {"cx_offset", number(camera.cx_offset)},
          {"min_disparity", camera.min_disparity},
          {"disparities", camera.disparities}};
}

ordered_json grid_json(const GridGeometry& grid) {
  return {{"cell", number(grid.cell)},
          {"origin_row", number(grid.origin_row)},
          {"origin_column", number(grid.origin_column)},
          {"view_left", number(grid.view_left)},
          {"view_right", number(grid.view_right)},
          {"min_count", grid.min_count},
          {"frame", grid.frame},
          {"pose", {number(grid.pose_x), number(grid.pose_y), number(grid.pose_yaw)}}};
}

uint8_t dumped_code(int16_t disparity) {
  if (const uint8_t code = rejected_code(disparity)) return code;
  return disparity > 0 ? uint8_t{0} : static_cast<uint8_t>(Rejected::infinity);
}

ordered_json rejected_json(const Image& image) {
  uint64_t counts[256] = {};
  for (int y = 0; y < image.spec.height; ++y) {
    const int16_t* row = image.row<int16_t>(y);
    for (int x = 0; x < image.spec.width; ++x) ++counts[dumped_code(row[x])];
  }
  ordered_json json{{"measured", counts[0]}};
  for (uint8_t code = 1; code <= static_cast<uint8_t>(Rejected::infinity); ++code) json[key(Rejected{code})] = counts[code];
  return json;
}

}  // namespace vdisp
