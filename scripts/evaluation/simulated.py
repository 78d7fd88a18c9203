# simulated.py: sections on simulated scenes: floor, obstacles, free ground, and the paper's stability experiment.
# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np

import evaluation.geometry as geometry
from evaluation.truth import SceneTruth, compare_map

DEGREE = math.pi / 180
PAPER = {"image source.source": "sim", "sim.rate": 0, "sim.cameraHeight": 0.8, "sim.pitch": 0.2618}
GRID = geometry.Grid()
MATCHERS = ("bm", "sgm")


def percentile(values, share):
    values = [v for v in values if v is not None]
    return float(np.percentile(values, share)) if values else None


def mean(values):
    values = list(values)
    return float(np.mean(values)) if values else None


def look_at_scene(frame):
    """All that the sections want to know of one frame of a simulated scene."""
    floor, scene = frame.floor, frame.json["truth_scene"]
    found = floor["state"] == "found"
    return {
        "frame": str(frame.folder), "found": found,
        "pitch_error": (floor["pitch_rad"] - scene["pitch_rad"]) / DEGREE if found else None,
        "height_error": 100 * (floor["height_m"] / scene["height_m"] - 1) if found else None,
        "map": compare_map(frame, SceneTruth(frame, GRID)),
    }


def flat_frames(daemon, matcher):
    """Frames of 50 flat scenes, run once for all sections that want them: {seed: [look, ...]}."""
    key = ("flat", matcher)
    if key not in daemon.memo:
        seeds = range(1, 11 if daemon.quick else 51)
        sets = {**PAPER, "image source.matcher": matcher, "sim.scene": "flat"}
        runs = [(f"flat-{matcher}/{s}", {**sets, "sim.seed": s}, 4) for s in seeds]
        daemon.memo[key] = dict(zip(seeds, daemon.measure_all(f"flat scenes, {matcher}", runs, look_at_scene)))
    return daemon.memo[key]


def flat_command(daemon, section):
    sets = {**PAPER, "image source.matcher": "MATCHER", "sim.scene": "flat", "sim.seed": "1..50"}
    section.command(daemon.command_line(sets, 4))


def floor_section(daemon, section):
    rows = []
    for matcher in MATCHERS:
        scenes = flat_frames(daemon, matcher)
        looks = [(seed, i, look) for seed, frames in scenes.items() for i, look in enumerate(frames)]
        pitch = [abs(l["pitch_error"]) if l["found"] else math.inf for _, _, l in looks]
        height = [abs(l["height_error"]) if l["found"] else math.inf for _, _, l in looks]
        good = [p <= 0.3 and h <= 1 for p, h in zip(pitch, height)]
        outside = [{"seed": s, "frame": i, "pitch_error": l["pitch_error"], "height_error": l["height_error"]}
                   for (s, i, l), g in zip(looks, good) if not g]
        rows.append({"matcher": matcher, "seeds": len(scenes), "frames": len(looks),
                     "found": mean(l["found"] for _, _, l in looks),
                     "pitch error p50 [deg]": percentile(pitch, 50), "p90": percentile(pitch, 90), "max": max(pitch),
                     "height error p50 [%]": percentile(height, 50), "p90 ": percentile(height, 90), "max ": max(height),
                     "frames within": mean(good), "outside": outside})
        if matcher == "bm":
            missed = sorted({s for (s, _, _), g in zip(looks, good) if not g})
            section.gate("every frame: pitch within 0.3 deg and height within 1 % of the truth", all(good),
                         f"{sum(good)} of {len(good)} frames; pitch at most {max(pitch):.2f} deg off, height {max(height):.2f} %"
                         + (f"; missed in seeds {missed}" if missed else ""), "all")
    columns = [("matcher", ""), ("seeds", "d"), ("frames", "d"), ("found", ".3f"), ("pitch error p50 [deg]", ".3f")]
    columns += [("p90", ".3f"), ("max", ".3f"), ("height error p50 [%]", ".2f"), ("p90 ", ".2f"), ("max ", ".2f")]
    columns += [("frames within", ".3f")]
    section.table(columns, rows,
                  "Floor of scene `flat`, the paper's mounting (0.8 m, 15 deg) and parameters; camera noise, distortion and "
                  "misalignment as they are by default.")
    flat_command(daemon, section)


