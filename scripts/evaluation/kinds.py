# kinds.py: sections on kinds of simulated scenes: sloping, bumpy, crowded, with drop-offs or beams; and with nothing to be seen.
# SPDX-License-Identifier: Apache-2.0
import numpy as np

import evaluation.geometry as geometry
from evaluation.simulated import DEGREE, GRID, PAPER, mean, percentile, recall
from evaluation.truth import BELOW, DROP_OFF, FREE, HIDDEN, OBSTACLE, OUTSIDE, SceneTruth, compare_found

SEEDS, OCCUPIED, EMPTY = 50, 65, 35  # occupancy from 65 on is an obstacle, to 35 free


def spread(least, most):
    """From seed to seed over the range, in a mixed order, so that few seeds cover it too."""
    return lambda seed: round((least + (most - least) * (seed * 21 % SEEDS) / (SEEDS - 1)) * DEGREE, 5)


LEVEL = {"sim.pitch": 0.1, "Limit obstacle.angRot": 0.1, "Map.angRot": 0.1}
# name: (parameters, a number or a function of the seed; frames of each seed; what it is)
# What the operator has measured with a tape.
MEASURED = {"mounting.height": 0.8, "mounting.pitch": 0.2618}
KINDS = {
    "flat": ({}, 4, "level ground"),
    "roll": ({"sim.roll": spread(-10, 10)}, 4, "roll -10 to 10 deg"),
    "pitching": ({"sim.pitching": round(5 * DEGREE, 5), "sim.pitchingRate": 2}, 15, "pitching 5 deg up and down at 2 Hz, one period"),
    "slope": ({"sim.slope": spread(-15, 15)}, 4, "slope -15 to 15 deg from 1 m ahead on"),
    "ramp": ({"sim.ground": "ramp", "sim.slope": spread(-15, 15)}, 4, "the same from 1.5 to 3 m ahead on"),
    "crest": ({"sim.ground": "crest", "sim.slope": spread(3, 15)}, 4, "up and down again by 3 to 15 deg"),
    "brow": ({"sim.ground": "ramp", "sim.slope": spread(-28, -10)}, 4, "falls by 10 to 28 deg, far side seen or not"),
    "rough": ({"sim.roughness": 0.05}, 4, "bumps of 5 cm"),
    "crowded": ({"sim.scene": "crowded"}, 4, "70 % of the floor covered"),
    "texture": ({"sim.texture": 0.3}, 4, "contrast of all textures 0.3"),
    "kerb": ({"sim.ground": "kerb"}, 4, "step down of 0.3 to 1 m, 1.2 to 3 m ahead"),
    "ditch": ({"sim.ground": "ditch"}, 4, "ditch as deep, there"),
    "blank": ({"sim.scene": "blank"}, 4, "boxes and walls without texture, posts side by side"),
    "overhangs": ({"sim.scene": "overhangs", "Limit obstacle.clearance": 1, **LEVEL}, 4, "beams at 1.2 to 1.6 m, and at 0.3 to 0.7 m; pitch 0.1 rad"),
}


def seeds_of(daemon):
    first = daemon.first or 1
    return range(first, first + (8 if daemon.quick else SEEDS))


def chosen(daemon):
    return [name for name in KINDS if not daemon.kinds or name in daemon.kinds]


def parameters(daemon, kind, seed, **more):
    sets = {**PAPER, **MEASURED, "sim.scene": "flat", **KINDS[kind][0], "sim.seed": seed, **more, **daemon.sets}
    return {key: value(seed) if callable(value) else value for key, value in sets.items()}


def occupancy(frame):
    """-1..100, or None where the daemon has no such stage; a blind one is unknown everywhere."""
    if "occupancy" not in frame.json["stages"]:
        return None
    if not frame.valid("occupancy"):
        return np.full((GRID.rows, GRID.columns), -1)
    return frame.image("occupancy").astype(np.uint8).view(np.int8).astype(int)


