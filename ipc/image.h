// image.h: the one image of vdisp: a 128-byte header with its rows behind it, the same bytes in the daemon, on the wire and in files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vdisp {

/// What one pixel is. Pixels are native-endian; the unit is the type's.
enum class Pixel : uint16_t {
  none = 0,
  gray8,        ///< uint8_t, brightness
  mask8,        ///< uint8_t, 0 or 255
  rgb8,         ///< 3 uint8_t
  disparity16,  ///< int16_t, 1/16 pixel; <= rejected_base: no disparity, and why (Rejected)
  count16,      ///< int16_t, a count, saturated at 32767 (paper 3.11)
  height16,     ///< int16_t, mm above the local floor; height_unknown where there is none
  int8,         ///< int8_t, occupancy: -1 unknown, 0..100
  line16,       ///< int16_t, one row: image row per column of the v-disparity, not clipped; line_none where there is none
  record,       ///< one struct of ipc/records.h
};

/// Why a pixel has no disparity. The pixel's value is rejected_base - code.
enum class Rejected : uint8_t {
  low_texture = 1,  ///< too little texture in the window (SVS: confidence, `thresh`)
  not_unique,       ///< a second disparity matches as well (`unique`)
  left_right,       ///< the right image's match points elsewhere
  speckle,          ///< part of too small an area (`SpeckleSize`, `SpeckleDiff`)
  outside,          ///< the window or the search leaves the image
  matcher,          ///< refused by the matcher, which does not say by which of its filters
  infinity,         ///< not above 0: at or beyond infinity
};
inline constexpr int16_t rejected_base = -32000;
constexpr int16_t rejected(Rejected why) { return static_cast<int16_t>(rejected_base - static_cast<int16_t>(why)); }
/// The code of a rejected pixel, 0 for a pixel that has a disparity.
constexpr uint8_t rejected_code(int16_t pixel) { return pixel < rejected_base ? static_cast<uint8_t>(rejected_base - pixel) : uint8_t{0}; }

/// Why a cell of the ground is what it is; pixels of stage `reason`.
enum class CellReason : uint8_t {
  out_of_view = 0,  ///< unknown: the camera does not look there
  floor,            ///< floor seen
  obstacle,         ///< something stands there, or may: see free_up_to
  drop_off,         ///< the ground ends: what is seen lies under the floor
  overhang,         ///< unknown: only what hangs over it is seen
  too_near,         ///< unknown: nearer than the camera can match
  occluded,         ///< unknown: something nearer hides it
  too_dark,
  too_bright,
  no_texture,
  not_unique,
  left_right,
  speckle,              ///< unknown: why its pixels have no disparity
  rejected,             ///< unknown: refused otherwise
  remembered_floor,     ///< `fused_reason`: floor was seen, and nothing since
  remembered_obstacle,  ///< something stood there, and no ray has passed since
  remembered_drop_off,  ///< the ground ended there
};
inline constexpr size_t cell_reasons = 17;

/// What a pixel is, by its height over the local floor; pixels of stage `surface`.
enum class Surface : uint8_t {
  none = 0,  ///< no disparity that counts, or the low part of what stands upright: no floor, and not known to be high enough
  floor,     ///< lower than max_height, or ground that leads up; higher than a hole that counts
  obstacle,  ///< from max_height on, and in the way
  overhang,  ///< from clearance on: the rover passes below
  below,     ///< under the floor, or of the far side of a ditch
  filled,    ///< without a disparity of its own: inside an even surface whose edges are obstacle (paper 5.3)
};

/// A cell of `occupancy` with this or more is an obstacle; up to `free_up_to` it is free. Between them something may stand.
inline constexpr int8_t occupied_from = 65, free_up_to = 40;
/// Of max_height: what lies so much lower than the floor is none, and where the ground falls by so much it ends.
inline constexpr double hole_of_step = 0.75;

inline constexpr int16_t line_none = INT16_MIN;
inline constexpr int16_t height_unknown = INT16_MIN;

enum class ImageState : uint32_t { valid = 0, blind = 1 };

/// Why a stage is blind.
enum class Reason : uint32_t {
  none = 0,
  no_frame,        ///< the source delivered nothing in time
  bad_pair,        ///< a pair was incomplete, unreadable or of the wrong size
  no_calibration,  ///< needs metres, and there is no calibration
  few_points,      ///< fewer v-disparity points than [Floor] minRansac
  no_floor_line,   ///< no line between anglefloorMin and anglefloorMax
  no_pitch,        ///< angRot = auto, and no pitch was measured
  no_last_image,   ///< a delayed input: nothing was made of the last frame, or this is the first
  too_dark,        ///< no light, or a lens cap
  too_bright,      ///< over-exposed
  no_texture,      ///< hardly a pixel has texture
  no_matches,      ///< texture, and hardly a match: blocked, nearer than can be seen, or not a pair
  no_floor,        ///< no plane that the floor could be
  no_odometry,     ///< in/odometry: none came for [control] maxAge, or ever
  no_imu,          ///< in/imu: likewise
  no_drive,        ///< in/drive: likewise
  no_event,        ///< in/event: likewise
  no_camera,       ///< a camera is not there, or does not open
  unpaired,        ///< left and right deliver, and no two frames belong together
  bad_frames,      ///< frames come incomplete or damaged
  count            ///< number of reasons, not one of them
};
/// One word for files, one phrase for people.
std::string_view name(Reason reason);
std::string_view describe(Reason reason);
std::string_view name(Pixel pixel);
std::string_view name(Rejected why);
std::string_view name(CellReason why);
std::string_view describe(CellReason why);
std::string_view name(Surface surface);
/// Bytes of one pixel; 1 for records.
uint32_t pixel_bytes(Pixel pixel);

