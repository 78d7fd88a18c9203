// port.cpp: libserialport opens and sets; locks, hang-ups, ports that take nothing and ports without modem lines it leaves to us.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/port.h"

#include <fcntl.h>
#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/core/clock.h"
#include "daemon/tools/drive/phrase.h"

namespace vdisp::drive {
namespace {

constexpr int64_t ms = 1'000'000;
constexpr int64_t first_pause = 100 * ms, longest_pause = 2000 * ms;
constexpr int64_t stuck = 150 * ms;
constexpr int64_t steady = 5000 * ms;  // open for so long: the next loss is a new one

std::string why() { return std::strerror(errno); }

}  // namespace

bool Port::fail(int exit_code, const std::string& why) {
  close();
  exit_code_ = exit_code;
  fault_ = name_ + ": " + why;
  return false;
}

/// For those who ask (flock) and for those who do not (TIOCEXCL; the kernel lets root pass).
bool Port::lock() {
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0 || ioctl(fd_, TIOCEXCL) != 0)
    return fail(EX_UNAVAILABLE, "in use by another program; end that one");
  return true;
}

bool Port::open(int64_t now_ns) {
  if (is_open() || now_ns < retry_ns_) return false;
  pause_ns_ = pause_ns_ == 0 ? first_pause : std::min(2 * pause_ns_, longest_pause);
  retry_ns_ = now_ns + pause_ns_;
  if (is_output()) {
    fd_ = STDOUT_FILENO;
    return true;
  }
  const int place = ::open(name_.c_str(), O_PATH | O_CLOEXEC);
  if (place < 0) return fail(errno == EACCES ? EX_NOPERM : EX_UNAVAILABLE, why() + "; plug the controller in, or name its port");
  // libserialport 0.1.1 looks the name behind /dev/ up under /sys/class/tty and wants a link there, which leaves out pseudo-terminals and
  // /dev/serial/by-id. On this way both places are the link to what was just found.
  const bool opened = open_at("/dev/../../../proc/self/fd/" + std::to_string(place));
  ::close(place);
  if (!opened) return false;
  if (!lock() || !configure()) return false;
  tcflush(fd_, TCIOFLUSH);
  fault_.clear();
  opened_ns_ = now_ns;
  return true;
}

bool Port::open_at(const std::string& path) {
  const bool found = sp_get_port_by_name(path.c_str(), &port_) == SP_OK;
  errno = 0;
  if (found && sp_open(port_, SP_MODE_READ_WRITE) == SP_OK) {
    if (sp_get_port_handle(port_, &fd_) != SP_OK) return fail(EX_UNAVAILABLE, "has no handle; tried again");
    return true;
  }
  int error = errno;
  if (port_) sp_free_port(port_);
  port_ = nullptr;
  if (error == ENOTTY) {
    // It wants modem lines, which a pseudo-terminal and some built-in UARTs do not have.
    fd_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ >= 0 && isatty(fd_)) return true;
    error = fd_ >= 0 ? ENOTTY : errno;
  }
  if (error == EACCES) return fail(EX_NOPERM, "not permitted; be a member of the port's group, as a rule dialout");
  if (error == EBUSY) return fail(EX_UNAVAILABLE, "in use by another program; end that one");
  if (error == ENOTTY || error == EISDIR || error == EINVAL) return fail(EX_CONFIG, "is no serial port");
  return fail(EX_UNAVAILABLE, std::string(error ? std::strerror(error) : "does not open") + "; tried again");
}

bool Port::configure() {
  bool good = false;
  if (port_) {
    good = sp_set_baudrate(port_, baud_) == SP_OK && sp_set_bits(port_, 8) == SP_OK && sp_set_parity(port_, SP_PARITY_NONE) == SP_OK &&
           sp_set_stopbits(port_, 1) == SP_OK && sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE) == SP_OK;
  } else {
    termios line{};
    good = tcgetattr(fd_, &line) == 0;
    cfmakeraw(&line);
    line.c_cflag = (line.c_cflag & ~static_cast<tcflag_t>(CSTOPB | CRTSCTS)) | CLOCAL | CREAD;
    good = good && cfsetspeed(&line, static_cast<speed_t>(baud_)) == 0 && tcsetattr(fd_, TCSANOW, &line) == 0;
  }
  return good || fail(EX_CONFIG, "does not take baud = " + std::to_string(baud_) + ": " + why());
}

