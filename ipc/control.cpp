// control.cpp: the client's end of the control socket.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/include/vdisp/control.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace vdisp {
namespace {

using Clock = std::chrono::steady_clock;
using Result = Control::Result;

int64_t stamp(int64_t given) {
  if (given != 0) return given;
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

/// A number that no other request of this process has.
uint32_t next_number() {
  static std::atomic<uint32_t> last{0};
  return ++last;
}

template <class Message>
Message make(CommandType type) {
  Message message{};
  message.header = {command_magic, command_version, type, sizeof(Message), next_number()};
  return message;
}

template <size_t size>
bool put(char (&to)[size], std::string_view text) {
  if (text.size() >= size || text.find('\0') != text.npos) return false;
  std::memcpy(to, text.data(), text.size());
  return true;
}

template <size_t size>
std::string text_of(const char (&text)[size]) {
  return {text, strnlen(text, size)};
}

ParameterInfo info_of(const ReplyMessage& reply) {
  return {text_of(reply.key),  text_of(reply.value), text_of(reply.standard), text_of(reply.allowed), text_of(reply.unit),
          text_of(reply.text), reply.live != 0,      reply.config_generation, reply.sequence};
}

std::vector<std::string> places(const std::string& named) {
  if (!named.empty()) return {named};
  std::vector<std::string> all{system_control_socket};
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime && *runtime)
    all.push_back(std::string(runtime) + "/" + user_control_socket);
  return all;
}

}  // namespace

struct Control::Implementation {
  std::vector<std::string> places;
  std::chrono::milliseconds limit;
  std::string message;
  int socket = -1;

  void disconnect() {
    if (socket >= 0) close(socket);
    socket = -1;
  }
  Result say(Result result, std::string text) {
    message = std::move(text);
    return result;
  }
  bool ready(short events, Clock::time_point end) const;
  /// done, or why this place does not do.
  Result connect_to(const std::string& place, Clock::time_point end);
  Result connect(Clock::time_point end);
  Result send(const void* bytes, size_t size, Clock::time_point end);
  Result receive(uint32_t number, ReplyMessage& reply, Clock::time_point end);
  Result judge(const ReplyMessage& reply);
  Result deliver(const void* bytes, size_t size, Clock::time_point end);
  Result deliver(const void* bytes, size_t size) { return deliver(bytes, size, Clock::now() + limit); }
  Result ask(const ParameterMessage& message, ReplyMessage& reply);
  Result set(std::string_view key, std::string_view value, bool joined, ParameterInfo* info);
  Result ended(const char* text);
};

bool Control::Implementation::ready(short events, Clock::time_point end) const {
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0) return false;
    pollfd wait{socket, events, 0};
    const int found = poll(&wait, 1, static_cast<int>(std::min<int64_t>(left, 1000)));
    if (found > 0) return true;
    if (found < 0 && errno != EINTR) return false;
  }
}

Result Control::Implementation::connect_to(const std::string& place, Clock::time_point end) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (place.size() >= sizeof address.sun_path) return say(Result::no_daemon, place + ": too long for the path of a socket");
  std::memcpy(address.sun_path, place.data(), place.size());
  socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return say(Result::no_daemon, std::string("no socket: ") + std::strerror(errno));
  while (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error = errno;
    if (error == EINTR) continue;
    if (error == EAGAIN && Clock::now() < end) {  // its queue of connections is full
      const timespec pause{0, 5'000'000};
      nanosleep(&pause, nullptr);
      continue;
    }
    disconnect();
    if (error == EAGAIN) return say(Result::busy, place + ": the daemon takes no connection; is it stopped, or are there too many?");
    if (error == EACCES || error == EPERM)
      return say(Result::no_permission, place + ": this user may not connect; it must be in the daemon's [ipc] group");
    if (error == ECONNREFUSED) return say(Result::no_daemon, place + ": nobody listens, the daemon has ended; start vdispd");
    return say(Result::no_daemon, place + ": " + std::strerror(error) + "; is vdispd running?");
  }
  return Result::done;
}

