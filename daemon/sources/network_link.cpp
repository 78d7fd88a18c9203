// network_link.cpp: the kernel's list of interfaces, and what it tells of each.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/network_link.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace vdisp {
namespace {

int read_number(const std::string& file) {
  int number = 0;
  std::ifstream(file) >> number;
  return std::max(number, 0);  // -1: not known
}

}  // namespace

NetworkLink network_link(const std::string& address, const std::string& sys) {
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
  if (link.name.empty()) return link;
  link.mtu = read_number(sys + "/" + link.name + "/mtu");
  link.mbit = read_number(sys + "/" + link.name + "/speed");
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
