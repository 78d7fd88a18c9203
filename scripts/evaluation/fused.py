# fused.py: the map that remembers: kept obstacles in the simulator, and on a recorded street what stands still must stay where it is.
# SPDX-License-Identifier: Apache-2.0
import pathlib

import cv2
import numpy as np

from evaluation.daemon import Skipped
from evaluation.recorded import FLOOR_SETS, source
from evaluation.simulated import percentile

OCCUPIED = 65
LATER = 10  # frames, in which a car drives 12 m
PICTURES = pathlib.Path(__file__).resolve().parents[2] / "build" / "evaluation"
STREET = {"image source.matcher": "sgm", "image source.rate": 10, "control.maxSpeed": 30, "Map.range": 20, "Map.width": 16, "Map.cell": 0.25,
          "mounting.height": 1.65, "mounting.pitch": 0.0}


def signed(picture):
    return picture.astype(np.uint8).view(np.int8).astype(int)


def in_odometry(frame, stage, where):
    """Middles of cells (n x 2, x and y) of a grid in the odometry frame, where `where` of its values holds."""
    grid, place = frame.json["stages"][stage]["grid"], frame.json["memory"]
    rows, columns = np.nonzero(where(signed(frame.image(stage))))
    ahead, left = (grid["origin_row"] - rows - 0.5) * grid["cell"], (grid["origin_column"] - columns - 0.5) * grid["cell"]
    if grid["frame"] == 1:
        return np.stack([ahead, left], 1)
    # Frame h at [mounting] x, y, yaw of the rover, which the script takes to its place by itself.
    x, y, yaw = grid["pose"]
    ahead, left = (x + ahead * np.cos(yaw) - left * np.sin(yaw), y + ahead * np.sin(yaw) + left * np.cos(yaw))
    c, s = np.cos(place["yaw"]), np.sin(place["yaw"])
    return np.stack([place["x"] + c * ahead - s * left, place["y"] + s * ahead + c * left], 1)


class World:
    """Cells of the whole way."""

    def __init__(self, frames, cell):
        xs, ys = ([f["memory"][k] for f in frames] for k in ("x", "y"))
        self.cell, self.x, self.y = cell, min(xs) - 25, max(ys) + 25
        self.shape = (int((max(xs) - self.x + 45) / cell), int((self.y - min(ys) + 25) / cell))

    def draw(self, points):
        mask = np.zeros(self.shape, bool)
        i, j = np.floor((points[:, 0] - self.x) / self.cell).astype(int), np.floor((self.y - points[:, 1]) / self.cell).astype(int)
        inside = (i >= 0) & (j >= 0) & (i < self.shape[0]) & (j < self.shape[1])
        mask[i[inside], j[inside]] = True
        return mask


def wider(mask, cells=1):
    return cv2.dilate(mask.astype(np.uint8), np.ones((2 * cells + 1, 2 * cells + 1), np.uint8)) > 0


def best_shift(a, b, reach=4, as_good=0.95):
    """The shift of b, cells along x and y, with which most of a and b agree; of those as good as that the least: a wall agrees with itself
    along all of its length."""
    found = [(abs(i) + abs(j), i, j, np.count_nonzero(a & np.roll(b, (i, j), (0, 1)))) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)]
    most = max(agree for *_, agree in found)
    return min(shift for *shift, agree in found if agree >= as_good * most)[1:]


def look(frame):
    known = frame.valid("fused")
    look = {"memory": frame.json.get("memory"), "known": known, "timing": frame.json.get("sequence")}
    if known and look["memory"]["state"] == "fused":
        look["fused"] = in_odometry(frame, "fused", lambda v: v >= OCCUPIED)
        look["free"] = in_odometry(frame, "fused", lambda v: (v >= 0) & (v < OCCUPIED))
        look["frame"] = in_odometry(frame, "occupancy", lambda v: v >= OCCUPIED)
    return look


