// records.h: results that are no picture: fixed structs that travel as images of kind record.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image.h"  // beside this file in the tree and where it is installed

namespace vdisp {

enum class RecordType : uint16_t {
  none = 0,
  floor_model = 1,
  catalogue = 2,
  heartbeat = 3,
  truth_scene = 4,
  odometry = 5,
  imu = 6,
  drive = 7,
  event = 8,
  map_changes = 9,
  memory = 10,
  tracks = 11,
  camera_status = 12,
};

/// First member of each record: what it is, so that a reader can refuse what it does not know.
struct RecordHeader {
  RecordType type;
  uint16_t version;
  uint32_t bytes;
};

enum class FloorState : uint32_t { lost = 0, found = 1, held = 2 };
enum class FloorKind : uint32_t { line = 1, plane = 2, profile = 3 };

/// What became of the sample of `in/imu` in the search for the floor.
enum class ImuUse : uint32_t {
  none = 0,          ///< there is none
  used = 1,          ///< it tells how the camera turned since the last floor
  settling = 2,      ///< the first one, or [mounting] pitch is not known yet: nothing to compare with
  late = 3,          ///< older than 0.1 s
  accelerating = 4,  ///< what it measures is more or less than gravity
  jumped = 5,        ///< it turns faster than a rover can
  askew = 6,         ///< it lies on its side or upside down
  contradicts = 7,   ///< the images show a floor that turns otherwise
};

/// The floor of one frame: true disparity d' = (v - b) / (16 a) + tilt (u - cx) at column u, row v, px (0 at infinity,
/// CameraGeometry::cx_offset). The line knows no tilt. A profile stands on its plane: the local floor is higher than it by profile_m.
struct FloorModel {
  static constexpr RecordType type = RecordType::floor_model;
  static constexpr uint16_t version = 3;
  static constexpr uint32_t profile_capacity = 64;
  RecordHeader header;
  FloorState state;
  FloorKind model;
  double a;                   ///< rows per column of the v-disparity, that is per 1/16 px; 0 when lost
  double b;                   ///< row at d' = 0 in the middle column, cx
  double pitch_rad;           ///< positive: the camera looks down; NaN without calibration or floor
  double roll_rad;            ///< positive: right side low; NaN where the model does not measure it
  double height_m;            ///< of the camera over the floor; NaN without calibration or floor
  double confidence;          ///< 0..1: line: share of the votes that lie on it; plane: of what is on it or beyond it, and of a good number
  Reason reason;              ///< why lost or held, or what could not be measured
  uint32_t points;            ///< points that lie on the floor; how many there were, when lost
  uint32_t mounting_differs;  ///< 1: pitch or height lie outside the tolerances of [mounting]
  uint32_t profile_count;     ///< elements of profile_m; 0: none
  double tilt;                ///< px of disparity per column
  double steady_pitch_rad, steady_roll_rad, steady_height_m;  ///< filtered over some seconds; NaN where not known
  double held_s;                                              ///< age of a held floor
  float profile_start_m, profile_step_m;                      ///< ground distance of profile_m[0], and from one to the next
  float profile_m[profile_capacity];                          ///< height of the local floor over the plane
  double gravity_pitch_rad, gravity_roll_rad;  ///< of the camera against the vertical, by the IMU, filtered likewise; NaN: not known
  ImuUse imu;
  uint32_t
      gravity_differs;  ///< 1: filtered, they are not those over the floor, by more than [mounting] pitchTolerance: a slope, or a fault
};

/// How CatalogueEntry::parents names an input that is of the frame before; twice gives the index back.
constexpr int16_t delayed_parent(int entry) { return static_cast<int16_t>(-2 - entry); }

/// One stage in the catalogue. Times in ns of the stage that made it; several topics of one stage share them.
struct CatalogueEntry {
  char name[48];
  ImageSpec spec;
  int16_t parents[4];  ///< indices into the catalogue, -1: none, below: delayed_parent() of an index
  uint32_t stage;      ///< which stage of the tree made it: entries of one stage have the same number
  uint32_t watched;    ///< 1: a reader is attached
  uint64_t runs, invalid, drops;
  int64_t last_ns, mean_ns, max_ns;
};

/// Published once a second as topic `catalogue`.
struct Catalogue {
  static constexpr RecordType type = RecordType::catalogue;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 64;
  RecordHeader header;
  uint64_t steps, blind_steps;
  int64_t period_ns;     ///< median time from step to step of the last 32
  int64_t step_mean_ns;  ///< mean time inside a step
  uint32_t count;
  uint32_t unused;
  CatalogueEntry entries[capacity];
};

/// Published several times a second as topic `heartbeat`, also while the daemon waits for a frame.
struct Heartbeat {
  static constexpr RecordType type = RecordType::heartbeat;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint64_t steps;
  int64_t now_ns;     ///< CLOCK_MONOTONIC
  int64_t period_ns;  ///< median time from step to step of the last 32, 0 before the third
};

enum class ObjectKind : uint32_t { box = 1, post, wall, rock, beam };

/// One obstacle of the simulator, in the camera's true horizontal frame h at the moment of exposure.
struct TruthObject {
  ObjectKind kind;
  uint32_t textured;   ///< 1: enough texture to be matched
  float x, z;          ///< m, centre of the footprint
  float width, depth;  ///< m, along its own axes
  float height;        ///< m above the ground at its place
  float yaw;           ///< rad about the vertical
  float base;          ///< m, of the ground at its place over the ground below the camera
  float bottom;        ///< m above the ground at its place, of what hangs over it; 0: it stands on the ground
};

/// Where the ground falls away before the rover, in the same frame.
struct TruthDrop {
  float depth;             ///< m; 0: nowhere
  float across;            ///< m from the near edge to the far one; 0: it has none
  float left_x, left_z;    ///< m, left end of the near edge, at most 20 m aside
  float right_x, right_z;  ///< m, its right end
};

/// What a cell of the map truly is, the values of `truth/map_cells`. The first that holds of: an obstacle higher than max_height stands
/// or hangs lower than 1 m over a part of it; an edge goes through it; its ground is outside the picture; less than a fifth of its
/// ground is seen, or all of it takes less than a quarter of a row; something hangs over it at 1 m or more; it is the bottom of a
/// drop-off.
enum class TruthCell : uint8_t { outside = 0, free = 1, obstacle = 2, drop_off = 3, overhang = 4, hidden = 5, below = 6 };

/// The simulator's truth for one frame, topic `truth/scene`. Objects are numbered from 1 as in `truth/object`.
struct TruthScene {
  static constexpr RecordType type = RecordType::truth_scene;
  static constexpr uint16_t version = 2;
  static constexpr uint32_t capacity = 32;
  RecordHeader header;
  double pitch_rad, roll_rad, height_m;  ///< of the camera over the ground below it
  double slope_rad;                      ///< of the ground ahead, positive: rising
  uint32_t count;
  uint32_t unused;
  TruthObject objects[capacity];
  double x_m, y_m, yaw_rad;  ///< of the rover in the world (REP-103: x ahead, y left of its start, yaw to the left)
  double foot_m;             ///< m ahead where the slope begins; 0: there is none ahead
  double crest_m;            ///< m ahead where the ground begins to fall away as a slope; 0: nowhere
  TruthDrop drop;
};

static_assert(sizeof(FloorModel) == 408 && sizeof(CatalogueEntry) == 120 && sizeof(Heartbeat) == 32);
/// Why a message of the control socket was refused.
enum class Refusal : uint32_t {
  none = 0,
  not_finite,    ///< NaN or infinite where a number is needed
  out_of_range,  ///< no rover does that: see docs/control.md
  backwards,     ///< not newer than what was accepted before
  late,          ///< older than [control] maxAge
  ahead,         ///< from the future: the sender's clock is not CLOCK_MONOTONIC
  jump,          ///< farther from the sample before than [control] maxSpeed and maxTurn allow
  other_sender,  ///< another process sends the same already
  recorded,      ///< the recording or the simulator tells it
  count
};

/// What became of the messages of one kind. Counts are since the start of the daemon.
struct InputTally {
  uint64_t accepted, refused;
  Refusal last_refusal;  ///< none: nothing was refused yet
  uint32_t in_step;      ///< accepted since the step before
};

/// `in/odometry`: the newest accepted odometry. REP-103 odometry frame: x forward, y left, z up at its start; NaN: not told.
/// Of a blind image, too, the record can be read: its tally says why nothing is there.
struct Odometry {
  static constexpr RecordType type = RecordType::odometry;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;                      ///< of the measurement, CLOCK_MONOTONIC; of a recording: of its frame
  double age_s;                              ///< at the start of this step; 0 of a recording and of the simulator
  double x, y, z;                            ///< m
  double roll, pitch, yaw;                   ///< rad; positive: right side low, nose down, to the left
  double speed, turn_rate;                   ///< m/s ahead, rad/s to the left
  double position_deviation, yaw_deviation;  ///< standard deviations, m and rad
  uint32_t frame;                            ///< changes when the odometry began anew elsewhere: what was fused before is void
  uint32_t unused;
  InputTally tally;
};

/// `in/imu`: the newest accepted sample, in the rover frame r.
struct Imu {
  static constexpr RecordType type = RecordType::imu;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;
  double age_s;
  double acceleration[3];  ///< m/s^2; at rest it points up
  double rate[3];          ///< rad/s; NaN: not measured
  double roll, pitch;      ///< rad, of the rover, if the acceleration is gravity alone; positive: right side low, nose down
  InputTally tally;
};

/// `in/drive`: what the rover was last told to do.
struct DriveOrder {
  static constexpr RecordType type = RecordType::drive;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;
  double age_s;
  double speed, turn_rate;  ///< m/s ahead, rad/s to the left
  InputTally tally;
};

/// `in/event`: the last events, newest first. tally.in_step tells how many are new; of more than `capacity` the oldest are lost.
struct Events {
  static constexpr RecordType type = RecordType::event;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 8;
  struct Entry {
    int64_t timestamp_ns;
    char label[48];
  };
  RecordHeader header;
  double age_s;  ///< of the newest
  uint32_t count, unused;
  Entry entries[capacity];
  InputTally tally;
};

static_assert(sizeof(Odometry) == 136 && sizeof(Imu) == 112 && sizeof(DriveOrder) == 64 && sizeof(Events) == 496);

/// One word for files, one phrase for people.
std::string_view name(ImuUse use);
std::string_view describe(ImuUse use);
std::string_view name(Refusal refusal);
std::string_view describe(Refusal refusal);

/// One cell of `occupancy` that is other than it was.
struct ChangedCell {
  uint16_t row, column;  ///< as in the image: row 0 is farthest
  int8_t value;          ///< the new one: -1 unknown, 0..100
  uint8_t unused;
};

/// Why the list of MapChanges is no list, and the whole grid has to be read.
enum class WholeGrid : uint32_t {
  no = 0,           ///< it need not: the list is complete
  first = 1,        ///< nothing to compare with: the first grid of this daemon (see Image::epoch)
  after_blind = 2,  ///< since the last grid there were frames without one, in which all cells were unknown
  moved = 3,        ///< the grid lies elsewhere or has other cells
  overflow = 4,     ///< more cells changed than the list holds
};

/// What changed in the `occupancy` of the same frame (same sequence) since the last one, topic `map_changes`. For planners that plan
/// again only where something changed. `generation` is one more with each frame in which anything changed, and starts at 1 with each epoch
/// (Image::epoch, in the header of the image that carries the record). Who has a copy of the grid at generation G of the same epoch:
///   generation == G                      has all of it, nothing changed;
///   previous == G and whole == no        writes the `count` cells of the list into the copy;
///   else                                 missed something, or there is no list: reads the whole grid.
/// A blind image of this topic has no record: all cells are unknown. The first record after it says after_blind.
struct MapChanges {
  static constexpr RecordType type = RecordType::map_changes;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 1024;
  RecordHeader header;
  uint64_t generation;
  uint64_t previous;  ///< generation of the last frame that had a grid; 0 where there is none; == generation: nothing changed
  WholeGrid whole;
  uint32_t count;    ///< cells in the list, in the order of rows and columns; 0 where the whole grid has to be read
  uint32_t changed;  ///< cells that are other than in the last grid, listed or not; all of them where nothing can be compared
  uint32_t unused;
  ChangedCell cells[capacity];
};

static_assert(sizeof(ChangedCell) == 6 && sizeof(MapChanges) == 40 + 6 * MapChanges::capacity);

enum class MemoryState : uint32_t { frame_only = 0, fused = 1 };
/// Why nothing is remembered, or why what was remembered was forgotten last.
enum class MemoryCause : uint32_t {
  none = 0,
  no_odometry,   ///< none for [control] maxAge, or ever, or no numbers
  late,          ///< the newest is older than [Memory] maxLag when the frame was taken
  jump,          ///< it moved faster than [control] maxSpeed or maxTurn
  anew,          ///< it began anew elsewhere (Odometry::frame)
  backwards,     ///< its time or the frames' ran backwards
  contradicted,  ///< all that is tracked moves as one: the odometry does not tell how the rover moves
  pause,         ///< there was none for more than a second
  count          ///< number of causes, not one of them
};

/// What `fused` and `tracks` of the same frame are made of, topic `memory`: the rover's pose in the odometry frame when the frame was
/// taken.
struct Memory {
  static constexpr RecordType type = RecordType::memory;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  MemoryState state;
  MemoryCause cause;   ///< frame_only: why; fused: why it was forgotten last
  uint32_t forgotten;  ///< how often all was forgotten: with another number odometry coordinates of before mean nothing
  uint32_t unused;
  double x, y, yaw;  ///< m, m, rad; NaN: not known
  double lag_s;      ///< from the newest odometry to the frame: carried on over that time; NaN: none
  double since_s;    ///< how long it has been remembered since; 0 for frame_only
};

/// One obstacle that was followed from frame to frame.
struct Track {
  static constexpr uint32_t moving = 1, seen = 2, cut = 4;  ///< flags; seen: in this frame; cut: by the border of the view
  uint32_t id;                                              ///< never used again
  uint32_t flags;
  float x, y;                    ///< m, middle of what is seen of it
  float speed_x, speed_y;        ///< m/s over the ground; where Tracks::frame is 0, against the rover
  float speed_deviation;         ///< m/s, standard deviation of each
  float size_x, size_y, height;  ///< m, along the axes of the frame, of what is seen; over the floor
  float age_s, unseen_s;         ///< since first seen; since last seen
};

/// Topic `tracks`: obstacles with position, size, age and velocity, oldest first.
struct Tracks {
  static constexpr RecordType type = RecordType::tracks;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 64;
  RecordHeader header;
  uint32_t frame;  ///< grid_of_odometry: x, y of the odometry frame; 0: of the rover frame r, as no odometry tells where it is
  uint32_t count;
  Track tracks[capacity];
};

static_assert(sizeof(Memory) == 64 && sizeof(Track) == 48 && sizeof(Tracks) == 16 + 48 * Tracks::capacity);
std::string_view name(MemoryState state);
std::string_view name(MemoryCause cause);
std::string_view describe(MemoryCause cause);

/// One camera of the pair. Counts are since the start of the daemon.
struct CameraView {
  uint32_t open;        ///< 1: it delivers, or ought to
  uint32_t opened;      ///< how often
  uint64_t frames;      ///< whole ones
  uint64_t incomplete;  ///< parts were missing, or damaged: never processed
  uint64_t unpaired;    ///< had no other half
  uint64_t refused;     ///< not newer than the frame before
  double exposure_us;   ///< as last set; NaN: left to the camera
  double gain_db;       ///< likewise
  double floor_level;   ///< 0..255, mean of the lower half of its view
  double dark, bright;  ///< shares of its pixels below 8 and above 247
};

/// `camera/status`: what the cameras deliver and what becomes of it.
struct CameraStatus {
  static constexpr RecordType type = RecordType::camera_status;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint64_t pairs;      ///< that were complete
  uint64_t skipped;    ///< of those: given up for a newer one before the tree was ready
  double apart_ms;     ///< right after left, of the last pair; where there is none, of the frames nearest to each other
  double age_ms;       ///< from the middle of the exposure to the start of this step
  uint32_t exchanged;  ///< 1: the first view of a frame was found, or is said, to be the right one
  uint32_t cameras;    ///< 1: one that gives both views; 2
  CameraView view[2];
};

static_assert(sizeof(CameraView) == 80 && sizeof(CameraStatus) == 208);

/// The spec of an image that carries record R.
template <class R>
constexpr ImageSpec record_spec() {
  return {Pixel::record, static_cast<uint16_t>(R::type), static_cast<uint16_t>(sizeof(R)), 1};
}

/// The record in an image made with record_spec<R>(); clears it and fills its header.
template <class R>
R& make_record(Image& image) {
  R* record = image.row<R>(0);
  *record = R{};
  record->header = {R::type, R::version, static_cast<uint32_t>(sizeof(R))};
  return *record;
}

/// The record in an image, or null where the image holds something else.
template <class R>
const R* record_of(const Image& image) {
  if (image.spec != record_spec<R>()) return nullptr;
  const R* record = image.row<R>(0);
  return record->header.type == R::type && record->header.version == R::version ? record : nullptr;
}

}  // namespace vdisp
