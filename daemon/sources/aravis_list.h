// aravis_list.h: which GigE Vision and USB3 Vision cameras are attached, and which of them is meant.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdisp {

struct AttachedCamera {
  std::string id;        ///< vendor, model and serial number, as Aravis joins them
  std::string physical;  ///< MAC address; of USB3 Vision the GUID
  std::string address;   ///< IP address; empty for USB
  std::string vendor, model, serial;
  bool gige = false;

  /// "GigE camera Aravis-Fake-LEFT01 at 127.0.0.1".
  std::string words() const;
  /// Whether an operator who writes this means it: serial number, address, id, vendor-serial or MAC address.
  bool called(std::string_view name) const;
  /// Whether it is the same piece of hardware, wherever it is plugged in now.
  bool same_as(const AttachedCamera& other) const;
};

/// Sorted by id. Asks all networks and the USB, which takes a second; an answer younger than half a second is used by both cameras.
/// For any thread.
std::vector<AttachedCamera> attached_aravis_cameras();

/// "none", or what is there.
std::string list_of(const std::vector<AttachedCamera>& cameras);

/// Which camera a side asks for.
struct CameraWish {
  std::string name;        ///< [camera] left or right; empty: what is attached
  std::string other_name;  ///< of the other side: not that one
  int side = 0, sides = 2;
};

/// The one that is meant. Throws CameraError (absent; denied where a rule for the USB is missing) that lists what is there.
AttachedCamera choose(const CameraWish& wish, const std::vector<AttachedCamera>& attached);

/// The one that was open already, and no other: where it was, which is answered at once, or `everywhere`. Throws as choose().
AttachedCamera find_again(const AttachedCamera& before, bool everywhere);

/// Runs once, before anything else of Aravis: GLib's messages end neither the daemon nor on its stderr.
void prepare_aravis();

}  // namespace vdisp
