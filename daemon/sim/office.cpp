// office.cpp: a floor of an office building: a corridor, rooms to both sides with doors, furniture.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/sim/objects.h"
#include "daemon/sim/site.h"

namespace vdisp::sim {
namespace {

constexpr double tall = 2.5;  // m, of walls and doors

struct Room {
  double x0, x1, z0, z1;
  double corridor_z;  ///< of its side that has the door
};

Finish wooden(Chance& chance) { return {Surface::planks, chance.between(90, 180), 1}; }

std::vector<SceneObject> cabinet(Chance& chance, double width, double depth) {
  return {part(ObjectKind::box, 0, 0, width, depth, 0, chance.between(0.75, 1.9), wooden(chance))};
}

/// A table top on two sides that reach to the floor, and sometimes a back.
std::vector<SceneObject> desk(Chance& chance, double width, double depth) {
  const Finish wood = wooden(chance);
  std::vector<SceneObject> parts{part(ObjectKind::beam, 0, 0, width, depth, 0.69, 0.73, wood)};
  for (const double side : {-1.0, 1.0})
    parts.push_back(part(ObjectKind::box, side * (width / 2 - 0.03), 0, 0.05, depth * 0.9, 0, 0.69, wood));
  if (chance.below(2)) parts.push_back(part(ObjectKind::box, 0, depth * 0.3, width - 0.1, 0.03, 0.2, 0.69, wood));
  // A screen or a pile of paper on it.
  if (chance.below(2))
    parts.push_back(part(ObjectKind::beam, chance.between(-0.2, 0.2), 0.1, 0.5, 0.15, 0.73, 1.15, {Surface::stone, 50, 0.6}));
  return parts;
}

std::vector<SceneObject> chair(Chance& chance) {
  const Finish cloth{Surface::bark, chance.between(40, 160), 0.9};
  return {part(ObjectKind::post, 0, 0, 0.5, 0.5, 0, 0.09, {Surface::stone, 60, 0.7}),
          part(ObjectKind::post, 0, 0, 0.08, 0.08, 0, 0.42, {Surface::stone, 60, 0.7}),
          part(ObjectKind::box, 0, 0, 0.46, 0.44, 0.42, 0.5, cloth), part(ObjectKind::box, 0, 0.2, 0.42, 0.06, 0.5, 0.95, cloth)};
}

std::vector<SceneObject> bin(Chance& chance) {
  const double width = chance.between(0.28, 0.4);
  return {part(ObjectKind::post, 0, 0, width, width, 0, chance.between(0.35, 0.7), {Surface::bark, chance.between(60, 180), 1})};
}

std::vector<SceneObject> plant(Chance& chance) {
  return {part(ObjectKind::post, 0, 0, 0.36, 0.36, 0, 0.4, {Surface::stone, 130, 1}),
          part(ObjectKind::rock, 0, 0, 0.6, 0.6, 0, chance.between(0.9, 1.3), {Surface::bark, 80, 1.2})};
}

/// Something along one of the room's walls, its back to it.
bool along_wall(Site& site, const Room& room, const std::vector<SceneObject>& parts, double width, double depth) {
  constexpr double slit = 0.03;
  const double off = Site::wall_width / 2 + slit + depth / 2, half = width / 2 + 0.15;
  const int side = site.chance.below(4);
  const double x = site.chance.between(room.x0 + half, room.x1 - half), z = site.chance.between(room.z0 + half, room.z1 - half);
  const Spot at = side == 0   ? Spot{x, room.z1 - off}
                  : side == 1 ? Spot{room.x0 + off, z}
                  : side == 2 ? Spot{x, room.z0 + off}
                              : Spot{room.x1 - off, z};
  return site.put(parts, at, side * M_PI / 2, width, depth, Site::passage, 2 * slit);
}

void furnish(Site& site, const Room& room) {
  Chance& chance = site.chance;
  const double area = (room.x1 - room.x0) * (room.z1 - room.z0);
  const int things = std::max(2, static_cast<int>(area / 4));
  for (int i = 0, attempt = 0; i < things && attempt < 200; ++attempt) {
    const Spot at{chance.between(room.x0 + 0.9, room.x1 - 0.9), chance.between(room.z0 + 0.9, room.z1 - 0.9)};
    const double yaw = chance.below(4) * M_PI / 2 + chance.between(-0.3, 0.3);
    const double width = chance.between(0.6, 1.5);
    bool stands = false;
    switch (chance.below(6)) {
      case 0: stands = along_wall(site, room, cabinet(chance, width, 0.42), width, 0.42); break;
      case 1: stands = along_wall(site, room, desk(chance, 1.5, 0.75), 1.5, 0.75); break;
      case 2: stands = site.put(desk(chance, 1.5, 0.75), at, yaw, 1.5, 0.75, Site::passage); break;
      case 3: stands = site.put(chair(chance), at, chance.between(-M_PI, M_PI), 0.5, 0.5, Site::passage); break;
      case 4: stands = along_wall(site, room, bin(chance), 0.4, 0.4); break;
      default: stands = site.put(plant(chance), at, 0, 0.6, 0.6, Site::passage); break;
    }
    i += stands;
  }
}

/// The side of a room that has the door: two pieces of wall, and what the door is like.
void front(Site& site, const Room& room, const Finish& finish) {
  Chance& chance = site.chance;
  const double z = room.corridor_z, inwards = room.z0 < z - 0.1 ? -1 : 1, gap = chance.between(1.05, 1.35);
  const double door = chance.between(room.x0 + 0.7, room.x1 - 0.7 - gap);
  const int kind = chance.below(8);  // 0: shut; 1, 2: a leaf stands open; 3: no wall at all; else an open doorway
  const Finish leaf = {Surface::planks, chance.between(120, 190), 0.8};
  const bool glazed = site.glazier.below(5) < 2;
  if (kind == 3) {
    // A lobby; with glass, a front of panes beside its doorway.
    site.pane({room.x0, z}, {door, z});
    site.pane({door + gap, z}, {room.x1, z});
    site.keep_clear({door + gap / 2, z}, 1.1);
    return;
  }
  site.wall({room.x0, z}, {door, z}, tall, finish);
  site.wall({door + gap, z}, {room.x1, z}, tall, finish);
  site.keep_clear({door + gap / 2, z}, 1.2);
  if (kind == 0) {
    site.wall({door, z}, {door + gap, z}, tall, leaf, 0.06);
  } else if (kind <= 2) {
    const double open = chance.between(1.3, 1.7), size = gap - 0.1, hinge = door + 0.02;
    site.wall({hinge, z + inwards * 0.1}, {hinge + size * std::cos(open), z + inwards * (0.1 + size * std::sin(open))}, 2, leaf, 0.05);
  } else if (glazed) {
    site.pane({door, z}, {door + gap, z});
  }
}

void line_rooms(Site& site, double z0, double z1, double corridor_z, double length, const Finish& finish, std::vector<Room>& rooms) {
  double x = 0;
  while (x < length) {
    double next = x + site.chance.between(3.4, 5.6);
    if (length - next < 3.4) next = length;
    rooms.push_back({x, next, z0, z1, corridor_z});
    front(site, rooms.back(), finish);
    if (next < length) site.wall({next, z0}, {next, z1}, tall, finish);
    x = next;
  }
}

/// Bright panes in the outer walls: over-exposed, and without any texture.
void windows(Site& site, const Spot& far) {
  for (double x = 1.5; x < far.x - 1.5; x += site.chance.between(2.2, 4)) {
    for (const double z : {0.0, far.z}) {
      const double inside = Site::wall_width / 2 + 0.01;
      SceneObject o = part(ObjectKind::box, x, z == 0 ? inside : z - inside, 1.2, 0.02, 0.95, 2.1, {Surface::stone, 330, 0});
      o.textured = false;
      site.add(o);
    }
  }
}

}  // namespace

void build_office(Site& site) {
  Chance& chance = site.chance;
  const double length = chance.between(16, 24), wide = chance.between(1.9, 2.6), south = chance.between(4, 6), north = chance.between(4, 6);
  const Finish outer{Surface::bricks, chance.between(120, 180), 0.9},
      inner{chance.below(2) ? Surface::stone : Surface::bricks, chance.between(130, 190), 0.8};
  const Spot far{length, south + wide + north};
  site.enclose(far, tall, outer);
  site.world.ceiling = tall;
  site.world.to_light = {-0.30, -0.92, -0.25};
  std::vector<Room> rooms;
  line_rooms(site, 0, south, south, length, inner, rooms);
  line_rooms(site, south + wide, far.z, south + wide, length, inner, rooms);
  const double start = chance.between(4, length - 4), middle = south + wide / 2;
  site.keep_clear({start, middle}, 1.2);
  for (const Room& room : rooms) furnish(site, room);
  // Along the corridor's walls, so that a way of 1.1 m stays free.
  for (int i = 0; i < 6; ++i) {
    const double depth = 0.35, width = chance.between(0.4, 1.2), side = chance.below(2) ? 1 : -1;
    const Spot at{chance.between(1, length - 1), middle + side * (wide / 2 - Site::wall_width / 2 - 0.03 - depth / 2)};
    site.put(i % 2 ? cabinet(chance, width, depth) : bin(chance), at, 0, width, depth, 1.1, 0.06);
  }
  windows(site, far);
  site.start_at({start, middle}, chance.below(2) ? M_PI / 2 : -M_PI / 2);
}

}  // namespace vdisp::sim