void Port::close() {
  // Else closing waits for what a controller without power will not take, and it gets old commands when it comes back.
  if (fd_ >= 0 && !is_output() && (!rest_.empty() || waiting() > 0)) tcflush(fd_, TCOFLUSH);
  if (port_) {
    sp_close(port_);
    sp_free_port(port_);
  } else if (fd_ >= 0 && !is_output()) {
    ::close(fd_);
  }
  port_ = nullptr;
  fd_ = -1;
  rest_.clear();
  stuck_since_ns_ = 0;
}

bool Port::lose(const std::string& why, int64_t now_ns) {
  if (now_ns - opened_ns_ > steady) pause_ns_ = 0;
  pause_ns_ = pause_ns_ == 0 ? first_pause : std::min(2 * pause_ns_, longest_pause);
  retry_ns_ = now_ns + pause_ns_;
  return fail(EX_UNAVAILABLE, why);
}

bool Port::hung_up() const {
  pollfd state{fd_, 0, 0};
  return poll(&state, 1, 0) > 0 && (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

int Port::waiting() const {
  int bytes = 0;
  return ioctl(fd_, TIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

/// False where the port fails.
bool Port::push_rest() {
  if (rest_.empty()) return true;
  const ssize_t taken = write(fd_, rest_.data(), rest_.size());
  if (taken > 0) rest_.erase(0, static_cast<size_t>(taken));
  return taken >= 0 || errno == EAGAIN || errno == EINTR;
}

Port::Sent Port::send(std::string_view bytes, int64_t now_ns) {
  if (!is_open()) return Sent::lost;
  if (is_output()) return print(bytes, now_ns);
  bool good = !hung_up() && push_rest();
  const bool free = good && rest_.empty() && waiting() == 0;
  if (free) {
    rest_ = bytes;
    good = push_rest();
  }
  if (!good) {
    lose("gone (unplugged?); tried again", now_ns);
    return Sent::lost;
  }
  if (free) {
    stuck_since_ns_ = 0;
    return Sent::yes;
  }
  if (stuck_since_ns_ == 0) stuck_since_ns_ = now_ns;
  if (now_ns - stuck_since_ns_ < stuck) return Sent::later;
  lose("takes nothing for 0.15 s: is the controller on? tried again", now_ns);
  return Sent::lost;
}

/// A reader that does not read costs lines, not time.
Port::Sent Port::print(std::string_view bytes, int64_t now_ns) {
  pollfd state{fd_, POLLOUT, 0};
  if (poll(&state, 1, 0) == 0) return Sent::later;
  const std::string line = escaped(bytes) + "\n";
  if (write(fd_, line.data(), line.size()) == static_cast<ssize_t>(line.size())) return Sent::yes;
  lose("cannot be written: " + why(), now_ns);
  exit_code_ = EX_IOERR;
  return Sent::lost;
}

size_t Port::receive(std::span<char> to, int64_t now_ns) {
  if (!is_open() || is_output()) return 0;
  const ssize_t count = read(fd_, to.data(), to.size());
  if (count > 0) return static_cast<size_t>(count);
  if ((count < 0 && errno != EAGAIN && errno != EINTR) || hung_up()) lose("gone (unplugged?); tried again", now_ns);
  return 0;
}

void Port::drain(int64_t limit_ns) {
  const int64_t end = monotonic_ns() + limit_ns;
  while (is_open() && !is_output() && push_rest() && (!rest_.empty() || waiting() > 0) && monotonic_ns() < end) usleep(1000);
}

}  // namespace vdisp::drive
