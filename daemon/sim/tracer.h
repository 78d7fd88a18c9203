// tracer.h: the obstacles as shapes, and which of them a ray hits. The only file pair that knows Embree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "daemon/sim/scene.h"
#include "daemon/sim/shade.h"

namespace vdisp::sim {

/// Null where Embree cannot start. Tracing changes nothing: several threads may, each with a Probe of its own.
class Tracer {
 public:
  static std::unique_ptr<Tracer> make(const Scene& scene, uint32_t seed);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// The arrays that a thread's rays travel in.
  struct Probe;
  struct EraseProbe {
    void operator()(Probe* probe) const;
  };
  std::unique_ptr<Probe, EraseProbe> make_probe() const;

  /// Where what moves is now: for all rays that are traced after it.
  void move(const Scene& scene) noexcept;
  /// Replaces t, object and normal of the rays that hit an object nearer than t. Ground that has a mesh is hit as well, as no object.
  /// `mark`: the tile's, which says what kind of objects may be seen in it.
  void trace(Probe& probe, const Look& look, uint8_t mark, Batch& batch) const noexcept;
  /// Marks the tiles that an object may be seen in; the others have 0.
  void mark(const Look& look, const Rays& rays, std::vector<uint8_t>& marks) const noexcept;
  /// For each of `count` points, 1 where the direction is free of objects that do not move, for `reach` m.
  void light(const Point* points, int count, const Point& direction, float reach, uint8_t* lit) const;

 private:
  struct Shapes;
  explicit Tracer(std::unique_ptr<Shapes> shapes);
  std::unique_ptr<Shapes> shapes_;
};

}  // namespace vdisp::sim