def recall(maps):
    """Found and all objects that must be found."""
    must = [o for m in maps for o in m["objects"] if o["must"]]
    return sum(o["hit"] for o in must), len(must)


def obstacle_section(daemon, section):
    rows = []
    for matcher in MATCHERS:
        scenes = flat_frames(daemon, matcher)
        looks = [(seed, i, l["map"]) for seed, frames in scenes.items() for i, l in enumerate(frames)]
        maps = [m for _, _, m in looks]
        hits, must = recall(maps)
        objects = [o for m in maps for o in m["objects"]]
        textured = [o for o in objects if o["pixels"] >= 100]
        missed = [{"seed": s, "frame": i, **o} for s, i, m in looks for o in m["objects"] if o["must"] and not o["hit"]]
        false = [{"seed": s, "frame": i, "cells": m["false_cells"]} for s, i, m in looks if m["false"]]
        rows.append({"matcher": matcher, "frames": len(maps), "to find": must, "found": hits / max(must, 1),
                     "front covered": mean(o["covered"] for o in objects if o["must"]),
                     "any of 100 px found": mean(o["hit"] for o in textured),
                     "shift [m]": mean(abs(o["shift"]) for o in objects if o["must"] and o["shift"] is not None),
                     "blind frames": sum(m["blind"] for m in maps), "obstacle cells": sum(m["found"] for m in maps),
                     "false cells": sum(m["false"] for m in maps), "frames with false": len(false),
                     "distance p50 [m]": percentile([d for m in maps for d in m["distances"]], 50),
                     "p90": percentile([d for m in maps for d in m["distances"]], 90), "missed": missed, "false": false})
        if matcher == "bm":
            where = ", ".join(f"seed {o['seed']} frame {o['frame']} object {o['number']} ({o['kind']})" for o in missed[:8])
            found = f"{hits} of {must} = {100 * hits / max(must, 1):.2f} %" + (f"; missed: {where}" if where else "")
            section.gate("obstacles >= 0.3 m, 1 to 4.5 m away, matchable: an obstacle cell within one cell of the front",
                         must > 0 and hits >= 0.98 * must, found, ">= 98 %")
    columns = [("matcher", ""), ("frames", "d"), ("to find", "d"), ("found", ".4f"), ("front covered", ".3f")]
    columns += [("any of 100 px found", ".3f"), ("shift [m]", ".3f"), ("blind frames", "d"), ("obstacle cells", "d")]
    columns += [("false cells", "d"), ("frames with false", "d"), ("distance p50 [m]", ".3f"), ("p90", ".3f")]
    section.table(columns, rows,
                  "Map of the same frames. Shift: how far an object's pixels in the map lie from their true place, ahead. "
                  "False: farther than one cell from anything higher than max_height. Distance: of obstacle cells to a true "
                  "front.")
    flat_command(daemon, section)


def free_section(daemon, section):
    rows = []
    for matcher in MATCHERS:
        seeds, frames = (4, 25) if daemon.quick or matcher != "bm" else (20, 50)
        sets = {**PAPER, "image source.matcher": matcher, "sim.scene": "empty"}
        runs = [(f"empty-{matcher}/{s}", {**sets, "sim.seed": s}, frames) for s in range(1, seeds + 1)]

        def look(frame):
            cells = np.argwhere(frame.image("map") >= 3).tolist() if frame.valid("map") else []
            return frame.valid("map"), cells, frame.json["sequence"]

        results = daemon.measure_all(f"empty scenes, {matcher}", runs, look)
        looks = [(s, *l) for s, run in enumerate(results, 1) for l in run]
        wrong = [{"seed": s, "frame": n, "cells": c} for s, _, c, n in looks if c]
        blind = sum(not valid for _, valid, _, _ in looks)
        rows.append({"matcher": matcher, "frames": len(looks), "blind frames": blind, "frames with a cell": len(wrong),
                     "cells": sum(len(w["cells"]) for w in wrong), "wrong": wrong[:50]})
        if matcher == "bm":
            section.gate("no obstacle cell on free ground, and no blind frame", not wrong and not blind,
                         f"{len(wrong)} of {len(looks)} frames have one, {blind} are blind"
                         + (f"; first: seed {wrong[0]['seed']} frame {wrong[0]['frame']}" if wrong else ""), "0")
    section.table([("matcher", ""), ("frames", "d"), ("blind frames", "d"), ("frames with a cell", "d"), ("cells", "d")], rows,
                  "Scene `empty`, noise of 2 grey levels.")
    sets = {**PAPER, "image source.matcher": "MATCHER", "sim.scene": "empty", "sim.seed": "1..20"}
    section.command(daemon.command_line(sets, 50))


