# panes.py: section panes: what a pane of glass or a mirror that fills the view makes of the map.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np

from evaluation import kinds
from evaluation.daemon import Frame
from evaluation.simulated import DEGREE, GRID, mean
from evaluation.truth import SceneTruth, compare_found

# Of the light that reaches the camera, what the pane reflects: none; clear glass seen straight on; at a slant; coated; a half mirror; a mirror.
REFLECTS = (0, 0.08, 0.2, 0.35, 0.5, 0.8, 1)
CALIBRATION = """%YAML:1.0
---
image_width: {width}
image_height: {height}
P1: !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [ {f}, 0., {cx}, 0., 0., {f}, {cy}, 0., 0., 0., 1., 0. ]
P2: !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [ {f}, 0., {cx}, {tx}, 0., {f}, {cy}, 0., 0., 0., 1., 0. ]
"""


def scene(daemon, seed):
    """The first frame of a flat scene: its views, and its truth."""
    _, places = daemon.dump(f"panes/scene-{seed}", kinds.parameters(daemon, "flat", seed), 1)
    return Frame(places[0])


def compose(folder, through, reflected, part):
    """Both views of a pair, as the light adds up. What a mirror shows is a world too, and stands as far behind the mirror as it is before it:
    any scene seen from the same height and pitch can be that world."""
    folder.mkdir(parents=True, exist_ok=True)
    for side in ("left", "right"):
        light = (1 - part) * through.image(side).astype(float) + part * reflected.image(side).astype(float)
        cv2.imwrite(str(folder / f"{side}.png"), np.clip(np.rint(light), 0, 255).astype(np.uint8))
    camera, (height, width) = through.camera("left"), through.image("left").shape
    values = {**camera, "width": width, "height": height, "tx": -camera["f"] * camera["baseline"]}
    (folder / "calibration.yml").write_text(CALIBRATION.format(**values))
    return {"image source.source": "files", "image source.left": folder / "left.png", "image source.right": folder / "right.png",
            "image source.paramfile": folder / "calibration.yml", "image source.ndisp": 48, **kinds.MEASURED}


def section(daemon, section):
    seeds, rows = range(1, 4 if daemon.quick else 13), []
    scenes = {seed: scene(daemon, seed) for seed in [*seeds, *(seed + kinds.SEEDS for seed in seeds)]}
    truths = {seed: SceneTruth(frame, GRID) for seed, frame in scenes.items()}
    for part in REFLECTS:
        looks = []
        for seed in seeds:
            through, reflected = truths[seed], truths[seed + kinds.SEEDS]
            folder = (daemon.keep or daemon.work) / "panes" / f"{part:g}-{seed}"
            sets = compose(folder / "views", scenes[seed], scenes[seed + kinds.SEEDS], part)

            def look(frame):
                grid = kinds.occupancy(frame)
                found, blind = grid >= kinds.OCCUPIED, bool((grid < 0).all())
                behind, mirrored = (compare_found(found, blind, found * 3, truth, truth.in_the_way) for truth in (through, reflected))
                pitch = frame.floor["pitch_rad"]
                return {"state": frame.floor["state"], "pitch": abs(pitch - through.pitch) / DEGREE if pitch is not None else None,
                        "behind": behind, "mirrored": mirrored, "free": int(((grid >= 0) & (grid <= kinds.EMPTY)).sum()),
                        "obstacle": int(found.sum())}

            looks += daemon.measure(f"panes/{part:g}-{seed}/dump", sets, 1, look)

        def found(which):
            objects = [o for look in looks for o in look[which]["objects"] if o["must"]]
            return mean(o["hit"] for o in objects)

        rows.append({"reflected": part, "pairs": len(looks), "floor found": mean(look["state"] == "found" for look in looks),
                     "pitch error [deg]": mean(look["pitch"] for look in looks if look["pitch"] is not None), "behind it: found": found("behind"),
                     "mirrored: found": found("mirrored"), "free cells": mean(look["free"] for look in looks),
                     "obstacle cells": mean(look["obstacle"] for look in looks)})
        daemon.say(f"panes: {part:g} reflected")
    columns = [("reflected", "g"), ("pairs", "d"), ("floor found", ".2f"), ("pitch error [deg]", ".2f"), ("behind it: found", ".3f"),
               ("mirrored: found", ".3f"), ("free cells", ".0f"), ("obstacle cells", ".0f")]
    section.table(columns, rows, "A pane across all of the view, of two simulated scenes: one behind it, one mirrored in it, added up by the part of the "
                  "light that it reflects. Free cells: of the whole map; those behind the pane, wherever it is, should not be. The command makes one such "
                  "scene, before they are added up.")
    section.command(daemon.command_line(kinds.parameters(daemon, "flat", 1), 1))
