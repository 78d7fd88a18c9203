# quality.py: the quality table beside the times: our matchers and OpenCV's on the same rectified views, against truth.
# SPDX-License-Identifier: Apache-2.0
import math
import pathlib
import subprocess
import sys
import time

import cv2
import numpy as np

import evaluation.geometry as geometry
from evaluation import peers, pictures
from evaluation.daemon import Daemon, RunFailed, Skipped
from evaluation.recorded import FLOOR_SETS, source
from evaluation.report import Section, write_json
from evaluation.simulated import DEGREE, PAPER
from evaluation.truth import GROUND, SKY, UNLISTED

WINDOW = 11
# Settings equal to the peers': StereoBM's texture threshold of 10 is a sum over the window, of which thresh = 1 is 60; StereoSGBM has
# none. `as it is` has all defaults, so thresh = 10, which is a sum of 605 and rejects more.
EQUAL = {"image source.matcher": "bm", "image source.align": "none", "image source.thresh": 1}
OURS = {
    "bm": EQUAL,
    "bm, align floor": {**EQUAL, "image source.align": "floor"},
    "census": {**EQUAL, "image source.matcher": "census"},
    "sgm": {"image source.matcher": "sgm", "image source.thresh": 0},
    "as it is": {},
    "sgm, as it is": {"image source.matcher": "sgm"},
}
MIDDLEBURY = {"cones": 64, "venus": 32, "aloe": 224, "Cloth3": 96}


def known_matchers(program, section):
    """Those of OURS that this daemon has."""
    known = {}
    for name, sets in OURS.items():
        words = [str(program), "-c", "/dev/null", "--check-config"] + [w for k, v in sets.items() for w in ("--set", f"{k}={v}")]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode == 0:
            known[name] = sets
        else:
            section.note(f"{name} skipped: {done.stderr.strip().splitlines()[-1].split(', nearest')[0]}")
    return known


class Pair:
    """Truth of one left view: disparity in px, where it is known and can be matched, what hides nothing, what is an obstacle."""

    def __init__(self, truth, known, ndisp, share=0.0, obstacle=None):
        self.truth, self.share = truth, share
        self.region = known & geometry.matchable(ndisp, WINDOW, truth.shape) & (truth <= ndisp - 1)
        self.seen = ~hidden(truth)
        self.obstacle = obstacle


def hidden(truth):
    """Pixels that the right camera does not see: left of its view, or behind what lies more than 1 px nearer. From the left truth alone."""
    height, width = truth.shape
    v, u = np.mgrid[0:height, 0:width]
    to = u - truth
    nearest = np.zeros((height, width))
    inside = (truth > 0) & (to >= 0)
    for side in (0, 1):  # a pixel covers both columns it falls between, so that slanted surfaces leave no holes
        column = np.clip(np.floor(to).astype(int) + side, 0, width - 1)
        np.maximum.at(nearest, (v[inside], column[inside]), truth[inside])
    column = np.clip(np.rint(to).astype(int), 0, width - 1)
    return (truth > 0) & ((np.rint(to) < 0) | (nearest[v, column] > truth + 1))


class Count:
    """Pixels with truth, with a value, and wrong by more than 1 and 2 px, over any number of pairs."""

    def __init__(self):
        self.all = self.found = self.wrong1 = self.wrong2 = 0

    def add(self, disparity, pair, where):
        where = where & pair.region
        found = where & (disparity > 0)
        error = np.abs(disparity / 16.0 - pair.truth)
        self.all += np.count_nonzero(where)
        self.found += np.count_nonzero(found)
        self.wrong1 += np.count_nonzero(found & (error > np.maximum(1, pair.share * pair.truth)))
        self.wrong2 += np.count_nonzero(found & (error > np.maximum(2, pair.share * pair.truth)))

    @property
    def density(self):
        return 100 * self.found / max(self.all, 1)

    @property
    def bad1(self):
        return 100 * self.wrong1 / max(self.found, 1)

    @property
    def bad2(self):
        return 100 * self.wrong2 / max(self.found, 1)


def middlebury_pairs(daemon, name):
    truth = cv2.imread(str(daemon.set_folder("middlebury", name) / "disparity_x256.png"), cv2.IMREAD_UNCHANGED) / 256.0
    return [Pair(truth, truth > 0, MIDDLEBURY[name])]