AUTO = {"Limit obstacle.angRot": "auto", "Map.angRot": "auto"}
FIXED = {"Limit obstacle.angRot": 0.2618, "Map.angRot": 0.2618}


def stability_cases():
    """(what is changed, value shown, parameters)"""
    for height in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2):
        yield "height [m]", height, {**FIXED, "sim.cameraHeight": height}
    for word, angle in (("X, angRot fixed", FIXED), ("X, angRot auto", AUTO)):
        for degrees in (5, 7.5, 10, 12.5, 15, 17.5, 20, 22.5, 25):
            yield f"{word} [deg]", degrees, {**angle, "sim.pitch": round(degrees * DEGREE, 5)}
    for degrees in (-30, -15, 0, 15, 30):
        yield "Y [deg]", degrees, {**FIXED, "sim.yaw": round(degrees * DEGREE, 5)}
    for word, told in (("Z", False), ("Z, roll told", True)):
        for degrees in (0, 1, 2, 3, 4, 6, 8):
            roll = round(degrees * DEGREE, 5)
            yield f"{word} [deg]", degrees, {**FIXED, "sim.roll": roll, **({"mounting.roll": roll} if told else {})}


def stability_section(daemon, section):
    seeds = 2 if daemon.quick else 5
    cases = list(stability_cases())
    runs = [(f"stability/{n}-{s}", {**PAPER, "sim.scene": "flat", **sets, "sim.seed": s}, 2)
            for n, (_, _, sets) in enumerate(cases) for s in range(1, seeds + 1)]
    results = daemon.measure_all("stability", runs, look_at_scene)
    rows = []
    for n, (what, value, sets) in enumerate(cases):
        looks = [l for run in results[n * seeds : (n + 1) * seeds] for l in run]
        maps = [l["map"] for l in looks]
        hits, must = recall(maps)
        shifts = [o["shift"] for m in maps for o in m["objects"] if o["must"] and o["shift"] is not None]
        rows.append({"changed": what, "value": value, "floor found": mean(l["found"] for l in looks),
                     "pitch error [deg]": mean(abs(l["pitch_error"]) for l in looks if l["found"]),
                     "height error [%]": mean(abs(l["height_error"]) for l in looks if l["found"]),
                     "map shift [m]": mean(shifts),
                     "map distance p50 [m]": percentile([d for m in maps for d in m["distances"]], 50), "to find": must,
                     "found": hits / must if must else None, "false cells a frame": mean(m["false"] for m in maps)})
    columns = [("changed", ""), ("value", "g"), ("floor found", ".2f"), ("pitch error [deg]", ".3f"), ("height error [%]", ".2f")]
    columns += [("map shift [m]", ".3f"), ("map distance p50 [m]", ".3f"), ("to find", "d"), ("found", ".3f")]
    section.table(columns + [("false cells a frame", ".2f")], rows,
                  f"The paper's experiment 4.1: one thing changed at a time from 0.8 m, 15 deg; {seeds} scenes, 2 frames each;"
                  " errors are means. Axes as in the paper: X is pitch, Y is yaw, Z is roll. Map shift: how much too far an "
                  "object lies in the map.")
    sets = {**PAPER, "sim.scene": "flat", **FIXED, "sim.roll": 0.06981, "sim.seed": f"1..{seeds}"}
    section.command(daemon.command_line(sets, 2))
