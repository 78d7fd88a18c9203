// module.cpp: the renderer's one door to the daemon, which opens it only for `source = sim`.
// SPDX-License-Identifier: Apache-2.0
#include <exception>

#include "daemon/sim/renderer.h"

extern "C" __attribute__((visibility("default"))) vdisp::sim::Simulator* vdisp_make_simulator(const vdisp::sim_section& parameters) {
  try {
    return vdisp::sim::make_simulator(parameters).release();
  } catch (const std::exception&) {
    return nullptr;
  }
}