def look_at_edge(found, truth):
    """(cells of the near edge of a drop-off that can be seen 1 to 3 m ahead, how many of them have a found cell within one)."""
    if not truth.drop:
        return 0, 0
    (x0, z0), (x1, z1) = truth.drop["left"], truth.drop["right"]
    part = np.linspace(0, 1, 4000)
    x, z = x0 + part * (x1 - x0), z0 + part * (z1 - z0)
    # Seen: the ground just before it can be matched, and it is not outside or behind something.
    edge = GRID.mask(x, z) & (truth.kind == DROP_OFF) & geometry.wider(truth.ground & (truth.kind == FREE))
    ahead = (GRID.rows - 0.5 - np.arange(GRID.rows)) * GRID.cell
    edge &= ((ahead >= 1) & (ahead <= 3))[:, None]
    return int(edge.sum()), int((edge & geometry.wider(found)).sum())


def beyond_edge(truth):
    """Cells that lie over a drop-off, and what its walls hide. Where the near edge is close, its bottom lies below the picture's lower border: the truth
    calls these cells outside, but the ground ends there all the same."""
    if not truth.drop:
        return np.zeros_like(truth.ground)
    (x0, z0), (x1, z1) = truth.drop["left"], truth.drop["right"]
    x = (np.arange(GRID.columns) + 0.5 - GRID.columns / 2) * GRID.cell
    z = (GRID.rows - 0.5 - np.arange(GRID.rows)) * GRID.cell
    length = np.hypot(x1 - x0, z1 - z0)
    past = ((x1 - x0) * (z[:, None] - z0) - (z1 - z0) * (x[None, :] - x0)) / length
    along = ((x1 - x0) * (x[None, :] - x0) + (z1 - z0) * (z[:, None] - z0)) / length
    over = (past >= 0) & (along >= 0) & (along <= length) & (past <= (truth.drop["across"] or np.inf))
    return (truth.kind == HIDDEN) | (over & (truth.kind == OUTSIDE))


def all_near(mask):
    """Cells whose eight neighbours are in the mask as well."""
    return ~geometry.wider(~mask)


def look_at_kind(frame):
    truth, floor = SceneTruth(frame, GRID, plain_counts=True), frame.floor  # of these kinds only `blank` has objects without texture
    known = floor["state"] in ("found", "held") and floor["pitch_rad"] is not None
    drop = np.isin(truth.kind, (DROP_OFF, BELOW)) | beyond_edge(truth)
    look = {"frame": str(frame.folder), "state": floor["state"],
            "pitch_error": abs(floor["pitch_rad"] - truth.pitch) / DEGREE if known else None,
            "height_error": 100 * abs(floor["height_m"] / truth.height - 1) if known else None}
    counts = frame.image("map") if frame.valid("map") else np.zeros((GRID.rows, GRID.columns), np.uint16)
    look["map"] = compare_found(counts >= 3, not frame.valid("map"), counts, truth, truth.occupied | drop)
    look["map"]["edge"] = look_at_edge(counts >= 3, truth)
    grid = occupancy(frame)
    if grid is not None:
        found, free = grid >= OCCUPIED, (grid >= 0) & (grid <= EMPTY)
        look["occupancy"] = compare_found(found, bool((grid < 0).all()), found * 3, truth, truth.in_the_way | drop)
        look["occupancy"]["edge"] = look_at_edge(found, truth)
        # One cell of tolerance: what is not free there, nor anywhere beside it.
        barred = all_near(np.isin(truth.kind, (OBSTACLE, DROP_OFF, HIDDEN, BELOW)))
        look["occupancy"]["free where it is not"] = int((free & barred).sum())
        open_ground = (truth.kind == FREE) & truth.ground
        look["occupancy"]["free of free"] = float((free & open_ground).sum() / max(open_ground.sum(), 1))
    return look