def street(daemon, section):
    folder = daemon.set_folder("kitti_street")
    sets = {**source(daemon, "kitti_street", FLOOR_SETS["kitti_street"]), "image source.odometry": str(folder / "poses.txt"), **STREET}
    section.command(daemon.command_line(sets))
    frames = [f for f in daemon.measure("fused/street", sets, None, look) if "fused" in f]
    cell = STREET["Map.cell"]
    if not frames:
        section.gate("static obstacles stay put within one cell", False, "no frame with a fused map", "at most 1")
        return
    world = World(frames, cell)
    rows = []
    for k in range(0, len(frames) - LATER):
        then, later = world.draw(frames[k]["frame"]), world.draw(frames[k + LATER]["fused"])
        # Of obstacles that are still inside the grid, and were near enough to be placed to a cell.
        place, now = frames[k]["memory"], frames[k + LATER]["memory"]
        near = frames[k]["frame"]
        near = near[(np.hypot(*(near - [place["x"], place["y"]]).T) < 12) & (np.hypot(*(near - [now["x"], now["y"]]).T) < 20)]
        if len(near) < 20:
            continue
        then = world.draw(near)
        shift = best_shift(then, later)
        rows.append({"shift": max(map(abs, shift)), "kept": (then & wider(later)).sum() / then.sum()})
    union = np.zeros(world.shape, bool)
    for f in frames:
        union |= world.draw(f["frame"])
    last = np.zeros(world.shape, bool)
    free = np.zeros(world.shape, bool)
    for f in frames:
        now, clear = world.draw(f["fused"]), world.draw(f["free"])
        last, free = (last & ~clear) | now, (free & ~now) | clear
    beside = (last & ~wider(union)).sum() / max(last.sum(), 1)
    section.table([("frames", "d"), ("compared", "d"), ("greatest shift [cells]", "d"), ("shifted by more than 0", ".3f"), ("kept, median", ".3f"), ("kept, 10th percentile", ".3f"),
                   ("cells of one frame or more", "d"), ("fused cells", "d"), ("fused, farther than a cell from any of them", ".4f")],
                  [{"frames": len(frames), "compared": len(rows), "greatest shift [cells]": max((r["shift"] for r in rows), default=0),
                    "shifted by more than 0": float(np.mean([r["shift"] > 0 for r in rows] or [0])),
                    "kept, median": percentile([r["kept"] for r in rows], 50), "kept, 10th percentile": percentile([r["kept"] for r in rows], 10),
                    "cells of one frame or more": int(union.sum()), "fused cells": int(last.sum()), "fused, farther than a cell from any of them": float(beside)}],
                  f"kitti_street, poses.txt as odometry, cells of {cell} m: obstacle cells of one frame (within 12 m, placed by the script) against "
                  f"the fused map {LATER} frames later. Shift: with which the two agree best. Kept: has a fused obstacle within one cell.")
    greatest = max((r["shift"] for r in rows), default=None)
    section.gate("static obstacles stay put within one cell", greatest is not None and greatest <= 1, f"{greatest} cells", "at most 1")
    section.gate("no smear: fused cells lie within a cell of what frames saw", beside < 0.01, f"{100 * beside:.2f} %", "less than 1 %")
    picture = np.full((*world.shape, 3), 28, np.uint8)
    picture[free], picture[last] = (70, 110, 60), (60, 70, 235)
    frames_only = np.full_like(picture, 28)
    frames_only[union] = (60, 170, 235)
    for f in frames:
        for p in (picture, frames_only):
            cv2.circle(p, (int((world.y - f["memory"]["y"]) / cell), int((f["memory"]["x"] - world.x) / cell)), 1, (255, 200, 80), -1)
    PICTURES.mkdir(parents=True, exist_ok=True)
    both = np.hstack([picture[::-1], np.full((picture.shape[0], 6, 3), 255, np.uint8), frames_only[::-1]])
    cv2.imwrite(str(PICTURES / "fused-street.png"), cv2.resize(both, None, fx=3, fy=3, interpolation=cv2.INTER_NEAREST))
    section.note("build/evaluation/fused-street.png: left the fused map as it was last told of each place (red obstacle, green floor), right the obstacle cells of all single frames, blue the way")