enum ImageFlag : uint32_t {
  flag_synthetic = 1,  ///< made from the simulator or from files, not from a camera
  flag_held = 2,       ///< predicted, not measured
  flag_memory = 4,     ///< holds what earlier frames saw
  flag_replayed = 8,   ///< synthetic only because it was recorded: its times, of frames and of inputs, are those of one clock
};

struct ImageSpec {
  Pixel pixel = Pixel::none;
  uint16_t record = 0;  ///< RecordType where pixel is record, else 0
  uint16_t width = 0;   ///< pixels; bytes of the struct for a record
  uint16_t height = 0;

  /// Bytes from one row to the next: rows start on 64-byte borders.
  uint32_t stride() const { return (width * pixel_bytes(pixel) + 63u) & ~63u; }
  /// Header and rows.
  uint32_t bytes() const;
  bool operator==(const ImageSpec&) const = default;
};

/// A rectified view: pixels and metres. f = 0: no calibration.
struct CameraGeometry {
  float f, cx, cy;        ///< px
  float baseline;         ///< m
  float cx_offset;        ///< cx left - cx right, px: true disparity d' = d - cx_offset
  int32_t min_disparity;  ///< px, where the search starts
  int32_t disparities;    ///< px, how far it goes
  uint32_t unused[3];
};

/// A grid on the ground. Row 0 is farthest; a point (x right, z ahead, from the grid's origin along its axes) lies in row
/// origin_row - 1 - floor(z / cell) and column floor(x / cell + origin_column).
struct GridGeometry {
  float cell;                       ///< m
  float origin_row, origin_column;  ///< cells, where the origin is: the camera, or the odometry's start, which may lie far outside
  float view_left, view_right;      ///< x / z of the left and right border of the view; both 0: not told
  uint32_t min_count;               ///< a cell with this count or more is an obstacle
  uint32_t frame;                   ///< what the axes are those of: grid_of_camera or grid_of_odometry
  float pose_x, pose_y, pose_yaw;   ///< of origin and axes in the rover frame r, at the moment of exposure (m, m, rad)
};
inline constexpr uint32_t grid_of_camera = 0;    ///< the camera's horizontal frame h
inline constexpr uint32_t grid_of_odometry = 1;  ///< z along the odometry's x, x against its y

/// Never copied, no pointers inside; rows follow the header in the same block.
struct alignas(64) Image {
  static constexpr uint32_t magic_value = 0x50534456;  // "VDSP"
  static constexpr uint32_t version_value = 1;

  uint32_t magic, version;
  ImageSpec spec;
  ImageState state;
  Reason reason;
  uint32_t flags;  ///< ImageFlag
  uint32_t unused;
  uint64_t sequence;     ///< step of the daemon it was made in, from 0
  uint64_t epoch;        ///< start of this daemon: sequences restart, epochs do not
  int64_t timestamp_ns;  ///< middle of the exposure, CLOCK_MONOTONIC; recording time for files
  int64_t ready_ns;      ///< when the stage finished, CLOCK_MONOTONIC
  uint64_t config_generation;
  uint64_t calibration_hash;
  union {
    CameraGeometry camera;
    GridGeometry grid;
  };
  uint64_t unused_end;

  /// Lays an image with a cleared header into 64-aligned memory of at least spec.bytes(); the rows stay as they are.
  static Image* make(void* memory, const ImageSpec& spec);
  /// Takes over everything that follows the frame (sequence, epoch, times, flags, geometry, hashes), not spec, state or rows.
  void describe_like(const Image& other);

  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;

  bool valid() const { return state == ImageState::valid; }
  void set_blind(Reason why) {
    state = ImageState::blind;
    reason = why;
  }

  template <class T>
  T* row(int y) {
    return reinterpret_cast<T*>(reinterpret_cast<std::byte*>(this + 1) + static_cast<size_t>(y) * spec.stride());
  }
  template <class T>
  const T* row(int y) const {
    return reinterpret_cast<const T*>(reinterpret_cast<const std::byte*>(this + 1) + static_cast<size_t>(y) * spec.stride());
  }

 private:
  Image() = default;
};

static_assert(sizeof(CameraGeometry) == 40 && sizeof(GridGeometry) == 40);
static_assert(sizeof(ImageSpec) == 8 && sizeof(Image) == 128 && alignof(Image) == 64);

inline uint32_t ImageSpec::bytes() const { return static_cast<uint32_t>(sizeof(Image)) + stride() * height; }

}  // namespace vdisp
