# recorded.py: sections on real pairs: floors, the lidar's map, and equal dumps of equal runs.
# SPDX-License-Identifier: Apache-2.0
import filecmp
import math
import shutil

import cv2
import numpy as np

import evaluation.geometry as geometry
from evaluation.daemon import Skipped
from evaluation.simulated import AUTO, DEGREE, MATCHERS, mean, percentile

# The floor line's angle is atan(H / (16 B cos pitch)); an operator who knows the mounting allows 30 % to each side.
FLOOR_SETS = {
    "rover_minnie/rectified": {"height": 1.67, "pitch": 35.3, "baseline": 0.27030, "ndisp": 64,
                               "left": "left/%06d.png", "right": "right/%06d.png", "paramfile": "calibration.yml"},
    "rover_minnie/raw": {"height": 1.67, "pitch": 35.3, "baseline": 0.27028, "ndisp": 192,
                         "left": "left/%06d.png", "right": "right/%06d.png", "paramfile": "calibration_opencv.yml"},
    "robot_indoor": {"height": 0.28, "pitch": -1.0, "baseline": 0.092226, "ndisp": 80,
                     "left": "robotL.mp4", "right": "robotR.mp4", "paramfile": "calibration.yml"},
    "kitti_street": {"height": 1.65, "pitch": 0.0, "baseline": 0.53715, "ndisp": 96,
                     "left": "left/%06d.png", "right": "right/%06d.png", "paramfile": "calibration.yml"},
    # No calibration; its camera stands 3.5 baselines high. Rectification left black borders.
    "office": {"height": 3.5, "pitch": 0.0, "baseline": 1.0, "ndisp": 128, "valid": (64, 657, 128, 1155),
               "left": "*/left.png", "right": "*/right.png"},
}


def pattern(folder, name):
    """A set's images as they are called there: the first name or glob of the kind that exists."""
    if "*" in name or name.endswith(".mp4") or list(folder.glob(name.replace("%06d", "[0-9]*"))):
        return str(folder / name)
    side = folder / name.split("/")[0]
    kinds = sorted({p.suffix for p in side.iterdir()}) if side.is_dir() else []
    if not kinds:
        raise Skipped(f"no images {folder / name}")
    return str(side / f"*{kinds[0]}")


def source(daemon, name, parts):
    folder = daemon.set_folder(*name.split("/"))
    sets = {"image source.source": "files", "image source.left": pattern(folder, parts["left"]),
            "image source.right": pattern(folder, parts["right"]), "image source.ndisp": parts["ndisp"]}
    if "paramfile" in parts:
        sets["image source.paramfile"] = str(folder / parts["paramfile"])
    return sets


def tuned_angles(parts):
    angle = math.atan(parts["height"] / (16 * parts["baseline"] * math.cos(parts["pitch"] * DEGREE)))
    return {"Floor.anglefloorMin": round(0.7 * angle, 4), "Floor.anglefloorMax": round(min(1.3 * angle, 1.55), 4)}


def floor_variants(parts):
    """The paper's line with its own angles and with tuned ones; and the default model with what an operator measures with a tape."""
    line = {"Floor.model": "line"}
    return (("line", line), ("line, tuned", {**line, **tuned_angles(parts)}),
            ("profile", {"mounting.height": parts["height"], "mounting.pitch": round(parts["pitch"] * DEGREE, 3)}))


