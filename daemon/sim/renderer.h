// renderer.h: makes a simulator: scene, cameras, surfaces and tracer put together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/sim/simulator.h"

namespace vdisp::sim {

/// Null where the ray tracer cannot start.
std::unique_ptr<Simulator> make_simulator(const sim_section& parameters);

}  // namespace vdisp::sim