Result Control::Implementation::connect(Clock::time_point end) {
  if (socket >= 0) return Result::done;
  Result result = Result::no_daemon;
  for (const std::string& place : places) {
    const std::string before = message;
    const Result here = connect_to(place, end);
    if (here == Result::done) return here;
    // The first place that has something to say is told.
    if (&place == &places.front() || (result == Result::no_daemon && here != Result::no_daemon)) {
      result = here;
    } else {
      message = before;
    }
  }
  return result;
}

Result Control::Implementation::ended(const char* text) {
  disconnect();
  return say(Result::no_daemon, text);
}

/// The daemon may have said why before it closed the connection.
Result Control::Implementation::send(const void* bytes, size_t size, Clock::time_point end) {
  while (true) {
    if (::send(socket, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size)) return Result::done;
    if (errno == EINTR) continue;
    if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!ready(POLLOUT, end)) return say(Result::busy, "the daemon does not take what is sent; is it stopped, or is this too much?");
      continue;
    }
    ReplyMessage reply;
    Result told = Result::done;
    while (told == Result::done && recv(socket, &reply, sizeof reply, MSG_DONTWAIT) == sizeof reply) told = judge(reply);
    disconnect();
    return told == Result::busy || told == Result::wrong_version
               ? told
               : say(Result::no_daemon, "the daemon has ended the connection; is vdispd running?");
  }
}

Result Control::Implementation::judge(const ReplyMessage& reply) {
  message = text_of(reply.text);
  switch (reply.answer) {
    case Answer::done: return Result::done;
    case Answer::refused: return Result::refused;
    case Answer::unknown: return Result::unknown;
    case Answer::needs_restart: return Result::needs_restart;
    case Answer::failed: return Result::failed;
    case Answer::busy: return say(Result::busy, "the daemon has no connection or no place for a request left; try again later");
    case Answer::wrong_message: break;
  }
  return say(Result::wrong_version, "the daemon does not know this message; daemon and library must be of one version");
}