def drive_look(frame):
    result = look(frame)
    scene = frame.json["truth_scene"]
    c, s, rover = np.cos(scene["rover"]["yaw_rad"]), np.sin(scene["rover"]["yaw_rad"]), scene["rover"]
    result["objects"] = [(rover["x_m"] + c * o["z"] + s * o["x"], rover["y_m"] + s * o["z"] - c * o["x"], o) for o in scene["objects"]]
    result["tracks"] = frame.json["tracks"]["tracks"]
    return result


def around(points, x, y, reach):
    return bool(len(points)) and bool((np.hypot(points[:, 0] - x, points[:, 1] - y) <= reach).any())


def drive(daemon, section):
    """Obstacles once seen from 1.2 to 4 m ahead, well inside the view, must be in the map when they are behind or beside the rover."""
    seeds, count = (range(1, 3), 300) if daemon.quick else (range(1, 5), 600)
    runs = [(f"fused/drive-{seed}", {"image source.source": "sim", "sim.scene": "drive", "sim.rate": 15, "sim.odometry": "yes", "sim.seed": seed}, count) for seed in seeds]
    section.command(daemon.command_line(runs[0][1], count))
    seen = kept = wrong = fused = still = moving = 0
    speeds = []
    for frames in daemon.measure_all("fused drive", runs, drive_look):
        sure, last = {}, {}
        for f in frames:
            if "fused" not in f:
                continue
            here = np.array([f["memory"]["x"], f["memory"]["y"]])
            for x, y, o in f["objects"]:
                key = (round(x, 1), round(y, 1))
                reach = np.hypot(o["width"], o["depth"]) / 2 + 0.15
                near = around(f["frame"], x, y, reach)
                if near and 1.2 < o["z"] < 4 and o["height"] > 0.25:
                    sure[key] = sure.get(key, 0) + 1
                last[key] = (x, y, reach)
            for t in f["tracks"]:
                if t["age_s"] > 1:
                    still, moving = still + 1, moving + t["moving"]
                    speeds.append(float(np.hypot(t["speed_x"], t["speed_y"])))
            fused += len(f["fused"])
            places = np.array([(x, y) for x, y, _ in last.values()]) if last else np.zeros((0, 2))
            sizes = np.array([r for *_, r in last.values()])
            for p in f["fused"]:
                wrong += not (np.hypot(*(places - p).T) <= sizes + 0.1).any()
            for key, times in sure.items():
                x, y, reach = last[key]
                if times < 5 or np.hypot(x - here[0], y - here[1]) > 5 or any((round(a, 1), round(b, 1)) == key and o["z"] > 0.8 for a, b, o in f["objects"]):
                    continue
                seen, kept = seen + 1, kept + around(f["fused"], x, y, reach)
    section.table([("runs", "d"), ("obstacles x frames out of view", "d"), ("kept", ".4f"), ("fused obstacle cells", "d"), ("farther than a cell from any obstacle", ".5f"),
                   ("tracks older than 1 s", "d"), ("called moving", ".4f"), ("speed told, median [m/s]", ".3f"), ("90th percentile", ".3f")],
                  [{"runs": len(runs), "obstacles x frames out of view": seen, "kept": kept / max(seen, 1), "fused obstacle cells": fused,
                    "farther than a cell from any obstacle": wrong / max(fused, 1), "tracks older than 1 s": still, "called moving": moving / max(still, 1),
                    "speed told, median [m/s]": percentile(speeds, 50), "90th percentile": percentile(speeds, 90)}],
                  "Simulator, scene drive with its odometry: obstacles seen in five frames or more, then nearer than 0.8 m ahead, beside or behind the rover within 5 m. All stand.")
    section.gate("obstacles out of view are kept", kept >= 0.98 * seen > 0, f"{kept} of {seen}", "98 %")
    section.gate("no obstacle is remembered where none ever was", fused > 0 and wrong < 0.001 * fused, f"{wrong} of {fused} cells", "less than 0.1 %")


def fused_section(daemon, section):
    drive(daemon, section)
    try:
        street(daemon, section)
    except Skipped as why:
        section.note(f"kitti_street skipped: {why}")
