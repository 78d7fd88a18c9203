# truth.py: what the simulator's truth stages say of a frame, and how the daemon's map compares with it.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np

import evaluation.geometry as geometry

GROUND, UNLISTED, SKY = 0, 254, 255
# Values of truth/map_cells.
OUTSIDE, FREE, OBSTACLE, DROP_OFF, OVERHANG, HIDDEN, BELOW = range(7)
CLEARANCE = 1.0  # m: what hangs at least so high is not in the way; the scenes have nothing near it
CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])


class TruthObject:
    """One obstacle as the left camera sees it; cells are masks of the map's grid."""

    def __init__(self, entry):
        self.entry = entry
        self.pixels = 0         # seen, matchable, higher than max_height
        self.share = 0.0        # of its outline that is seen and matchable
        self.distance = np.inf  # m ahead, of its nearest seen point higher than max_height
        self.front = None       # cells of what is seen within one cell's length of the nearest point
        self.contour = None     # cells of the nearest point of each image column
        self.middle = None      # m ahead, mean of those pixels
        self.must_be_found = False


class SceneTruth:
    """Truth of one frame, made from truth/disparity, truth/object, truth/height and truth_scene alone.

    An object must be found if it is textured (or plain_counts), stands or hangs lower than CLEARANCE, is at least 0.3 m tall and wide, its nearest point (higher than max_height) lies 1 to
    4.5 m ahead in the map, and at least half of its outline is seen and matchable: not hidden, inside the image, not in the left
    border that has no counterpart in the right view (u < ndisp - 1 + half the window), nor nearer than f B / (ndisp - 1).
    """

    def __init__(self, frame, grid, max_height=0.2, ndisp=48, corrsize=11, plain_counts=False):
        scene, camera = frame.json["truth_scene"], frame.camera("truth/disparity")
        self.pitch, self.roll, self.height = scene["pitch_rad"], scene["roll_rad"], scene["height_m"]
        self.grid, self.camera, self.plain_counts = grid, camera, plain_counts
        disparity = frame.image("truth/disparity") / 16.0
        number = frame.image("truth/object")
        true_disparity = disparity - camera["cx_offset"]
        seen = (disparity > 0) & (true_disparity > 0)
        depth = np.where(seen, camera["f"] * camera["baseline"] / np.where(seen, true_disparity, 1), np.nan)
        self.x, y, self.z = geometry.level(geometry.camera_points(camera, depth), self.pitch, self.roll)
        self.above = (frame.image("truth/height").astype(int) - 32768) / 1000.0  # m above the ground at its place
        self.matchable = seen & (disparity <= ndisp - 1) & geometry.matchable(ndisp, corrsize, disparity.shape)
        high = seen & (number != GROUND) & (number != SKY) & (self.above > max_height)
        self.occupied = grid.mask(self.x[high], self.z[high])
        hanging = np.isin(number, [o["number"] for o in scene["objects"] if o["bottom"] >= CLEARANCE])
        low = high & ~hanging
        self.in_the_way = grid.mask(self.x[low], self.z[low])  # as occupied, without what hangs high
        plain = np.isin(number, [o["number"] for o in scene["objects"] if not o["textured"]])
        sure = low & self.matchable & ~plain
        self.to_be_seen = grid.counts(self.x[sure], self.z[sure]) >= 10  # cells with so many pixels of what can be matched
        on_ground = self.matchable & (number == GROUND)
        self.ground = grid.mask(self.x[on_ground], self.z[on_ground])  # cells whose ground can be matched
        self.kind = frame.image("truth/map_cells")
        self.drop = scene["drop"]
        self.objects = []
        for entry in scene["objects"]:
            item = TruthObject(entry)
            self.look(item, number == entry["number"], high)
            self.objects.append(item)
            if entry["height"] >= max_height:
                footprint = self.footprint(entry)
                self.occupied |= footprint
                if entry["bottom"] < CLEARANCE:
                    self.in_the_way |= footprint

    def look(self, item, mine, high):
        usable = mine & high & self.matchable
        item.pixels = int(np.count_nonzero(usable))
        if item.pixels == 0:
            return
        entry = item.entry
        item.share = np.count_nonzero(mine & self.matchable) / max(self.outline_area(entry), 1.0)
        x, z = self.x[usable], self.z[usable]
        item.distance = float(z.min())
        item.middle = float(z.mean())
        near = z <= item.distance + self.grid.cell
        item.front = self.grid.mask(x[near], z[near])
        columns = np.nonzero(usable.any(axis=0))[0]
        nearest = np.where(usable[:, columns], self.z[:, columns], np.inf).argmin(axis=0)
        item.contour = self.grid.mask(self.x[nearest, columns], self.z[nearest, columns])
        item.must_be_found = bool((entry["textured"] or self.plain_counts) and entry["bottom"] < CLEARANCE and entry["height"] >= 0.3 and entry["width"] >= 0.3
                                  and 1.0 <= item.distance <= 4.5 and item.share >= 0.5 and item.front.any())

    def outline_area(self, entry):
        """Pixels of the box around the object, drawn by the camera: convex hull of its corners. A rock fills less of its box."""
        corners = CORNERS * (entry["width"], entry["height"] - entry["bottom"], entry["depth"])
        up = entry["base"] + entry["bottom"] + corners[:, 1]
        sin, cos = np.sin(entry["yaw"]), np.cos(entry["yaw"])
        # Yaw is positive to the left, x to the right.
        x = entry["x"] + corners[:, 0] * cos - corners[:, 2] * sin
        z = entry["z"] + corners[:, 0] * sin + corners[:, 2] * cos
        xc, yc, zc = geometry.unlevel((x, self.height - up, z), self.pitch, self.roll)
        zc = np.maximum(zc, 0.05)
        f = self.camera["f"]
        hull = cv2.convexHull(np.stack([f * xc / zc, f * yc / zc], axis=1).astype(np.float32))
        return cv2.contourArea(hull) * (np.pi / 4 if entry["kind"] == "rock" else 1.0)

    def footprint(self, entry):
        """Cells that the object stands on."""
        along, across = np.meshgrid(np.linspace(-0.5, 0.5, 60) * entry["width"], np.linspace(-0.5, 0.5, 60) * entry["depth"])
        sin, cos = np.sin(entry["yaw"]), np.cos(entry["yaw"])
        return self.grid.mask(entry["x"] + along * cos - across * sin, entry["z"] + along * sin + across * cos)


