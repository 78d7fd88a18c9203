// gige_knock.cpp: the discovery command of GVCP (GigE Vision 1.2, 15.1), sent to one address instead of to all.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/gige_knock.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace vdisp {
namespace {

constexpr uint16_t port = 3956;
constexpr size_t header = 8, answer_bytes = 0xf8;
// Places in the answer, which is the camera's first registers.
constexpr size_t vendor_at = 0x48, model_at = 0x68, serial_at = 0xd8;

}  // namespace

std::optional<AttachedCamera> knock_at_gige(const std::string& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return {};
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return {};
  const timeval limit{0, 100'000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  // Key, flag "answer", command DISCOVERY (2), no data, number 1.
  constexpr std::array<uint8_t, header> command{0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01};
  std::array<char, 1024> answer{};
  ssize_t size = -1;
  if (connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 && send(socket, command.data(), command.size(), 0) > 0)
    size = recv(socket, answer.data(), answer.size(), 0);
  ::close(socket);
  // Status 0, answer to discovery (3), with the number asked for.
  constexpr std::array<char, 4> good{0, 0, 0, 3};
  if (size < static_cast<ssize_t>(header + answer_bytes) || std::memcmp(answer.data(), good.data(), good.size()) != 0 || answer[7] != 1)
    return {};
  const auto text = [&](size_t at, size_t bytes) { return std::string(&answer[header + at], strnlen(&answer[header + at], bytes)); };
  AttachedCamera camera;
  camera.address = address;
  camera.vendor = text(vendor_at, 32);
  camera.model = text(model_at, 32);
  camera.serial = text(serial_at, 16);
  camera.gige = true;
  return camera;
}

}  // namespace vdisp