def middlebury_runs(daemon, name):
    folder = daemon.set_folder("middlebury", name)
    return [({"image source.source": "files", "image source.left": folder / "left.png", "image source.right": folder / "right.png",
              "image source.ndisp": MIDDLEBURY[name]}, 1, 1)]


def lidar_folders(daemon):
    return sorted(p for p in daemon.set_folder("kitti_lidar").iterdir() if p.is_dir())


def lidar_pair(folder):
    """Densified lidar, trusted to 5 %: wrong is what is off by more than that as well. Beside depth jumps of more than 5 % it is not
    used. Obstacle: 0.4 to 2.2 m above a plane fitted to the lidar's own points."""
    calibration = cv2.FileStorage(str(folder / "calibration.yml"), cv2.FILE_STORAGE_READ)
    p1, p2 = (calibration.getNode(n).mat() for n in ("P1", "P2"))
    camera = {"f": p1[0, 0], "cx": p1[0, 2], "cy": p1[1, 2]}
    depth = cv2.imread(str(folder / "depth_m_x256.png"), cv2.IMREAD_UNCHANGED) / 256.0
    seen = depth > 0
    low, high = cv2.erode(np.where(seen, depth, 1e3).astype(np.float32), np.ones((3, 3))), cv2.dilate(depth, np.ones((3, 3)))
    known = seen & (high < 1.05 * low)
    truth = np.where(seen, -p2[0, 3] / np.where(seen, depth, 1) + p1[0, 2] - p2[0, 2], 0)
    points = np.stack(geometry.camera_points(camera, depth), axis=-1)
    ground = points[known & (np.arange(depth.shape[0])[:, None] > camera["cy"] + 20) & (depth < 25)]
    normal, distance = geometry.fit_plane(ground, 0.08, (1.5, 1.8), 4 * DEGREE)
    above = distance - points @ normal
    return Pair(truth, known, 128, 0.05, (above > 0.4) & (above < 2.2))


def lidar_runs(daemon):
    # Three times the same frame: floor alignment starts from the mounting, then knows the last floor.
    return [({"image source.source": "files", "image source.left": f / "left.png", "image source.right": f / "right.png",
              "image source.paramfile": f / "calibration.yml", "image source.ndisp": 128, "image source.loop": "yes",
              "mounting.height": 1.65, "mounting.pitch": 0, "Limit obstacle.angRot": "auto", "Map.angRot": "auto"}, 3, 1)
            for f in lidar_folders(daemon)]


def simulated_runs(daemon):
    sets = {**PAPER, "sim.scene": "flat", "mounting.height": 0.8}
    return [({**sets, "sim.seed": seed}, 3, 2) for seed in range(1, 4 if daemon.quick else 13)]


def simulated_pair(frame):
    truth, number = frame.image("truth/disparity") / 16.0, frame.image("truth/object")
    pair = Pair(truth, truth > 0, 48, 0.0, (number != GROUND) & (number != SKY) & (number != UNLISTED))
    pair.ground = number == GROUND
    return pair


class Views:
    """All that was matched of one set: pairs, and for each matcher a disparity (1/16 px, 0 none) per pair."""

    def __init__(self, name, ndisp):
        self.name, self.ndisp, self.pairs, self.left, self.results = name, ndisp, [], [], {}


def match_set(daemon, known, name, ndisp, runs, pairs=None):
    """Runs ours with --dump and the peers on the views that the first of them dumped. Of each run the last frames count."""
    views = Views(name, ndisp)
    for matcher, sets in known.items():
        jobs = [(f"quality-{name}-{matcher}/{i}".replace(" ", "").replace(",", "-"), {**run, **sets}, frames)
                for i, (run, frames, _) in enumerate(runs)]
        keep = matcher == next(iter(known))

        def look(frame):
            if not keep:
                return frame.image("disparity"), None, None, None
            pair = simulated_pair(frame) if pairs is None else None
            return frame.image("disparity"), frame.image("left"), frame.image("right"), pair

        try:
            looks = daemon.measure_all(f"{name}, {matcher}", jobs, look)
        except RunFailed as failure:
            raise Skipped(str(failure))
        last = [look for (_, _, count), run in zip(runs, looks) for look in run[-count:]]
        views.results[matcher] = [disparity for disparity, _, _, _ in last]
        if keep:
            views.left = [left for _, left, _, _ in last]
            rights = [right for _, _, right, _ in last]
            views.pairs = [pair for _, _, _, pair in last] if pairs is None else pairs
    for peer in peers.PEERS:
        views.results[peer] = [peers.match(peer, left, right, ndisp) for left, right in zip(views.left, rights)]
    return views