def shift(item, counts, grid):
    """How much farther ahead than in truth the object's pixels lie in the map, m; counts within 0.3 m of its front."""
    near = counts * geometry.wider(item.contour, 3)
    if not near.any():
        return None
    ahead = (grid.rows - 0.5 - np.arange(grid.rows)) * grid.cell
    return float((near.sum(axis=1) * ahead).sum() / near.sum() - item.middle)


def compare_map(frame, truth, min_count=3):
    """The daemon's map against a SceneTruth. A blind map finds nothing."""
    counts = frame.image("map") if frame.valid("map") else np.zeros((truth.grid.rows, truth.grid.columns), np.uint16)
    return compare_found(counts >= min_count, not frame.valid("map"), counts, truth, truth.occupied)


def compare_found(found, blind, counts, truth, occupied):
    """Cells said to be obstacles against a SceneTruth; `occupied` are the cells where they are right."""
    reached = geometry.wider(found)
    objects = []
    contours = np.zeros_like(found)
    for item in truth.objects:
        if item.pixels == 0:
            continue
        contours |= item.contour
        objects.append({
            "number": item.entry["number"], "kind": item.entry["kind"], "must": item.must_be_found,
            "height": item.entry["height"], "width": item.entry["width"], "distance": item.distance, "pixels": item.pixels,
            "share": item.share, "hit": bool((item.front & reached).any()), "shift": shift(item, counts * found, truth.grid),
            "covered": float((item.contour & reached).sum() / max(item.contour.sum(), 1)),
        })
    false = found & ~geometry.wider(occupied)
    distance = geometry.distance_to(contours, truth.grid.cell)[found]
    return {"objects": objects, "blind": blind, "found": int(found.sum()), "false": int(false.sum()),
            "false_cells": [(int(r), int(c)) for r, c in np.argwhere(false)],
            "distances": distance[np.isfinite(distance)].tolist()}