/// Replies to what was given up before are thrown away.
Result Control::Implementation::receive(uint32_t number, ReplyMessage& reply, Clock::time_point end) {
  while (ready(POLLIN, end)) {
    const ssize_t size = recv(socket, &reply, sizeof reply, MSG_DONTWAIT);
    if (size < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (size <= 0) return ended("the daemon has ended the connection; is vdispd running?");
    const bool ours = size == sizeof reply && reply.header.magic == command_magic && reply.header.version == command_version;
    if (!ours) {
      disconnect();
      return say(Result::wrong_version, "the daemon's answer is not of this version; daemon and library must be of one version");
    }
    if (reply.header.number == number) return judge(reply);
    if (reply.header.number == 0) {
      const Result told = judge(reply);
      disconnect();
      return told;
    }
  }
  return say(Result::no_answer, "the daemon did not answer within " + std::to_string(limit.count()) + " ms; is it stopped?");
}

Result Control::Implementation::deliver(const void* bytes, size_t size, Clock::time_point end) {
  const bool fresh = socket < 0;
  Result result = connect(end);
  if (result == Result::done) result = send(bytes, size, end);
  // The daemon may have been started anew since the last call.
  if (result == Result::no_daemon && !fresh && (result = connect(end)) == Result::done) result = send(bytes, size, end);
  if (result == Result::done) message.clear();
  return result;
}

Result Control::Implementation::ask(const ParameterMessage& question, ReplyMessage& reply) {
  const Clock::time_point end = Clock::now() + limit;
  const Result sent = deliver(&question, sizeof question, end);
  return sent == Result::done ? receive(question.header.number, reply, end) : sent;
}

Control::Control(std::string path, std::chrono::milliseconds limit)
    : implementation_(std::make_unique<Implementation>(Implementation{places(path), limit, {}})) {}
Control::~Control() { implementation_->disconnect(); }

const std::string& Control::message() const { return implementation_->message; }

Result Control::odometry(const OdometrySample& sample) {
  auto message = make<OdometryMessage>(CommandType::odometry);
  message.timestamp_ns = stamp(sample.timestamp_ns);
  message.x = sample.x;
  message.y = sample.y;
  message.yaw = sample.yaw;
  message.z = sample.z;
  message.roll = sample.roll;
  message.pitch = sample.pitch;
  message.speed = sample.speed;
  message.turn_rate = sample.turn_rate;
  message.position_deviation = sample.position_deviation;
  message.yaw_deviation = sample.yaw_deviation;
  return implementation_->deliver(&message, sizeof message);
}

Result Control::imu(const ImuSample& sample) {
  auto message = make<ImuMessage>(CommandType::imu);
  message.timestamp_ns = stamp(sample.timestamp_ns);
  std::copy_n(sample.acceleration, 3, message.acceleration);
  std::copy_n(sample.rate, 3, message.rate);
  return implementation_->deliver(&message, sizeof message);
}

Result Control::drive(double speed, double turn_rate, int64_t timestamp_ns) {
  auto message = make<DriveMessage>(CommandType::drive);
  message.timestamp_ns = stamp(timestamp_ns);
  message.speed = speed;
  message.turn_rate = turn_rate;
  return implementation_->deliver(&message, sizeof message);
}

Result Control::event(std::string_view label, int64_t timestamp_ns) {
  auto message = make<EventMessage>(CommandType::event);
  message.timestamp_ns = stamp(timestamp_ns);
  if (label.empty() || !put(message.label, label))
    return implementation_->say(Result::refused, "an event's label must have 1 to 47 characters");
  return implementation_->deliver(&message, sizeof message);
}

Result Control::Implementation::set(std::string_view key, std::string_view value, bool joined, ParameterInfo* info) {
  auto request = make<ParameterMessage>(CommandType::set);
  request.joined = joined;
  if (!put(request.key, key)) return say(Result::unknown, "no parameter has such a name: it is longer than 95 characters");
  if (!put(request.value, value)) return say(Result::refused, "the value is longer than the 255 characters that can be sent");
  ReplyMessage reply;
  const Result result = ask(request, reply);
  if (result == Result::done && info) *info = info_of(reply);
  return result;
}

Result Control::set(std::string_view key, std::string_view value, ParameterInfo* info) {
  return implementation_->set(key, value, false, info);
}

Result Control::adjust(std::string_view key, std::string_view value, ParameterInfo* info) {
  return implementation_->set(key, value, true, info);
}

Result Control::get(std::string_view key, ParameterInfo& info) {
  auto message = make<ParameterMessage>(CommandType::get);
  if (key.empty() || !put(message.key, key)) return implementation_->say(Result::unknown, "a parameter's name has 1 to 95 characters");
  ReplyMessage reply;
  const Result result = implementation_->ask(message, reply);
  if (result == Result::done) info = info_of(reply);
  return result;
}

/// Asked for in bundles: an answer takes a frame or two.
Result Control::get_all(std::vector<ParameterInfo>& all) {
  constexpr uint32_t bundle = 16;
  all.clear();
  const Clock::time_point end = Clock::now() + implementation_->limit;
  for (uint32_t count = 1; all.size() < count;) {
    const auto first = static_cast<uint32_t>(all.size()), last = first == 0 ? 1 : std::min(first + bundle, count);
    std::vector<uint32_t> numbers;
    for (uint32_t i = first; i < last; ++i) {
      auto message = make<ParameterMessage>(CommandType::get);
      message.index = i;
      numbers.push_back(message.header.number);
      if (const Result sent = implementation_->deliver(&message, sizeof message, end); sent != Result::done) return sent;
    }
    for (const uint32_t number : numbers) {
      ReplyMessage reply;
      if (const Result told = implementation_->receive(number, reply, end); told != Result::done) return told;
      all.push_back(info_of(reply));
      count = reply.count;
    }
  }
  return Result::done;
}

Result Control::undo(ParameterInfo* info) {
  ReplyMessage reply;
  const Result result = implementation_->ask(make<ParameterMessage>(CommandType::undo), reply);
  if (result == Result::done && info) *info = info_of(reply);
  return result;
}

Result Control::save() {
  ReplyMessage reply;
  const Result result = implementation_->ask(make<ParameterMessage>(CommandType::save), reply);
  if (result == Result::done) implementation_->message = text_of(reply.value) + ": " + text_of(reply.text);
  return result;
}

int exit_code(Result result) {
  switch (result) {
    case Result::done: return 0;
    case Result::unknown: return 64;
    case Result::refused:
    case Result::needs_restart: return 78;
    case Result::failed: return 73;
    case Result::no_permission: return 77;
    case Result::no_daemon:
    case Result::busy:
    case Result::no_answer:
    case Result::wrong_version: break;
  }
  return 69;
}

}  // namespace vdisp