def rows_of(views):
    rows = []
    for matcher, disparities in views.results.items():
        everywhere, seen, obstacles = Count(), Count(), Count()
        for disparity, pair in zip(disparities, views.pairs):
            everywhere.add(disparity, pair, True)
            seen.add(disparity, pair, pair.seen)
            if pair.obstacle is not None:
                obstacles.add(disparity, pair, pair.obstacle)
        rows.append({"set": views.name, "matcher": matcher, "ndisp": views.ndisp, "pairs": len(disparities),
                     "density": everywhere.density, "bad-1": everywhere.bad1, "bad-2": everywhere.bad2,
                     "seen density": seen.density, "seen bad-1": seen.bad1, "seen bad-2": seen.bad2,
                     "obstacles density": obstacles.density if obstacles.all else None,
                     "obstacles bad-2": obstacles.bad2 if obstacles.all else None})
    return rows


def gate(section, what, checks):
    """checks: (what is measured, found, limit, +1 where it may not be above, -1 not below)."""
    wrong = [(word, found, limit) for word, found, limit, sign in checks if sign * (found - limit) > 1e-9]
    text = "; ".join(f"{word} {found:.2f}, limit {limit:.2f}" for word, found, limit in wrong) or "; ".join(
        f"{word} {found:.2f} (limit {limit:.2f})" for word, found, limit, _ in checks)
    section.gate(what, not wrong, text, "all")


def mean_rows(rows):
    """Of what every set has, the mean over the sets, each with the same weight: what one set trades in density for errors, another may
    trade the other way."""
    sets = list(dict.fromkeys(row["set"] for row in rows))
    means = []
    for matcher in dict.fromkeys(row["matcher"] for row in rows):
        of = [row for row in rows if row["matcher"] == matcher]
        if len(of) == len(sets) > 1:
            means.append({"set": "mean", "matcher": matcher, "pairs": sum(row["pairs"] for row in of),
                          **{k: float(np.mean([row[k] for row in of])) for k in ("density", "bad-1", "bad-2", "seen density", "seen bad-1", "seen bad-2")},
                          **dict.fromkeys(("ndisp", "obstacles density", "obstacles bad-2"))})
    return means


def matching_gates(section, rows):
    """Block matching against StereoBM, sgm against MODE_HH, floor-aligned against not, all at equal settings."""
    of = {(row["set"], row["matcher"]): row for row in rows}
    for name in dict.fromkeys(row["set"] for row in rows):
        ours, peer = of.get((name, "bm")), of[(name, "StereoBM")]
        if ours:
            gate(section, f"{name}: bm: density at most 1 point below StereoBM's, bad-1 and bad-2 at most 0.2 above",
                 [("density", ours["density"], peer["density"] - 1, -1)]
                 + [(k, ours[k], peer[k] + 0.2, 1) for k in ("bad-1", "bad-2")])
        ours, peer = of.get((name, "sgm")), of[(name, "StereoSGBM HH")]
        if ours:
            gate(section, f"{name}: sgm: bad-2 not above StereoSGBM's (HH), density not below",
                 [("density", ours["density"], peer["density"], -1), ("bad-2", ours["bad-2"], peer["bad-2"], 1)])
        plain, aligned = of.get((name, "bm")), of.get((name, "bm, align floor"))
        if plain and aligned and plain["obstacles bad-2"] is not None:
            gate(section, f"{name}: floor alignment costs nothing on obstacles: bad-2 (0.05 points allowed for rounding)",
                 [("bad-2", aligned["obstacles bad-2"], plain["obstacles bad-2"] + 0.05, 1)])