def row_of(kind, source, looks):
    """looks: (seed, frame, look)."""
    maps = [look[source] for _, _, look in looks]
    hits, must = recall(maps)
    edges = [m["edge"] for m in maps if m["edge"][0] >= 3]
    floors = [look for _, _, look in looks]
    return {"kind": kind, "from": source, "frames": len(maps), "floor found": mean(f["state"] == "found" for f in floors),
            "pitch error p50 [deg]": percentile([f["pitch_error"] for f in floors], 50),
            "p90": percentile([f["pitch_error"] for f in floors], 90),
            "height error p50 [%]": percentile([f["height_error"] for f in floors], 50),
            "to find": must, "found": hits / must if must else None, "false cells": sum(m["false"] for m in maps),
            "frames with false": sum(m["false"] > 0 for m in maps), "blind": sum(m["blind"] for m in maps),
            "drop-offs": len(edges), "found ": mean(2 * hit >= cells for cells, hit in edges),
            "edge found": mean(hit / cells for cells, hit in edges),
            "free where not": sum(m["free where it is not"] for m in maps) if source == "occupancy" else None,
            "free of free": mean(m["free of free"] for m in maps) if source == "occupancy" else None,
            "missed": [{"seed": s, "frame": i, **o} for s, i, l in looks for o in l[source]["objects"] if o["must"] and not o["hit"]],
            "false at": [{"seed": s, "frame": i, "cells": l[source]["false_cells"]} for s, i, l in looks if l[source]["false"]],
            "drop-offs missed": [{"seed": s, "frame": i} for s, i, l in looks
                                 if l[source]["edge"][0] >= 3 and 2 * l[source]["edge"][1] < l[source]["edge"][0]]}


COLUMNS = [("kind", ""), ("from", ""), ("frames", "d"), ("floor found", ".3f"), ("pitch error p50 [deg]", ".2f"), ("p90", ".2f"),
           ("height error p50 [%]", ".1f"), ("to find", "d"), ("found", ".4f"), ("false cells", "d"), ("frames with false", "d"),
           ("blind", "d"), ("drop-offs", "d"), ("found ", ".3f"), ("edge found", ".3f"), ("free where not", "d"), ("free of free", ".3f")]


def obstacle_section(daemon, section):
    seeds, rows = seeds_of(daemon), []
    for kind in chosen(daemon):
        _, frames, _ = KINDS[kind]
        runs = [(f"kinds/{kind}/{s}", parameters(daemon, kind, s), frames) for s in seeds]
        results = daemon.remembered(f"kinds-{kind}", runs, lambda: daemon.measure_all(f"kind {kind}", runs, look_at_kind))
        looks = [(seed, i, look) for seed, run in zip(seeds, results) for i, look in enumerate(run)]
        for source in ("map", "occupancy"):
            if source in looks[0][2]:
                rows.append(row_of(kind, source, looks))
                judge(section, rows[-1])
        section.command(daemon.command_line(parameters(daemon, kind, 1), frames))
    caption = "; ".join(f"{name}: {KINDS[name][2]}" for name in chosen(daemon))
    section.table(COLUMNS, rows, f"{len(seeds)} seeds of each kind. {caption}.")


def judge(section, row):
    """Gates are for the map that planners are meant to read; the count map is the paper's, and shown for comparison."""
    if row["from"] != "occupancy":
        return
    if row["to find"] and row["kind"] != "blank":  # most of what has no texture is not found: shown, not asked for
        section.gate(f"{row['kind']}: obstacles found within one cell", row["found"] >= 0.98, f"{100 * row['found']:.2f} %", ">= 98 %")
    if row["drop-offs"]:
        section.gate(f"{row['kind']}: drop-offs found", row["found "] >= 0.95, f"{100 * row['found ']:.1f} %", ">= 95 %")
    section.gate(f"{row['kind']}: no free cell where something is, or nothing can be seen", row["free where not"] == 0,
                 f"{row['free where not']} cells in {row['frames']} frames", "0")


