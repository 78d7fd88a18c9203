// control_fuzz.cpp: any packets at the control socket: each is answered, refused or ends its connection; what is taken is sound.
// SPDX-License-Identifier: Apache-2.0
//
// An input is a row of packets: a byte says of which kind, two more how long. Behind a byte of a kind that is a type of message stands that
// message without its header; of others the whole packet, or nothing: another connection, or a save.
#include <sched.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <optional>

#include "daemon/control/inlet.h"
#include "daemon/core/clock.h"
#include "daemon/core/driver.h"
#include "tests/fuzz/require.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

constexpr int64_t answer_ns = 10'000'000'000;
constexpr int most_packets = 64;

const char* const shipped = "# mine\n[image source]\nthresh = 12 # texture\n[Floor]\nanglefloorMax = 0.8\n[Map]\nangRot = 0.3\n";

bool ends(const auto& text) { return std::memchr(text, 0, sizeof text) != nullptr; }

/// A daemon's end with its thread and its file, and one client.
class Talk {
 public:
  explicit Talk(const TemporaryFolder& folder)
      : file_(folder.write("vdisp.cfg", shipped)),
        config_(read()),
        inputs_(config_),
        parameters_(config_, {file_, {}, false}, [](std::string_view line, bool) { require(is_one_line(line), "the log has lines"); }),
        inlet_((folder / "control").string(), "", inputs_, parameters_,
               [](std::string_view line) { require(is_one_line(line), "the log has lines"); }) {
    connect();
  }
  ~Talk() { close(client_); }
  Talk(const Talk&) = delete;
  Talk& operator=(const Talk&) = delete;

  void packet(uint8_t kind, std::string body);
  /// What the tree is told, and what is in use.
  void judge();

 private:
  Config read() const {
    Config config;
    require(read_config(file_, {}, config).complaints.empty(), "the file can be read");
    return config;
  }
  void connect();
  void send(const std::string& packet);
  std::optional<ReplyMessage> answer();
  void look_at(const ReplyMessage& reply, CommandType type, uint32_t number) const;
  void serve() { inlet_.serve(++sequence_); }

  std::filesystem::path file_;
  Config config_;
  Inputs inputs_;
  LiveParameters parameters_;
  Inlet inlet_;
  int client_ = -1;
  uint64_t sequence_ = 0;
  uint32_t number_ = 0;
};