def matching_section(daemon, options, section):
    known = known_matchers(daemon.binary, section)
    wanted = [n for n in [*MIDDLEBURY, "kitti_lidar", "simulator"] if not options.only or n in options.only]
    all_views, rows = {}, []
    for name in wanted:
        # Nothing in these pictures is a floor.
        ours = {m: s for m, s in known.items() if m != "bm, align floor"} if name in MIDDLEBURY else known
        try:
            if name in MIDDLEBURY:
                views = match_set(daemon, ours, name, MIDDLEBURY[name], middlebury_runs(daemon, name), middlebury_pairs(daemon, name))
            elif name == "kitti_lidar":
                views = match_set(daemon, ours, name, 128, lidar_runs(daemon), [lidar_pair(f) for f in lidar_folders(daemon)])
            else:
                views = match_set(daemon, ours, name, 48, simulated_runs(daemon))
        except Skipped as why:
            section.note(f"{name} skipped: {why}")
            continue
        all_views[name] = views
        rows += rows_of(views)
        if options.pictures:
            pictures.write(pathlib.Path(options.pictures), views)
    if not rows:
        raise Skipped("none of the sets is there")
    rows += mean_rows(rows)
    matching_gates(section, rows)
    section.table([("set", ""), ("matcher", ""), ("ndisp", "d"), ("pairs", "d"), ("density", ".2f"), ("bad-1", ".2f"), ("bad-2", ".2f"),
                   ("seen density", ".2f"), ("seen bad-1", ".2f"), ("seen bad-2", ".2f"), ("obstacles density", ".2f"),
                   ("obstacles bad-2", ".2f")], rows,
                  "Density: share [%] of the pixels with truth, matchable by all (columns ndisp - 1 + half a window to the right border "
                  "less half a window, rows less half a window, disparity at most ndisp - 1), that have a disparity above 0. Bad-k: "
                  "share [%] of those that is off by more than k px; on kitti_lidar also by more than 5 %, and not beside depth jumps "
                  "of more than 5 %. Seen: what is not hidden from the right camera. Obstacles: kitti_lidar 0.4 to 2.2 m above a plane "
                  "fitted to the lidar; simulator: the scene's objects.")
    return all_views


def locking_section(views, section):
    """The floor's disparity takes all fractions of a pixel alike; what a matcher finds should too."""
    rows = []
    for matcher, disparities in views.results.items():
        found, true, error = np.zeros(16), np.zeros(16), np.zeros(16)
        for disparity, pair in zip(disparities, views.pairs):
            sixteenths = np.rint(16 * pair.truth).astype(int)
            right = pair.region & pair.ground & (disparity > 0) & (np.abs(disparity - 16 * pair.truth) < 16)
            found += np.bincount(disparity[right] & 15, minlength=16)
            true += np.bincount(sixteenths[right] & 15, minlength=16)
            error += np.bincount(sixteenths[right] & 15, weights=disparity[right] / 16.0 - pair.truth[right], minlength=16)
        if true.min() == 0:
            continue
        bias, share = error / true, found / true
        rows.append({"matcher": matcher, "pixels": int(true.sum()), "least": share.min(), "most": share.max(), "uneven": share.std(),
                     "mean error [px]": error.sum() / true.sum(), "bias p-p [px]": np.ptp(bias), "histogram": share.tolist(), "bias": bias.tolist()})
    section.table([("matcher", ""), ("pixels", "d"), ("least", ".2f"), ("most", ".2f"), ("uneven", ".3f"), ("mean error [px]", ".3f"),
                   ("bias p-p [px]", ".3f")], rows,
                  "Ground of the simulator, matches within 1 px. Of each of the 16 fractions of a pixel: how often it was found over how "
                  "often it is true; least, most and standard deviation of these 16 numbers (1, 1 and 0: no locking). Bias: mean error "
                  "for each true fraction, from its least to its most. No gate.")


FLOOR_GATES = {"kitti_street": (0.55, 0.83), "robot_indoor": (0.25, 0.84), "rover_minnie/rectified": (0.97, 0.99), "office": None}


