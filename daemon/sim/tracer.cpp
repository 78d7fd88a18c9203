// tracer.cpp: boxes, posts, walls and rocks as Embree meshes; rays in streams of one tile.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/sim/shapes.h"

namespace vdisp::sim {
namespace {

constexpr float nearest = 0.05f;  // m: a camera's nose
constexpr uint8_t fixed_marked = 1, moving_marked = 2;

/// Where the corners' hull lies in a view, in units of x / z; false: behind it.
bool outline(const Look& look, const Corners& corners, Rays::Bounds& bounds) {
  const float* m = look.axes;
  std::array<std::array<float, 3>, 8> seen;
  for (size_t i = 0; i < 8; ++i) {
    const float x = static_cast<float>(corners[i].x) - look.x, y = static_cast<float>(corners[i].y) - look.y,
                z = static_cast<float>(corners[i].z) - look.z;
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
  int32_t ground = -1;  ///< number of the ground's mesh, behind those of the objects; -1: it has none
  bool world = false;   ///< something is to be seen in every direction
  struct Moving {
    RTCGeometry geometry;
    float* vertices;
    size_t count;
    Mesh shape;  ///< about its own middle, not turned
  };
  RTCScene moving_scene = nullptr;
  std::vector<Moving> moving;
  std::vector<Corners> moving_corners;
  ~Shapes() {
    if (moving_scene) rtcReleaseScene(moving_scene);
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  /// False: no memory.
  bool add(const Mesh& mesh, unsigned index) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size() / 3);
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size() / 3);
    const bool fits = vertices && triangles;
    if (fits) {
      std::copy(mesh.vertices.begin(), mesh.vertices.end(), static_cast<float*>(vertices));
      std::copy(mesh.triangles.begin(), mesh.triangles.end(), static_cast<unsigned*>(triangles));
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene, geometry, index);
    }
    rtcReleaseGeometry(geometry);
    return fits;
  }
  bool add_moving(const SceneObject& o, unsigned index) {
    SceneObject bare = o;
    bare.x = bare.z = bare.yaw = 0;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    Moving part{geometry, nullptr, 0, shape(bare, 0, 0)};
    part.count = part.shape.vertices.size() / 3;
    part.vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, part.count));
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, part.shape.triangles.size() / 3);
    const bool fits = part.vertices && triangles;
    if (fits) {
      std::copy(part.shape.triangles.begin(), part.shape.triangles.end(), static_cast<unsigned*>(triangles));
      rtcAttachGeometryByID(moving_scene, geometry, index);
    }
    rtcReleaseGeometry(geometry);  // the scene keeps it
    moving.push_back(std::move(part));
    moving_corners.emplace_back();
    return fits;
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
  shapes->device = rtcNewDevice("set_affinity=0");
  if (!shapes->device) return nullptr;
  shapes->scene = rtcNewScene(shapes->device);
  rtcSetSceneBuildQuality(shapes->scene, RTC_BUILD_QUALITY_HIGH);
  shapes->world = scene.ride() != nullptr;
  if (scene.first_moving() < scene.objects().size()) {
    shapes->moving_scene = rtcNewScene(shapes->device);
    rtcSetSceneFlags(shapes->moving_scene, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(shapes->moving_scene, RTC_BUILD_QUALITY_LOW);
  }
  for (const SceneObject& o : scene.objects()) {
    const double ground = scene.ground(o.x, o.z);
    const auto index = static_cast<unsigned>(&o - scene.objects().data());
    if (index >= scene.first_moving()) {
      if (!shapes->add_moving(o, index)) return nullptr;
      continue;
    }
    if (!shapes->add(shape(o, ground, bumps(seed, index)), index)) return nullptr;
    for (const Corners& corners : boxes_around(o, ground)) shapes->corners.push_back(corners);
  }
  if (scene.terrain().meshed()) {
    rtcSetSceneFlags(shapes->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips through between two triangles
    shapes->ground = static_cast<int32_t>(scene.objects().size());
    if (!shapes->add(scene.terrain().mesh(), static_cast<unsigned>(shapes->ground))) return nullptr;
  }
  rtcCommitScene(shapes->scene);
  if (rtcGetDeviceError(shapes->device) != RTC_ERROR_NONE) return nullptr;
  std::unique_ptr<Tracer> tracer(new Tracer(std::move(shapes)));
  tracer->move(scene);
  return tracer;
}

void Tracer::move(const Scene& scene) noexcept {
  for (size_t i = 0; i < shapes_->moving.size(); ++i) {
    const SceneObject& o = scene.objects()[scene.first_moving() + i];
    const Shapes::Moving& part = shapes_->moving[i];
    const double c = std::cos(o.yaw), s = std::sin(o.yaw), ground = scene.ground(o.x, o.z);
    for (size_t k = 0; k < part.count; ++k) {
      const double x = part.shape.vertices[3 * k], y = part.shape.vertices[3 * k + 1], z = part.shape.vertices[3 * k + 2];
      part.vertices[3 * k] = static_cast<float>(o.x + c * x - s * z);
      part.vertices[3 * k + 1] = static_cast<float>(ground + y);
      part.vertices[3 * k + 2] = static_cast<float>(o.z + s * x + c * z);
    }
    shapes_->moving_corners[i] = boxes_around(o, ground)[0];
    rtcUpdateGeometryBuffer(part.geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(part.geometry);
  }
  if (shapes_->moving_scene) rtcCommitScene(shapes_->moving_scene);
}

std::unique_ptr<Tracer::Probe, Tracer::EraseProbe> Tracer::make_probe() const {
  std::unique_ptr<Probe, EraseProbe> probe(new Probe{});
  std::fill(std::begin(probe->tnear), std::end(probe->tnear), nearest);
  std::fill(std::begin(probe->mask), std::end(probe->mask), ~0u);
  return probe;
}

void Tracer::trace(Probe& probe, const Look& look, uint8_t mark, Batch& batch) const noexcept {
  std::fill(std::begin(probe.org_x), std::end(probe.org_x), look.x);
  std::fill(std::begin(probe.org_y), std::end(probe.org_y), look.y);
  std::fill(std::begin(probe.org_z), std::end(probe.org_z), look.z);
  std::fill(std::begin(probe.instance), std::end(probe.instance), RTC_INVALID_GEOMETRY_ID);
  RTCRayHitNp rays{};
  rays.ray = {probe.org_x, probe.org_y, probe.org_z, probe.tnear, batch.dx, batch.dy,
              batch.dz,    probe.time,  batch.t,     probe.mask,  probe.id, probe.flags};
  rays.hit = {batch.nx, batch.ny, batch.nz, probe.u, probe.v, probe.prim, reinterpret_cast<unsigned*>(batch.object), {probe.instance}};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  // What aim() takes for the ground is none where the ground has a mesh.
  if (shapes_->ground >= 0) std::fill(std::begin(batch.t), std::end(batch.t), far_away);
  rtcIntersectNp(shapes_->scene, &context, &rays, Batch::size);
  if (mark & moving_marked) rtcIntersectNp(shapes_->moving_scene, &context, &rays, Batch::size);
  if (shapes_->ground < 0) return;
  for (int32_t& object : batch.object)
    if (object == shapes_->ground) object = -1;
}

void Tracer::mark(const Look& look, const Rays& rays, std::vector<uint8_t>& marks) const noexcept {
  const auto meet = [](const Rays::Bounds& a, const Rays::Bounds& b) {
    return (a.x0 <= b.x1) & (a.x1 >= b.x0) & (a.y0 <= b.y1) & (a.y1 >= b.y0);
  };
  const auto add = [&](const Corners& corners, uint8_t mark) {
    Rays::Bounds seen;
    if (!outline(look, corners, seen)) return;
    for (int row = 0; row < rays.tiles_y; ++row) {
      if (!meet(rays.rows[static_cast<size_t>(row)], seen)) continue;
      for (int i = row * rays.tiles_x; i < (row + 1) * rays.tiles_x; ++i)
        if (meet(rays.bounds[static_cast<size_t>(i)], seen)) marks[static_cast<size_t>(i)] |= mark;
    }
  };
  const bool everywhere = shapes_->ground >= 0 || shapes_->world;
  std::fill(marks.begin(), marks.end(), everywhere ? fixed_marked : uint8_t{0});
  if (!everywhere)
    for (const Corners& corners : shapes_->corners) add(corners, fixed_marked);
  for (const Corners& corners : shapes_->moving_corners) add(corners, moving_marked);
}

void Tracer::light(const Point* points, int count, const Point& direction, float reach, uint8_t* lit) const {
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
      rays.tfar[i] = reach;
      rays.mask[i] = ~0u;
    }
    rtcOccluded16(valid, shapes_->scene, &context, &rays);
    for (int i = 0; i < 16 && first + i < count; ++i) lit[first + i] = rays.tfar[i] >= 0;
  }
}

}  // namespace vdisp::sim