void Talk::connect() {
  if (client_ >= 0) close(client_);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  inlet_.path().copy(address.sun_path, sizeof address.sun_path - 1);
  client_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  require(::connect(client_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0, "the daemon takes connections");
  serve();
}

void Talk::send(const std::string& packet) {
  if (::send(client_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) connect();
  serve();
}

/// The next reply; nothing: the daemon has ended the connection.
std::optional<ReplyMessage> Talk::answer() {
  for (const int64_t begin = monotonic_ns(); monotonic_ns() - begin < answer_ns;) {
    ReplyMessage reply;
    const ssize_t size = recv(client_, &reply, sizeof reply, MSG_DONTWAIT);
    if (size == 0 || (size < 0 && errno != EAGAIN)) return {};
    if (size > 0) {
      require(size == sizeof reply && reply.header.magic == command_magic && reply.header.bytes == sizeof reply, "a reply is one");
      return reply;
    }
    sched_yield();
    serve();
  }
  require(false, "a request is answered");
  return {};
}

void Talk::look_at(const ReplyMessage& reply, CommandType type, uint32_t number) const {
  require(reply.header.type == CommandType::reply && reply.header.number == number, "a reply tells whose it is");
  require(ends(reply.key) && ends(reply.value) && ends(reply.standard) && ends(reply.allowed) && ends(reply.unit) && ends(reply.text),
          "texts end");
  require(reply.answer != Answer::wrong_message && reply.answer != Answer::busy, "what is whole is taken");
  require(reply.answer == Answer::done || is_one_line(reply.text), "who is refused learns why, in one line");
  require(check(config_).empty(), "what is in use does not contradict itself");
  if (reply.answer != Answer::done || type == CommandType::save) return;
  const Parameter* row = find_parameter(reply.key);
  require(row, "a reply tells a key");
  require(row->get(config_).substr(0, sizeof reply.value - 1) == reply.value, "what is told is in use");
  require(type == CommandType::get || row->when == When::live, "what needs a restart is not set");
}

/// A message as a client sends it, with any body.
template <class Message>
std::string message_of(CommandType type, const std::string& body, uint32_t number) {
  Message message{};
  std::memcpy(reinterpret_cast<char*>(&message) + sizeof(CommandHeader), body.data(),
              std::min(body.size(), sizeof message - sizeof(CommandHeader)));
  message.header = {command_magic, command_version, type, sizeof message, number};
  return {reinterpret_cast<const char*>(&message), sizeof message};
}

void Talk::packet(uint8_t kind, std::string body) {
  const auto type = static_cast<CommandType>(kind & 15);
  const uint32_t number = ++number_;
  // A time that is told from now on is more often one that is taken.
  if ((kind & 16) && body.size() >= sizeof(int64_t)) {
    int64_t ahead_ns;
    std::memcpy(&ahead_ns, body.data(), sizeof ahead_ns);
    const int64_t time = monotonic_ns() + ahead_ns % 1'000'000'000;
    std::memcpy(body.data(), &time, sizeof time);
  }
  switch (type) {
    case CommandType::odometry: return send(message_of<OdometryMessage>(type, body, number));
    case CommandType::imu: return send(message_of<ImuMessage>(type, body, number));
    case CommandType::drive: return send(message_of<DriveMessage>(type, body, number));
    case CommandType::event: return send(message_of<EventMessage>(type, body, number));
    case CommandType::set:
    case CommandType::get:
    case CommandType::undo:
    case CommandType::save: {
      send(message_of<ParameterMessage>(type, body, number));
      const auto reply = answer();
      require(reply.has_value(), "who asks rightly keeps the connection");
      look_at(*reply, type, number);
      if (type == CommandType::save && reply->answer == Answer::done) {
        const Config saved = read();
        for (const Parameter& row : parameters()) require(row.get(saved) == row.get(config_), "what is saved is what is in use");
      }
      return;
    }
    case CommandType::reply: return connect();
    default: break;
  }
  // Rubbish, or by chance a message: the daemon may answer, and may end the connection.
  send(body);
  for (ReplyMessage reply; recv(client_, &reply, sizeof reply, MSG_DONTWAIT) > 0;) require(ends(reply.text), "texts end");
  connect();
}

template <class Record, class Write>
const Record* written(BufferOutlet& outlet, Inputs& inputs, Write write) {
  Image& image = *Image::make(&outlet.loan(), record_spec<Record>());
  (inputs.*write)(image, monotonic_ns());
  require(record_of<Record>(image), "the record is one");
  return image.valid() ? record_of<Record>(image) : nullptr;
}

void Talk::judge() {
  BufferOutlet odometry(record_spec<Odometry>()), imu(record_spec<Imu>()), drive(record_spec<DriveOrder>()), events(record_spec<Events>());
  if (const auto* o = written<Odometry>(odometry, inputs_, &Inputs::write_odometry)) {
    require(std::abs(o->x) <= 1e5 && std::abs(o->y) <= 1e5 && std::isfinite(o->yaw), "odometry is a place");
    require(!std::isinf(o->z) && !std::isinf(o->roll) && !std::isinf(o->pitch) && !std::isinf(o->speed) && !std::isinf(o->turn_rate),
            "or not known");
  }
  if (const auto* i = written<Imu>(imu, inputs_, &Inputs::write_imu))
    require(std::isfinite(i->roll) && std::isfinite(i->pitch), "gravity has a direction");
  if (const auto* d = written<DriveOrder>(drive, inputs_, &Inputs::write_drive))
    require(std::abs(d->speed) <= 1e3 && std::abs(d->turn_rate) <= 1e3, "an order can be one");
  if (const auto* e = written<Events>(events, inputs_, &Inputs::write_events)) {
    require(e->count >= 1 && e->count <= Events::capacity, "events are counted");
    for (uint32_t i = 0; i < e->count; ++i) require(ends(e->entries[i].label) && is_one_line(e->entries[i].label), "a label is words");
  }
  require(check(config_).empty(), "what is in use does not contradict itself");
}

}  // namespace
}  // namespace vdisp

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  // Each save waits for the disk: there is none.
  static const bool in_memory = setenv("TMPDIR", "/dev/shm", 0) == 0;
  static const vdisp::TemporaryFolder folder;
  if (!in_memory || size < 3 || size > 16384) return 0;
  vdisp::Bytes bytes(data, size);
  vdisp::Talk talk(folder);
  for (int packets = 0; !bytes.empty() && packets < vdisp::most_packets; ++packets) {
    const auto kind = bytes.number<uint8_t>();
    talk.packet(kind, bytes.text(bytes.number<uint16_t>()));
  }
  talk.judge();
  return 0;
}