def lower_third(parts, shape):
    """The floor: the lower third of what can be matched."""
    region = geometry.matchable(parts["ndisp"], WINDOW, shape)
    top, bottom, left, right = parts.get("valid", (0, shape[0], 0, shape[1]))
    region[: top + (bottom - top) * 2 // 3] = region[bottom:] = False
    region[:, : left + parts["ndisp"]] = region[:, right:] = False
    return region


def floor_runs(daemon, name, parts):
    sets = source(daemon, name, parts)
    if "paramfile" in parts:
        sets |= {"mounting.height": parts["height"], "mounting.pitch": round(parts["pitch"] * DEGREE, 4)}
    frames = 3 if name == "office" else (8 if daemon.quick else None)
    return sets, frames


def floors_section(daemon, options, section):
    known = known_matchers(daemon.binary, section)
    rows = []
    for name, limits in FLOOR_GATES.items():
        if options.only and name not in options.only:
            continue
        parts = FLOOR_SETS[name]
        try:
            sets, frames = floor_runs(daemon, name, parts)
        except Skipped as why:
            section.note(f"{name} skipped: {why}")
            continue
        found = {}
        first = next(iter(known))

        def look(frame):
            disparity = frame.image("disparity")
            region = lower_third(parts, disparity.shape)
            words = {"ours": disparity[region]}
            if frame.folder.parent.parent.name.endswith("base"):
                left, right = frame.image("left"), frame.image("right")
                for peer in peers.PEERS:
                    words[peer] = peers.match(peer, left, right, parts["ndisp"])[region]
            return words

        runs = [(f"quality-floor-{'base' if m == first else i}/{name.replace('/', '-')}", {**sets, **more}, frames)
                for i, (m, more) in enumerate(known.items())]
        for matcher, looks in zip(known, daemon.measure_all(f"floors, {name}", runs, look)):
            found[matcher] = np.concatenate([l["ours"] for l in looks])
            if matcher == first:
                for peer in peers.PEERS:
                    found[peer] = np.concatenate([l[peer] for l in looks])
        rows += floor_rows(section, name, limits, found)
    if not rows:
        raise Skipped("none of the sets is there")
    section.table([("set", ""), ("matcher", ""), ("density", ".3f"), ("as sgm", ".3f"), ("as SGBM HH", ".3f")], rows,
                  "Lower third of what can be matched: share of the pixels with a disparity; and share of those within 1 px of our sgm "
                  "and of StereoSGBM's MODE_HH, where these have one.")


def agreement(a, b):
    both = (a > 0) & (b > 0)
    return float((np.abs(a[both].astype(int) - b[both]) <= 16).mean()) if both.any() else math.nan


def floor_rows(section, name, limits, found):
    rows = [{"set": name, "matcher": m, "density": float((d > 0).mean()), "as SGBM HH": agreement(d, found["StereoSGBM HH"]),
             "as sgm": agreement(d, found["sgm"]) if "sgm" in found else None} for m, d in found.items()]
    of = {row["matcher"]: row for row in rows}
    aligned, sgm = of.get("bm, align floor"), of.get("sgm")
    if limits and aligned:
        checks = [("density", aligned["density"], limits[0], -1)] + ([("as sgm", aligned["as sgm"], 0.98, -1)] if sgm else [])
        gate(section, f"{name}: floor-aligned: density at least {limits[0]}, 98 % of it within 1 px of sgm", checks)
    if limits and sgm:
        gate(section, f"{name}: sgm: density at least {limits[1]}", [("density", sgm["density"], limits[1], -1)])
    return rows


def measure(section, work):
    start = time.monotonic()
    result = None
    try:
        result = work(section)
    except Skipped as why:
        section.skipped = str(why)
    except RunFailed as failure:
        section.gate("the daemon runs", False, str(failure), "exit 0")
    print(section.text(), flush=True)
    print(f"bench: {section.name}: {time.monotonic() - start:.0f} s", file=sys.stderr)
    return result


def main(root, binaries, options):
    """Prints the tables; 1 if a gate is missed."""
    cv2.setNumThreads(1)
    daemon = Daemon(binaries / "vdispd", options.data or root.parent / "shared" / "data", None, 2, options.quick)
    sections = [Section("matching", "density and errors against truth"), Section("pixel-locking", "fractions of a pixel on the simulator's floor"),
                Section("floors", "share of floor pixels with a disparity")]
    try:
        views = measure(sections[0], lambda s: matching_section(daemon, options, s)) or {}
        if "simulator" in views:
            measure(sections[1], lambda s: locking_section(views["simulator"], s))
        measure(sections[2], lambda s: floors_section(daemon, options, s))
    finally:
        daemon.close()
    if options.json:
        write_json(options.json, {"quick": options.quick}, sections)
    gates = [g for s in sections for g in s.gates]
    missed = [g["gate"] for g in gates if not g["passed"]]
    print(f"{len(gates) - len(missed)} of {len(gates)} gates passed")
    for name in missed:
        print(f"bench: missed: {name}", file=sys.stderr)
    return 1 if missed else 0
