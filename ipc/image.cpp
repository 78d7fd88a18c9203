// image.cpp: names of pixel kinds and reasons, and laying an image into memory.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/image.h"

#include <cstring>

#include "ipc/records.h"

namespace vdisp {

std::string_view name(Reason reason) {
  switch (reason) {
    case Reason::none: return "none";
    case Reason::no_frame: return "no_frame";
    case Reason::bad_pair: return "bad_pair";
    case Reason::no_calibration: return "no_calibration";
    case Reason::few_points: return "few_points";
    case Reason::no_floor_line: return "no_floor_line";
    case Reason::no_pitch: return "no_pitch";
    case Reason::no_last_image: return "no_last_image";
    case Reason::too_dark: return "too_dark";
    case Reason::too_bright: return "too_bright";
    case Reason::no_texture: return "no_texture";
    case Reason::no_matches: return "no_matches";
    case Reason::no_floor: return "no_floor";
    case Reason::no_odometry: return "no_odometry";
    case Reason::no_imu: return "no_imu";
    case Reason::no_drive: return "no_drive";
    case Reason::no_event: return "no_event";
    case Reason::no_camera: return "no_camera";
    case Reason::unpaired: return "unpaired";
    case Reason::bad_frames: return "bad_frames";
    case Reason::count: break;
  }
  return "unknown";
}

std::string_view describe(Reason reason) {
  switch (reason) {
    case Reason::none: return "none";
    case Reason::no_frame: return "the source delivered no frame in time";
    case Reason::bad_pair: return "the pair is incomplete, unreadable or of the wrong size";
    case Reason::no_calibration: return "no calibration";
    case Reason::few_points: return "too few points in the v-disparity to look for a floor (minRansac)";
    case Reason::no_floor_line: return "no line in the v-disparity between anglefloorMin and anglefloorMax";
    case Reason::no_pitch: return "angRot = auto, and no pitch was measured";
    case Reason::no_last_image: return "nothing was made of the last frame, or there was none";
    case Reason::too_dark: return "the image is dark: no light, or a cap on the lens";
    case Reason::too_bright: return "the image is over-exposed";
    case Reason::no_texture: return "there is hardly any texture";
    case Reason::no_matches: return "there is texture, and hardly a match: something stands too near, or the views are no pair";
    case Reason::no_floor: return "no plane that could be the floor";
    case Reason::no_odometry: return "no odometry came in time";
    case Reason::no_imu: return "nothing came in time from an IMU";
    case Reason::no_drive: return "nobody told in time what the rover is to do";
    case Reason::no_event: return "no event lately";
    case Reason::no_camera: return "a camera is not there, or does not open";
    case Reason::unpaired: return "left and right frames were not taken at the same time";
    case Reason::bad_frames: return "frames come incomplete or damaged";
    case Reason::count: break;
  }
  return "a reason this version does not know";
}

std::string_view name(CalibrationState state) {
  switch (state) {
    case CalibrationState::measuring: return "measuring";
    case CalibrationState::good: return "good";
    case CalibrationState::drifted: return "drifted";
    case CalibrationState::count: break;
  }
  return "unknown";
}

std::string_view name(MemoryState state) { return state == MemoryState::fused ? "fused" : "frame_only"; }

std::string_view name(MemoryCause cause) {
  switch (cause) {
    case MemoryCause::none: return "none";
    case MemoryCause::no_odometry: return "no_odometry";
    case MemoryCause::late: return "late";
    case MemoryCause::jump: return "jump";
    case MemoryCause::anew: return "anew";
    case MemoryCause::backwards: return "backwards";
    case MemoryCause::contradicted: return "contradicted";
    case MemoryCause::pause: return "pause";
    case MemoryCause::count: break;
  }
  return "unknown";
}

std::string_view describe(MemoryCause cause) {
  switch (cause) {
    case MemoryCause::none: return "none";
    case MemoryCause::no_odometry: return "no odometry";
    case MemoryCause::late: return "odometry older than [Memory] maxLag";
    case MemoryCause::jump: return "odometry moved faster than [control] maxSpeed or maxTurn";
    case MemoryCause::anew: return "odometry began anew elsewhere";
    case MemoryCause::backwards: return "time ran backwards";
    case MemoryCause::contradicted: return "all that is tracked moves as one, so odometry does not tell how the rover moves";
    case MemoryCause::pause: return "no odometry for more than a second";
    case MemoryCause::count: break;
  }
  return "unknown";
}

std::string_view name(Steering steering) {
  switch (steering) {
    case Steering::forward: return "forward";
    case Steering::turn_left: return "turn_left";
    case Steering::turn_right: return "turn_right";
    case Steering::count: break;
  }
  return "unknown";
}

std::string_view name(Decider decider) {
  switch (decider) {
    case Decider::none: return "none";
    case Decider::vdisparity: return "vdisparity";
    case Decider::snow: return "snow";
    case Decider::operator_order: return "operator";
    case Decider::count: break;
  }
  return "unknown";
}

std::string_view name(FlightCause cause) {
  switch (cause) {
    case FlightCause::none: return "none";
    case FlightCause::asked: return "asked";
    case FlightCause::signal: return "signal";
    case FlightCause::floor_lost: return "floor_lost";
    case FlightCause::camera_lost: return "camera_lost";
    case FlightCause::bump: return "bump";
    case FlightCause::count: break;
  }
  return "unknown";
}

std::string_view describe(FlightCause cause) {
  switch (cause) {
    case FlightCause::none: return "nothing";
    case FlightCause::asked: return "asked for";
    case FlightCause::signal: return "a signal";
    case FlightCause::floor_lost: return "the floor was lost";
    case FlightCause::camera_lost: return "the camera was lost";
    case FlightCause::bump: return "a bump was reported";
    case FlightCause::count: break;
  }
  return "unknown";
}

std::string_view name(Refusal refusal) {
  switch (refusal) {
    case Refusal::none: return "none";
    case Refusal::not_finite: return "not_finite";
    case Refusal::out_of_range: return "out_of_range";
    case Refusal::backwards: return "backwards";
    case Refusal::late: return "late";
    case Refusal::ahead: return "ahead";
    case Refusal::jump: return "jump";
    case Refusal::other_sender: return "other_sender";
    case Refusal::recorded: return "recorded";
    case Refusal::count: break;
  }
  return "unknown";
}

std::string_view describe(Refusal refusal) {
  switch (refusal) {
    case Refusal::none: return "none";
    case Refusal::not_finite: return "NaN or infinite where a number is needed";
    case Refusal::out_of_range: return "values that no rover has";
    case Refusal::backwards: return "not newer than the sample before";
    case Refusal::late: return "older than [control] maxAge";
    case Refusal::ahead: return "from the future; the clock must be CLOCK_MONOTONIC";
    case Refusal::jump: return "a jump, faster than [control] maxSpeed and maxTurn allow";
    case Refusal::other_sender: return "another process sends the same already";
    case Refusal::recorded: return "the source of the frames tells its own";
    case Refusal::count: break;
  }
  return "a reason this version does not know";
}

std::string_view name(ImuUse use) {
  switch (use) {
    case ImuUse::none: return "none";
    case ImuUse::used: return "used";
    case ImuUse::settling: return "settling";
    case ImuUse::late: return "late";
    case ImuUse::accelerating: return "accelerating";
    case ImuUse::jumped: return "jumped";
    case ImuUse::askew: return "askew";
    case ImuUse::contradicts: return "contradicts";
  }
  return "unknown";
}

std::string_view describe(ImuUse use) {
  switch (use) {
    case ImuUse::none: return "there is no IMU";
    case ImuUse::used: return "used";
    case ImuUse::settling: return "its first sample, or the pitch of the camera is not known yet";
    case ImuUse::late: return "its samples come later than 0.1 s";
    case ImuUse::accelerating: return "what it measures is not gravity alone";
    case ImuUse::jumped: return "it jumps, faster than a rover turns";
    case ImuUse::askew: return "by it the rover lies on its side or upside down; axes are x ahead, y left, z up";
    case ImuUse::contradicts: return "the floor in the images turns otherwise than it says";
  }
  return "a use this version does not know";
}

std::string_view name(Pixel pixel) {
  switch (pixel) {
    case Pixel::none: return "none";
    case Pixel::gray8: return "gray8";
    case Pixel::mask8: return "mask8";
    case Pixel::rgb8: return "rgb8";
    case Pixel::disparity16: return "disparity16";
    case Pixel::count16: return "count16";
    case Pixel::height16: return "height16";
    case Pixel::int8: return "int8";
    case Pixel::line16: return "line16";
    case Pixel::record: return "record";
  }
  return "unknown";
}

std::string_view name(Rejected why) {
  switch (why) {
    case Rejected::low_texture: return "low texture";
    case Rejected::not_unique: return "not unique";
    case Rejected::left_right: return "left/right";
    case Rejected::speckle: return "speckle";
    case Rejected::outside: return "outside";
    case Rejected::matcher: return "refused by the matcher";
    case Rejected::infinity: return "at or beyond infinity";
  }
  return "unknown";
}

std::string_view name(CellReason why) {
  switch (why) {
    case CellReason::out_of_view: return "out of view";
    case CellReason::floor: return "floor";
    case CellReason::obstacle: return "obstacle";
    case CellReason::drop_off: return "drop-off";
    case CellReason::overhang: return "overhang";
    case CellReason::too_near: return "too near";
    case CellReason::occluded: return "occluded";
    case CellReason::too_dark: return "too dark";
    case CellReason::too_bright: return "too bright";
    case CellReason::no_texture: return "no texture";
    case CellReason::not_unique: return "not unique";
    case CellReason::left_right: return "left/right";
    case CellReason::speckle: return "speckle";
    case CellReason::rejected: return "rejected";
    case CellReason::remembered_floor: return "remembered floor";
    case CellReason::remembered_obstacle: return "remembered obstacle";
    case CellReason::remembered_drop_off: return "remembered drop-off";
  }
  return "unknown";
}

std::string_view describe(CellReason why) {
  switch (why) {
    case CellReason::out_of_view: return "the camera does not look there";
    case CellReason::floor: return "floor is seen";
    case CellReason::obstacle: return "something stands there";
    case CellReason::drop_off: return "the ground ends: what is seen lies under the floor";
    case CellReason::overhang: return "only what hangs over it is seen";
    case CellReason::too_near: return "nearer than the camera can match";
    case CellReason::occluded: return "something nearer hides it";
    case CellReason::too_dark: return "its pixels are dark";
    case CellReason::too_bright: return "its pixels are over-exposed";
    case CellReason::no_texture: return "its pixels have too little texture";
    case CellReason::not_unique: return "its pixels match at more than one disparity";
    case CellReason::left_right: return "its matches in the right view point elsewhere";
    case CellReason::speckle: return "its disparities are parts of too small areas, or it is a small patch of floor by itself";
    case CellReason::rejected: return "its pixels were refused otherwise";
    case CellReason::remembered_floor: return "floor was seen there, and nothing since";
    case CellReason::remembered_obstacle: return "something stood there, and no ray has passed since";
    case CellReason::remembered_drop_off: return "the ground ended there when it was last seen";
  }
  return "a reason this version does not know";
}

std::string_view name(Surface surface) {
  switch (surface) {
    case Surface::none: return "none";
    case Surface::floor: return "floor";
    case Surface::obstacle: return "obstacle";
    case Surface::overhang: return "overhang";
    case Surface::below: return "below the floor";
    case Surface::filled: return "filled obstacle";
  }
  return "unknown";
}

std::string_view name(TruthCell cell) {
  switch (cell) {
    case TruthCell::outside: return "outside the picture";
    case TruthCell::free: return "free ground";
    case TruthCell::obstacle: return "obstacle";
    case TruthCell::drop_off: return "edge of a drop-off";
    case TruthCell::overhang: return "overhang";
    case TruthCell::hidden: return "hidden";
    case TruthCell::below: return "bottom of a drop-off";
  }
  return "unknown";
}

uint32_t pixel_bytes(Pixel pixel) {
  switch (pixel) {
    case Pixel::rgb8: return 3;
    case Pixel::disparity16:
    case Pixel::count16:
    case Pixel::height16:
    case Pixel::line16: return 2;
    default: return 1;
  }
}

Image* Image::make(void* memory, const ImageSpec& spec) {
  std::memset(memory, 0, sizeof(Image));
  auto* image = static_cast<Image*>(memory);
  image->magic = magic_value;
  image->version = version_value;
  image->spec = spec;
  return image;
}

void Image::describe_like(const Image& other) {
  flags = other.flags;
  sequence = other.sequence;
  epoch = other.epoch;
  timestamp_ns = other.timestamp_ns;
  config_generation = other.config_generation;
  calibration_hash = other.calibration_hash;
  camera = other.camera;
}

}  // namespace vdisp
