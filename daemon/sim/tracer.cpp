// tracer.cpp: boxes, posts, walls and rocks as Embree meshes; rays in streams of one tile.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdisp::sim {
namespace {

constexpr float nearest = 0.05f;     // m: a camera's nose
constexpr double sunk = 0.3;         // m that shapes go into the ground, so that no slope lifts them off
using Corners = std::array<Point, 8>;

struct Mesh {
  std::vector<float> vertices;
  std::vector<unsigned> triangles;
  void vertex(double x, double y, double z) {
    for (double value : {x, y, z}) vertices.push_back(static_cast<float>(value));
  }
  void triangle(unsigned a, unsigned b, unsigned c) { triangles.insert(triangles.end(), {a, b, c}); }
  void quad(unsigned a, unsigned b, unsigned c, unsigned d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
};

/// From the object's own axes (along its width, up, along its depth) to the world.
Point placed(const SceneObject& o, double ground, double along, double up, double aside) {
  const double c = std::cos(o.yaw), s = std::sin(o.yaw);
  return {o.x + c * along - s * aside, ground - up, o.z + s * along + c * aside};
}

void add(Mesh& mesh, const Point& p) { mesh.vertex(p.x, p.y, p.z); }

Mesh box(const SceneObject& o, double ground) {
  Mesh mesh;
  for (unsigned k = 0; k < 8; ++k)
    add(mesh, placed(o, ground, (k & 1 ? 0.5 : -0.5) * o.width, k & 2 ? o.height : -sunk, (k & 4 ? 0.5 : -0.5) * o.depth));
  mesh.quad(0, 1, 3, 2);
  mesh.quad(4, 6, 7, 5);
  mesh.quad(0, 2, 6, 4);
  mesh.quad(1, 5, 7, 3);
  mesh.quad(2, 3, 7, 6);
  return mesh;
}

Mesh post(const SceneObject& o, double ground) {
  constexpr unsigned sides = 16;
  Mesh mesh;
  for (unsigned k = 0; k < sides; ++k) {
    const double a = 2 * M_PI * k / sides, x = std::cos(a) * o.width / 2, z = std::sin(a) * o.depth / 2;
    add(mesh, placed(o, ground, x, -sunk, z));
    add(mesh, placed(o, ground, x, o.height, z));
  }
  add(mesh, placed(o, ground, 0, o.height, 0));
  for (unsigned k = 0; k < sides; ++k) {
    const unsigned next = (k + 1) % sides;
    mesh.quad(2 * k, 2 * next, 2 * next + 1, 2 * k + 1);
    mesh.triangle(2 * k + 1, 2 * next + 1, 2 * sides);
  }
  return mesh;
}

/// A sphere with bumps, scaled so that it fills its width, depth and height.
Mesh rock(const SceneObject& o, double ground, uint32_t seed) {
  constexpr unsigned around = 28, rings = 14;
  Chance chance(seed);
  std::array<std::array<double, 4>, 9> bumps;
  for (auto& bump : bumps) bump = {chance.between(-4, 4), chance.between(-4, 4), chance.between(-4, 4), chance.between(0, 2 * M_PI)};
  std::vector<Point> points;
  Point least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
  for (unsigned ring = 0; ring <= rings; ++ring) {
    for (unsigned k = 0; k < around; ++k) {
      const double polar = M_PI * ring / rings, a = 2 * M_PI * k / around;
      const Point d{std::sin(polar) * std::cos(a), std::cos(polar), std::sin(polar) * std::sin(a)};
      double r = 1;
      for (const auto& bump : bumps) r += 0.055 * std::sin(bump[0] * d.x + bump[1] * d.y + bump[2] * d.z + bump[3]);
      points.push_back({r * d.x, r * d.y, r * d.z});
      const Point& p = points.back();
      least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
      most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
    }
  }
  Mesh mesh;
  for (const Point& p : points) {
    const double along = ((p.x - least.x) / (most.x - least.x) - 0.5) * o.width, aside = ((p.z - least.z) / (most.z - least.z) - 0.5) * o.depth;
    // A third of it is in the ground.
    const double up = ((p.y - least.y) / (most.y - least.y) * 1.5 - 0.5) * o.height;
    add(mesh, placed(o, ground, along, up, aside));
  }
  for (unsigned ring = 0; ring < rings; ++ring) {
    for (unsigned k = 0; k < around; ++k) {
      const unsigned next = (k + 1) % around;
      mesh.quad(ring * around + k, ring * around + next, (ring + 1) * around + next, (ring + 1) * around + k);
    }
  }
  return mesh;
}

Mesh shape(const SceneObject& o, double ground, uint32_t seed) {
  if (o.kind == ObjectKind::post) return post(o, ground);
  return o.kind == ObjectKind::rock ? rock(o, ground, seed) : box(o, ground);
}

/// Where the corners' hull lies in a view, in units of x / z; false: behind it.
bool outline(const Look& look, const Corners& corners, Rays::Bounds& bounds) {
  const float* m = look.axes;
  std::array<std::array<float, 3>, 8> seen;
  for (size_t i = 0; i < 8; ++i) {
    const float x = static_cast<float>(corners[i].x) - look.x, y = static_cast<float>(corners[i].y) - look.y, z = static_cast<float>(corners[i].z) - look.z;
    seen[i] = {m[0] * x + m[3] * y + m[6] * z, m[1] * x + m[4] * y + m[7] * z, m[2] * x + m[5] * y + m[8] * z};
  }
  bounds = {1e9f, -1e9f, 1e9f, -1e9f};
  const auto include = [&](float x, float y, float z) {
    bounds = {std::min(bounds.x0, x / z), std::max(bounds.x1, x / z), std::min(bounds.y0, y / z), std::max(bounds.y1, y / z)};
  };
  for (size_t i = 0; i < 8; ++i) {
    const auto& a = seen[i];
    if (a[2] >= nearest) include(a[0], a[1], a[2]);
    for (size_t bit = 1; bit < 8; bit *= 2) {  // edges that go through the plane just before the camera
      const auto& b = seen[i ^ bit];
      if (a[2] >= nearest || b[2] < nearest) continue;
      const float part = (nearest - a[2]) / (b[2] - a[2]);
      include(a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part, nearest);
    }
  }
  return bounds.x1 >= bounds.x0;
}

}  // namespace

struct Tracer::Shapes {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Corners> corners;
  ~Shapes() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

struct Tracer::Probe {
  static constexpr int size = Batch::size;
  alignas(64) float org_x[size], org_y[size], org_z[size], tnear[size], time[size], u[size], v[size];
  alignas(64) unsigned mask[size], id[size], flags[size], prim[size], instance[size];
};

Tracer::Tracer(std::unique_ptr<Shapes> shapes) : shapes_(std::move(shapes)) {}
Tracer::~Tracer() = default;
void Tracer::EraseProbe::operator()(Probe* probe) const { delete probe; }

std::unique_ptr<Tracer> Tracer::make(const Scene& scene, uint32_t seed) {
  auto shapes = std::make_unique<Shapes>();
  shapes->device = rtcNewDevice("threads=1,set_affinity=0");
  if (!shapes->device) return nullptr;
  shapes->scene = rtcNewScene(shapes->device);
  rtcSetSceneBuildQuality(shapes->scene, RTC_BUILD_QUALITY_HIGH);
  for (const SceneObject& o : scene.objects()) {
    const double ground = scene.ground(o.z);
    const auto index = static_cast<unsigned>(shapes->corners.size());
    const Mesh mesh = shape(o, ground, scramble(seed * 977 + index));
    RTCGeometry geometry = rtcNewGeometry(shapes->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size() / 3);
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size() / 3);
    if (!vertices || !triangles) return nullptr;
    std::copy(mesh.vertices.begin(), mesh.vertices.end(), static_cast<float*>(vertices));
    std::copy(mesh.triangles.begin(), mesh.triangles.end(), static_cast<unsigned*>(triangles));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(shapes->scene, geometry, index);
    rtcReleaseGeometry(geometry);
    Corners corners;
    for (unsigned k = 0; k < 8; ++k)
      corners[k] = placed(o, ground, (k & 1 ? 0.5 : -0.5) * o.width, k & 2 ? o.height : -sunk, (k & 4 ? 0.5 : -0.5) * o.depth);
    shapes->corners.push_back(corners);
  }
  rtcCommitScene(shapes->scene);
  if (rtcGetDeviceError(shapes->device) != RTC_ERROR_NONE) return nullptr;
  return std::unique_ptr<Tracer>(new Tracer(std::move(shapes)));
}

std::unique_ptr<Tracer::Probe, Tracer::EraseProbe> Tracer::make_probe() const {
  std::unique_ptr<Probe, EraseProbe> probe(new Probe{});
  std::fill(std::begin(probe->tnear), std::end(probe->tnear), nearest);
  std::fill(std::begin(probe->mask), std::end(probe->mask), ~0u);
  return probe;
}

void Tracer::trace(Probe& probe, const Look& look, Batch& batch) const noexcept {
  std::fill(std::begin(probe.org_x), std::end(probe.org_x), look.x);
  std::fill(std::begin(probe.org_y), std::end(probe.org_y), look.y);
  std::fill(std::begin(probe.org_z), std::end(probe.org_z), look.z);
  std::fill(std::begin(probe.instance), std::end(probe.instance), RTC_INVALID_GEOMETRY_ID);
  RTCRayHitNp rays{};
  rays.ray = {probe.org_x, probe.org_y, probe.org_z, probe.tnear, batch.dx, batch.dy, batch.dz, probe.time, batch.t, probe.mask, probe.id, probe.flags};
  rays.hit = {batch.nx, batch.ny, batch.nz, probe.u, probe.v, probe.prim, reinterpret_cast<unsigned*>(batch.object), {probe.instance}};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersectNp(shapes_->scene, &context, &rays, Batch::size);
}

void Tracer::mark(const Look& look, const Rays& rays, std::vector<uint8_t>& marks) const noexcept {
  std::fill(marks.begin(), marks.end(), uint8_t{0});
  for (const Corners& corners : shapes_->corners) {
    Rays::Bounds seen;
    if (!outline(look, corners, seen)) continue;
    for (size_t i = 0; i < marks.size(); ++i) {
      const Rays::Bounds& tile = rays.bounds[i];
      marks[i] |= static_cast<uint8_t>((tile.x0 <= seen.x1) & (tile.x1 >= seen.x0) & (tile.y0 <= seen.y1) & (tile.y1 >= seen.y0));
    }
  }
}

void Tracer::light(const Point* points, int count, const Point& direction, uint8_t* lit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (int first = 0; first < count; first += 16) {
    alignas(64) int valid[16];
    RTCRay16 rays{};
    for (int i = 0; i < 16; ++i) {
      const Point& p = points[std::min(first + i, count - 1)];
      valid[i] = first + i < count ? -1 : 0;
      rays.org_x[i] = static_cast<float>(p.x);
      rays.org_y[i] = static_cast<float>(p.y);
      rays.org_z[i] = static_cast<float>(p.z);
      rays.dir_x[i] = static_cast<float>(direction.x);
      rays.dir_y[i] = static_cast<float>(direction.y);
      rays.dir_z[i] = static_cast<float>(direction.z);
      rays.tnear[i] = 0.001f;
      rays.tfar[i] = far_away;
      rays.mask[i] = ~0u;
    }
    rtcOccluded16(valid, shapes_->scene, &context, &rays);
    for (int i = 0; i < 16 && first + i < count; ++i) lit[first + i] = rays.tfar[i] >= 0;
  }
}

}  // namespace vdisp::sim
