// network_link.cpp: asks the kernel; /sys would tell of another network namespace.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/network_link.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace vdisp {
namespace {

void ask_kernel(NetworkLink& link) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return;
  ifreq request{};
  std::snprintf(request.ifr_name, sizeof request.ifr_name, "%s", link.name.c_str());
  if (ioctl(socket, SIOCGIFMTU, &request) == 0) link.mtu = request.ifr_mtu;
  ethtool_cmd command{};
  command.cmd = ETHTOOL_GSET;
  request.ifr_data = reinterpret_cast<char*>(&command);
  if (ioctl(socket, SIOCETHTOOL, &request) == 0 && ethtool_cmd_speed(&command) != static_cast<uint32_t>(SPEED_UNKNOWN))
    link.mbit = static_cast<int>(ethtool_cmd_speed(&command));
  ::close(socket);
}

}  // namespace

NetworkLink network_link(const std::string& address) {
  NetworkLink link;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return link;
  for (const ifaddrs* i = all; i; i = i->ifa_next) {
    if (!i->ifa_addr || i->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr, text, sizeof text);
    if (address == text) link.name = i->ifa_name;
  }
  freeifaddrs(all);
  if (!link.name.empty()) ask_kernel(link);
  return link;
}

std::string refuse_packets(const NetworkLink& link, int packet_bytes) {
  if (link.mtu == 0 || packet_bytes <= link.mtu) return {};
  return "[camera] packetSize = " + std::to_string(packet_bytes) + " does not fit " + link.name + ", whose mtu is " +
         std::to_string(link.mtu) + "; a smaller one, or: ip link set " + link.name + " mtu " + std::to_string(packet_bytes);
}

std::string refuse_rate(const NetworkLink& link, int64_t frame_bytes, double rate_hz) {
  constexpr double bits = 8e-6, overhead = 1.05;  // headers of packets of 1400 bytes
  const double needed = static_cast<double>(frame_bytes) * rate_hz * bits * overhead;
  if (link.mbit == 0 || needed <= link.mbit) return {};
  return "frames of " + std::to_string(frame_bytes) + " bytes at " + std::to_string(std::lround(rate_hz)) + " Hz need " +
         std::to_string(std::lround(needed)) + " Mbit/s, " + link.name + " has " + std::to_string(link.mbit) +
         "; lower [image source] rate, width and height, or pixels of fewer bytes";
}

}  // namespace vdisp
