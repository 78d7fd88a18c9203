// command.h: what goes into the daemon: messages of the control socket, fixed in size. docs/control.md tells the whole protocol.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp {

inline constexpr uint32_t command_magic = 0x43534456;  // "VDSC"
inline constexpr uint16_t command_version = 1;
inline constexpr const char* system_control_socket = "/run/vdisp/control";
inline constexpr const char* user_control_socket = "vdisp/control";  ///< under $XDG_RUNTIME_DIR

enum class CommandType : uint16_t { odometry = 1, imu, drive, event, set, get, save, undo, reply };

/// First member of each message; one message is one packet of the SEQPACKET socket.
struct CommandHeader {
  uint32_t magic;
  uint16_t version;
  CommandType type;
  uint32_t bytes;   ///< of the whole message
  uint32_t number;  ///< chosen by the sender, given back in the reply
};

/// Where the rover is, in the odometry frame (REP-103: x forward, y left, z up at the start). NaN: not known, but for x, y, yaw.
struct OdometryMessage {
  static constexpr CommandType type = CommandType::odometry;
  CommandHeader header;
  int64_t timestamp_ns;                      ///< CLOCK_MONOTONIC of the measurement
  double x, y, yaw;                          ///< m, m, rad (positive to the left)
  double z, roll, pitch;                     ///< m, rad (right side low), rad (nose down)
  double speed;                              ///< m/s ahead
  double turn_rate;                          ///< rad/s, positive to the left
  double position_deviation, yaw_deviation;  ///< standard deviations, m and rad
};

/// What an accelerometer and a gyroscope tell, in the rover frame r.
struct ImuMessage {
  static constexpr CommandType type = CommandType::imu;
  CommandHeader header;
  int64_t timestamp_ns;
  double acceleration[3];  ///< m/s^2: at rest it points up, (0, 0, 9.81) on level ground
  double rate[3];          ///< rad/s about x, y, z; NaN: not measured
};

/// What the rover is told to do.
struct DriveMessage {
  static constexpr CommandType type = CommandType::drive;
  CommandHeader header;
  int64_t timestamp_ns;
  double speed, turn_rate;  ///< m/s ahead, rad/s to the left
};

/// Something that happened, "collision" for example.
struct EventMessage {
  static constexpr CommandType type = CommandType::event;
  CommandHeader header;
  int64_t timestamp_ns;
  char label[48];  ///< printable, ends with a zero
};

/// set, get, save, undo. Texts end with a zero.
struct ParameterMessage {
  CommandHeader header;
  char key[96];     ///< set, get: "SECTION.KEY", or KEY where one section has it; empty in get: the one numbered `index`
  char value[256];  ///< set: as in vdisp.cfg
  uint32_t index;   ///< get without key: from 0, in the order of vdisp.cfg
  uint32_t joined;  ///< set: 1: with the set of this key before, by this connection, it is one step for undo
};

enum class Answer : uint32_t {
  done = 0,
  refused,        ///< the value is out of range, or contradicts others: nothing was changed
  unknown,        ///< no such key
  needs_restart,  ///< the key takes effect at the next start only
  failed,         ///< save: the file cannot be written, or was changed by somebody else
  busy,           ///< too many connections or requests; try again later
  wrong_message,  ///< magic, version, type or size are not of this protocol; the connection is closed
};

struct ReplyMessage {
  static constexpr CommandType type = CommandType::reply;
  CommandHeader header;
  Answer answer;
  uint32_t live;               ///< 1: the key takes effect between two frames
  uint32_t index, count;       ///< get: number of the key, and of all keys
  uint64_t config_generation;  ///< as in the header of the images that are made with it
  uint64_t sequence;           ///< the next frame: the first one with this configuration
  char key[96], value[256], standard[256], allowed[256], unit[32];
  char text[1024];  ///< the complaint in one line; of get: the help
};

static_assert(sizeof(CommandHeader) == 16 && sizeof(OdometryMessage) == 104 && sizeof(ImuMessage) == 72 && sizeof(DriveMessage) == 40);
static_assert(sizeof(EventMessage) == 72 && sizeof(ParameterMessage) == 376 && sizeof(ReplyMessage) == 1968);

}  // namespace vdisp