def free_section(daemon, section):
    """Scene `empty` on the ground of each kind that has obstacles only because of its scene."""
    seeds, frames, rows = seeds_of(daemon), 4 if daemon.quick else 20, []
    for kind in chosen(daemon):
        if "sim.scene" in KINDS[kind][0] or kind in ("kerb", "ditch"):
            continue

        def look(frame):
            said = {"map": np.argwhere(frame.image("map") >= 3).tolist() if frame.valid("map") else []}
            grid = occupancy(frame)
            if grid is not None:
                said["occupancy"] = np.argwhere(grid >= OCCUPIED).tolist()
            return frame.json["sequence"], frame.floor["state"], said

        runs = [(f"kinds-free/{kind}/{s}", parameters(daemon, kind, s, **{"sim.scene": "empty"}), frames) for s in seeds]
        results = daemon.remembered(f"kinds-free-{kind}", runs, lambda: daemon.measure_all(f"kind {kind}, bare", runs, look))
        looks = [(seed, *l) for seed, run in zip(seeds, results) for l in run]
        for source in ("map", "occupancy"):
            if source not in looks[0][3]:
                continue
            wrong = [{"seed": s, "frame": n, "cells": said[source]} for s, n, _, said in looks if said[source]]
            cells = sum(len(w["cells"]) for w in wrong)
            rows.append({"kind": kind, "from": source, "frames": len(looks), "floor found": mean(state == "found" for _, _, state, _ in looks),
                         "false cells": cells, "frames with false": len(wrong), "wrong": wrong[:50]})
            if source == "occupancy":
                section.gate(f"{kind}: false obstacle cells on bare ground", 1000 * cells <= len(looks), f"{cells} in {len(looks)} frames",
                             "at most 1 in 1000 frames")
    section.table([("kind", ""), ("from", ""), ("frames", "d"), ("floor found", ".3f"), ("false cells", "d"), ("frames with false", "d")],
                  rows, "The same kinds of ground and camera without obstacles (scene `empty`).")


def blind_section(daemon, section):
    seeds, begin, frames, rows = seeds_of(daemon), 4, 10, []
    cases = {event: {"sim.scene": "flat", "sim.event": event, "sim.eventFrame": begin} for event in ("cap", "dark", "bright", "blank")}
    cases["wall"] = {"sim.scene": "wall"}
    for name, sets in cases.items():

        def look(frame):
            grid = occupancy(frame)
            counts = int((frame.image("map") >= 3).sum()) if frame.valid("map") else 0
            free = int(((grid >= 0) & (grid <= EMPTY)).sum()) if grid is not None else None
            return frame.floor["state"], frame.valid("map"), counts, free

        runs = [(f"kinds-blind/{name}/{s}", {**PAPER, **sets, "sim.seed": s, **daemon.sets}, frames) for s in seeds]
        results = daemon.measure_all(f"blind, {name}", runs, look)
        first = begin if "sim.event" in sets else 0
        late = [next((n for n, l in enumerate(run[first:]) if l[0] == "lost"), frames) for run in results]
        after = [l for run in results for l in run[first:]]
        lost = [l for l in after if l[0] == "lost"]
        rows.append({"event": name, "runs": len(results), "frames": len(after), "lost": mean(l[0] == "lost" for l in after),
                     "frames until lost, most": max(late), "maps not blind": sum(l[1] for l in lost),
                     "obstacle cells": sum(l[2] for l in after), "free cells": sum(l[3] or 0 for l in lost)})
        if name != "wall":  # the floor before it is seen
            section.gate(f"{name}: lost within 2 frames, and no free cell then", max(late) <= 2 and rows[-1]["free cells"] == 0,
                         f"{max(late)} frames, {rows[-1]['free cells']} free cells", "2 frames, 0 cells")
        section.command(daemon.command_line({**PAPER, **sets, "sim.seed": 1}, frames))
    columns = [("event", ""), ("runs", "d"), ("frames", "d"), ("lost", ".3f"), ("frames until lost, most", "d"), ("maps not blind", "d")]
    section.table(columns + [("obstacle cells", "d"), ("free cells", "d")], rows,
                  f"Frames from the event on (frame {begin} of {frames}; `wall` is there from the start, and the floor before it is seen).")
