// network_link.h: what the network interface of a camera can carry.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace vdisp {

struct NetworkLink {
  std::string name;  ///< "eth0"; empty: not found
  int mtu = 0;       ///< bytes; 0: not known
  int mbit = 0;      ///< per second; 0: not known, as on the loopback interface
};

/// The interface that has this address of ours ("192.168.1.1").
NetworkLink network_link(const std::string& address);

/// Empty if it fits, else one line: what is needed, what there is, what would be right. `rate_hz` 0: not known.
std::string refuse_packets(const NetworkLink& link, int packet_bytes);
std::string refuse_rate(const NetworkLink& link, int64_t frame_bytes, double rate_hz);

}  // namespace vdisp