def lower_third(parts, corrsize=11):
    """Measures the share of pixels with a disparity in the lower third of what can be matched."""
    def look(frame):
        disparity = frame.image("disparity")
        if disparity is None:
            return None
        region = geometry.matchable(parts["ndisp"], corrsize, disparity.shape)
        top, bottom, left, right = parts.get("valid", (0, disparity.shape[0], 0, disparity.shape[1]))
        region[: top + (bottom - top) * 2 // 3] = region[bottom:] = False
        region[:, : left + parts["ndisp"]] = region[:, right:] = False
        return float((disparity[region] > 0).mean())
    return look


def floor_section(daemon, section):
    rows = []
    for name, parts in FLOOR_SETS.items():
        try:
            base = source(daemon, name, parts)
        except Skipped as why:
            section.note(f"{name} skipped: {why}")
            continue
        density = lower_third(parts)
        variants = [(m, word, {**base, "image source.matcher": m, **angles})
                    for m in MATCHERS for word, angles in floor_variants(parts)]
        frames = 30 if daemon.quick else None
        runs = [(f"floor-{name.replace('/', '-')}/{m}-{word.replace(', ', '-')}", sets, frames) for m, word, sets in variants]
        results = daemon.measure_all(name, runs, lambda frame: (frame.floor, density(frame)))
        for (matcher, word, sets), looks in zip(variants, results):
            found = [f for f, _ in looks if f["state"] == "found"]
            heights = [f["height_m"] for f in found]
            pitches = [f["pitch_rad"] / DEGREE for f in found if f["pitch_rad"] is not None]
            rows.append({"set": name, "matcher": matcher, "floor": word, "ndisp": parts["ndisp"], "frames": len(looks),
                         "found": len(found) / len(looks),
                         **{f"height p{p} [m]": percentile(heights, p) for p in (10, 50, 90)},
                         **{f"pitch p{p} [deg]": percentile(pitches, p) for p in (10, 50, 90)},
                         "density": mean(d for _, d in looks if d is not None),
                         "confidence": mean(f["confidence"] for f in found), "command": daemon.command_line(sets)})
        if name == "rover_minnie/rectified":
            minnie_gate(section, results, variants)
        section.command(daemon.command_line({**base, "image source.matcher": "MATCHER", **floor_variants(parts)[2][1]}))
    if not rows:
        raise Skipped("none of the sets is there")
    columns = [("set", ""), ("matcher", ""), ("floor", ""), ("ndisp", "d"), ("frames", "d"), ("found", ".2f")]
    columns += [(f"height p{p} [m]", ".3f") for p in (10, 50, 90)] + [(f"pitch p{p} [deg]", ".2f") for p in (10, 50, 90)]
    section.table(columns + [("density", ".3f"), ("confidence", ".2f")], rows,
                  "True: rover_minnie 1.67 m, 35.3 deg; robot_indoor 0.28 m, about -1 deg; kitti_street 1.65 m, about 0 deg; "
                  "office: no calibration. Density: share of pixels with a disparity in the lower third of what can be "
                  "matched.")


def minnie_gate(section, results, variants):
    """The gate stands for the default model; the other variants are in the table."""
    for (matcher, word, _), looks in zip(variants, results):
        if (matcher, word) != ("bm", "profile"):
            continue
        poses = [(f["height_m"], f["pitch_rad"] / DEGREE) if f["state"] == "found" else (math.inf, math.inf) for f, _ in looks]
        good = [abs(h / 1.67 - 1) <= 0.02 and abs(p - 35.3) <= 1 for h, p in poses]
        section.gate("rover_minnie/rectified: height 1.67 m within 2 %, pitch 35.3 deg within 1 deg", all(good),
                     ", ".join(f"{h:.3f} m {p:.2f} deg" for h, p in poses), "each frame")


LIDAR_GRID = geometry.Grid(20, 16, 0.5)
LIDAR = {**AUTO, "Map.range": 20, "Map.width": 16, "Map.cell": 0.5, "Limit obstacle.max_height": 0.4, "image source.ndisp": 128}


def lidar_truth(depth, camera, ndisp, corrsize=11):
    """Masks of the grid: obstacle, observed; and the plane's pitch [deg] and height [m].

    Depths beside a jump of more than 5 % are left out: densified lidar is not to be trusted there. Obstacle: 10 pixels from 0.4
    to 2.2 m above the plane. Observed: 10 pixels up to 2.2 m. Only what stereo can match counts."""
    seen = depth > 0
    low, high = cv2.erode(np.where(seen, depth, 1e3).astype(np.float32), np.ones((3, 3))), cv2.dilate(depth, np.ones((3, 3)))
    seen &= (high < 1.05 * low) & (depth < 40)
    points = np.stack(geometry.camera_points(camera, depth), axis=-1)
    ground = points[seen & (np.arange(depth.shape[0])[:, None] > camera["cy"] + 20) & (depth < 25)]
    # The camera of all KITTI drives stands 1.65 m high.
    normal, distance = geometry.fit_plane(ground, 0.08, (1.5, 1.8), 4 * DEGREE)
    pitch, roll = geometry.pose_of_plane(normal)
    above = distance - points @ normal
    usable = seen & geometry.matchable(ndisp, corrsize, depth.shape)
    usable &= camera["f"] * camera["baseline"] / np.where(seen, depth, 1) <= ndisp - 1
    x, _, z = geometry.level(tuple(np.moveaxis(points, -1, 0)), pitch, roll)
    tall = usable & (above > 0.4) & (above < 2.2)
    flat = usable & (above < 2.2)
    return (LIDAR_GRID.counts(x[tall], z[tall]) >= 10, LIDAR_GRID.counts(x[flat], z[flat]) >= 10, pitch / DEGREE, distance)


def lidar_section(daemon, section):
    folder = daemon.set_folder("kitti_lidar")
    # Tuned: atan(1.65 / (16 * 0.5327)) = 0.191, 30 % to each side.
    variants = floor_variants({"height": 1.65, "baseline": 0.53272, "pitch": 0.0})
    rows = []
    for matcher in MATCHERS:
        for word, more in variants:
            total = dict.fromkeys(COUNTS, 0)
            for place in sorted(p for p in folder.iterdir() if p.is_dir()):
                row = daemon.measure(f"lidar/{matcher}-{word.replace(', ', '-')}-{place.name}", lidar_sets(place, matcher, more), 1,
                                     lambda frame: lidar_row(frame, place))[0]
                rows.append({"matcher": matcher, "floor": word, "pair": place.name, **row})
                for key in total:
                    total[key] += row[key]
            rows.append({"matcher": matcher, "floor": word, "pair": "pooled", **shares(total), **total})
    columns = [("matcher", ""), ("floor", ""), ("pair", ""), ("found", ""), ("pitch off [deg]", ".2f"), ("height [m]", ".3f")]
    columns += [("lidar height [m]", ".3f"), ("obstacle cells", "d"), ("of lidar", "d"), ("precision", ".3f")]
    section.table(columns + [("by chance", ".3f"), ("recall", ".3f"), ("F1", ".3f"), ("same cell precision", ".3f"),
                              ("recall ", ".3f")], rows,
                  "Map of 20 m x 16 m, cells of 0.5 m, against the lidar's; one cell of tolerance; cells the lidar did not "
                  "see are left out. Pitch off: floor found minus the lidar's plane. By chance: the precision of a map that "
                  "is all obstacle. The last two: without tolerance.")
    section.command(daemon.command_line(lidar_sets(folder / "PAIR", "MATCHER", variants[2][1]), 1))


def lidar_sets(place, matcher, more):
    return {"image source.source": "files", "image source.left": place / "left.png", "image source.right": place / "right.png",
            "image source.paramfile": place / "calibration.yml", "image source.matcher": matcher, **LIDAR, **more}


COUNTS = ("hit", "wrong", "met", "true", "exact", "seen", "near", "found seen")


def shares(counts):
    def share(part, whole):
        return counts[part] / counts[whole] if counts[whole] else None

    judged = {**counts, "judged": counts["hit"] + counts["wrong"]}
    precision, recall = judged["hit"] / judged["judged"] if judged["judged"] else None, share("met", "true")
    both = 2 * precision * recall / (precision + recall) if precision and recall else None
    return {"precision": precision, "recall": recall, "F1": both, "by chance": share("near", "seen"),
            "obstacle cells": judged["judged"], "of lidar": counts["true"],
            "same cell precision": share("exact", "found seen"), "recall ": share("exact", "true")}


def calibration_of(path):
    """f, cx, cy and baseline from P1 and P2 of an OpenCV file."""
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    left, right = file.getNode("P1").mat(), file.getNode("P2").mat()
    return {"f": left[0][0], "cx": left[0][2], "cy": left[1][2], "baseline": -right[0][3] / right[0][0]}


def compare_cells(found, truth, observed, right=None):
    """Numbers of cells, for shares(). `right`: where a found cell is right, if that is more than the cells to be found."""
    near_truth, near_found = geometry.wider(truth if right is None else right), geometry.wider(found)
    masks = {"hit": found & near_truth, "wrong": found & observed & ~near_truth, "met": truth & near_found, "true": truth,
             "exact": found & truth, "seen": observed, "near": observed & near_truth, "found seen": found & observed}
    return {key: int(mask.sum()) for key, mask in masks.items()}


def lidar_row(frame, place):
    depth = cv2.imread(str(place / "depth_m_x256.png"), cv2.IMREAD_UNCHANGED).astype(np.float32) / 256
    truth, observed, pitch, height = lidar_truth(depth, calibration_of(place / "calibration.yml"), LIDAR["image source.ndisp"])
    found = frame.image("map") >= 3 if frame.valid("map") else np.zeros(truth.shape, bool)
    counts = compare_cells(found, truth, observed)
    floor = frame.floor
    return {**counts, **shares(counts), "found": "yes" if frame.valid("map") else frame.json["stages"]["map"]["reason"],
            "pitch off [deg]": floor["pitch_rad"] / DEGREE - pitch if floor["pitch_rad"] is not None else None,
            "height [m]": floor["height_m"], "lidar height [m]": float(height)}


def differences(a, b):
    """Files that differ between two dumps, timing.json apart."""
    names = sorted({p.relative_to(f) for f in (a, b) for p in f.rglob("*") if p.is_file() and p.name != "timing.json"})

    def same(name):
        return (a / name).is_file() and (b / name).is_file() and filecmp.cmp(a / name, b / name, shallow=False)

    return names, [str(name) for name in names if not same(name)]


def determinism_section(daemon, section):
    rows = []
    for name, frames in (("robot_indoor", 12), ("kitti_street", 6), ("rover_minnie/raw", 2)):
        try:
            base = source(daemon, name, FLOOR_SETS[name])
        except Skipped as why:
            section.note(f"{name} skipped: {why}")
            continue
        label = name.replace("/", "-")
        for matcher in MATCHERS:
            sets = {**base, "image source.matcher": matcher}
            dumps = [daemon.dump(f"equal/{label}-{matcher}-{i}", {**sets, **more}, frames)[0]
                     for i, more in enumerate(({}, {}, {"main.threads": 2}))]
            for word, other in (("the same", dumps[1]), ("main.threads = 2", dumps[2])):
                names, different = differences(dumps[0], other)
                rows.append({"set": name, "matcher": matcher, "second run": word, "frames": frames, "files": len(names),
                             "different": len(different), "names": different[:20]})
            if not daemon.keep:
                for dump in dumps:
                    shutil.rmtree(dump, ignore_errors=True)
            section.command(daemon.command_line(sets, frames))
    if not rows:
        raise Skipped("none of the sets is there")
    wrong = [r for r in rows if r["different"] or not r["files"]]
    section.gate("two runs of the files source give equal dumps, timing.json apart", not wrong,
                 f"{sum(r['different'] for r in rows)} of {sum(r['files'] for r in rows)} files differ"
                 + (f", first: {wrong[0]['names'][:1]}" if wrong else ""), "0")
    section.table([("set", ""), ("matcher", ""), ("second run", ""), ("frames", "d"), ("files", "d"), ("different", "d")], rows)
