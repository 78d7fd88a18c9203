# peer_maps.py: section peers: our maps, the paper's, and what OpenCV and PCL make of the same pairs, against the same truth.
# SPDX-License-Identifier: Apache-2.0
import json
import subprocess

import cv2
import numpy as np

from evaluation import kinds, map_pictures, recorded, simulated
from evaluation.daemon import RunFailed, Skipped
from evaluation.recorded import COUNTS, compare_cells, shares
from evaluation.simulated import percentile
from evaluation.truth import SceneTruth

# What runs from two rectified views to the map of one frame when nobody watches; stages that share a process() have one time. Memory (memory,
# tracks, fused) has no peer: it is not counted.
OUR_STAGES = ("disparity", "floor_model", "height", "occupancy", "map_changes", "map")
PAPER_STAGES = ("disparity", "vdisparity", "floor_model", "limit", "map")
GROUNDS = {"plane": "plane and normals", "morphological": "morphological filter"}
# Of some 15 settings those with the best F1 of the peers on the very pairs that are judged: one for the lidar's pairs, one for the
# simulator's. Ours have one for all.
LIDAR_FILTERS = ["--voxel-points", "4"]
SCENE_FILTERS = ["--voxel-points", "4", "--cell-voxels", "8", "--speckle", "400", "--tilt", "0.3"]


class World:
    """Pairs of one kind: what the daemon and the peers are told of them, and their truth.

    runs: (name, parameters, frames, how many of them are judged); mounting: height [m] and pitch [rad]; area: heights of obstacles [m];
    truth: of a Frame and the run's name, masks of the grid: to be found, observed, and where a found cell is right."""

    def __init__(self, name, runs, grid, mounting, area, ndisp, filters, truth):
        self.name, self.runs, self.grid, self.mounting, self.area, self.ndisp = name, runs, grid, mounting, area, ndisp
        self.filters, self.truth = filters, truth

    def variants(self):
        """name: (grids read from a frame, stages timed, parameters). One setting of ours everywhere: the defaults."""
        told = {"mounting.height": self.mounting[0], "mounting.pitch": self.mounting[1]}
        angles = {"Limit obstacle.angRot": self.mounting[1], "Map.angRot": self.mounting[1]}
        paper = {"Floor.model": "line", "image source.matcher": "opencv", **angles}
        return {"bm": (("occupancy", "map"), OUR_STAGES, told), "sgm": (("occupancy", "map"), OUR_STAGES, {**told, "image source.matcher": "sgm"}),
                "paper": (("map",), PAPER_STAGES, paper)}

    def peer_words(self):
        least, most = self.area
        reach, width = self.grid.rows * self.grid.cell, self.grid.columns * self.grid.cell
        words = {"ndisp": self.ndisp, "height": self.mounting[0], "pitch": self.mounting[1], "range": reach, "width": width,
                 "cell": self.grid.cell, "least": least, "most": most}
        return [word for key, value in words.items() for word in (f"--{key}", f"{value:g}")] + self.filters


def lidar_world(daemon):
    folder = daemon.set_folder("kitti_lidar")
    places = {f"kitti-{p.name}": p for p in sorted(folder.iterdir()) if p.is_dir()}

    def truth(frame, name):
        depth = cv2.imread(str(places[name] / "depth_m_x256.png"), cv2.IMREAD_UNCHANGED).astype(np.float32) / 256
        obstacle, observed, _, _ = recorded.lidar_truth(depth, recorded.calibration_of(places[name] / "calibration.yml"), 128)
        return obstacle, observed, obstacle

    # The first of four frames, all of the same pair, is judged; the others are timed.
    more = {"image source.loop": "yes", "Limit obstacle.clearance": 2.2}
    runs = [(name, recorded.lidar_sets(p, "bm", more), 4, 1) for name, p in places.items()]
    return World("kitti_lidar", runs, recorded.LIDAR_GRID, (1.65, 0.0), (0.4, 2.2), 128, LIDAR_FILTERS, truth)


def scene_truth(frame, _):
    truth = SceneTruth(frame, simulated.GRID)
    return truth.to_be_seen, np.ones_like(truth.to_be_seen), truth.in_the_way


def simulated_worlds(daemon):
    seeds, chosen = range(1, 3 if daemon.quick else 9), daemon.kinds or ("flat", "ramp", "crowded", "rough")
    for kind in chosen:
        frames = kinds.KINDS[kind][1]
        runs = [(f"{kind}-{seed}", kinds.parameters(daemon, kind, seed), frames, frames) for seed in seeds]
        sets = runs[0][1]
        if sets["sim.pitch"] != kinds.MEASURED["mounting.pitch"]:
            raise Skipped(f"{kind}: the camera is mounted otherwise there")
        yield World(kind, runs, simulated.GRID, (0.8, 0.2618), (0.2, 2.0), 48, SCENE_FILTERS, scene_truth)


def grids_of(frame, stages, shape):
    """Of each stage the cells said to be obstacles; none in a blind one."""
    grids = {}
    for stage in stages:
        if not frame.valid(stage):
            grids[stage] = np.zeros(shape, bool)
        elif stage == "map":
            grids[stage] = frame.image("map") >= 3
        else:
            grids[stage] = frame.image("occupancy").astype(np.uint8).view(np.int8) >= kinds.OCCUPIED
    return grids


def time_of(frame, stages):
    times = json.loads((frame.folder / "timing.json").read_text())
    return sum(times.get(stage, 0) for stage in stages) / 1e6


def run_peers(daemon, world, frame, repeat):
    """name: (cells said to be obstacles, ms)."""
    command = [str(daemon.peers), *world.peer_words(), "--repeat", str(repeat), str(frame.folder)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RunFailed(f"exit {done.returncode}: {done.stderr.strip()[-400:]} ({' '.join(command)})")
    results = {}
    for line in done.stdout.splitlines():
        told = json.loads(line)
        grid = cv2.imread(str(frame.folder / told["file"]), cv2.IMREAD_UNCHANGED) > 0
        results[f"{told['matcher']}, {GROUNDS[told['ground']]}"] = grid, told["match_ms"] + told["ground_ms"]
    return results


def measure_run(daemon, world, run):
    """Frames judged: {"truth": masks, "left": picture, "grids": {method: cells}}; and {method: [ms]}."""
    name, base, frames, judged = run
    looks, times = [{"grids": {}} for _ in range(judged)], {}
    for variant, (stages, timed, sets) in world.variants().items():
        one = {**base, **sets, "main.threads": 1}

        def look(frame):
            i = frame.json["sequence"]
            methods = {stage: variant if variant == "paper" else f"{variant}, {stage}" for stage in stages}
            if i > 0:  # the first one finds cold caches
                for method in methods.values():
                    times.setdefault(method, []).append(time_of(frame, timed))
            if i >= judged:
                return
            for stage, grid in grids_of(frame, stages, (world.grid.rows, world.grid.columns)).items():
                looks[i]["grids"][methods[stage]] = grid
            if variant == "bm":
                looks[i]["truth"] = world.truth(frame, name)
                looks[i]["left"] = frame.image("left")
                for method, (grid, ms) in run_peers(daemon, world, frame, 4 if judged == 1 else 2).items():
                    looks[i]["grids"][method] = grid
                    times.setdefault(method, []).append(ms)

        daemon.measure(f"peers/{name}-{variant}", one, frames, look)
    return looks, times


def pooled(looks, method):
    total = dict.fromkeys(COUNTS, 0)
    for look in looks:
        for key, count in compare_cells(look["grids"][method], *look["truth"]).items():
            total[key] += count
    return {**total, **shares(total)}


def section(daemon, section):
    if not daemon.peers.is_file():
        raise Skipped(f"no {daemon.peers}; scripts/evaluate peers builds it")
    rows = []
    for make in (lambda: [lidar_world(daemon)], lambda: simulated_worlds(daemon)):
        try:
            for world in make():
                rows += world_rows(daemon, section, world)
        except Skipped as why:
            section.note(f"skipped: {why}")
    columns = [("set", ""), ("method", ""), ("frames", "d"), ("cells to find", "d"), ("precision", ".3f"), ("recall", ".3f"), ("F1", ".3f")]
    columns += [("same cell precision", ".3f"), ("recall ", ".3f"), ("ms p50", ".1f"), ("of ours", ".1f")]
    section.table(columns, rows, "All frames pooled; one cell of tolerance, but for `same cell`. bm, sgm: ours with defaults, mounting told. "
                  "paper: StereoBM, the paper's line and map. The others: vdisp-peers. From two rectified views to the grid, one thread "
                  "each; of ours: times that of `bm, occupancy`.")


def world_rows(daemon, section, world):
    looks, times = [], {}
    for done, run in enumerate(world.runs, 1):
        more, ms = measure_run(daemon, world, run)
        if daemon.pictures:
            for i, look in enumerate(more):
                map_pictures.write(daemon.pictures, f"{run[0]}-{i}", look)
        looks += more
        for method, values in ms.items():
            times.setdefault(method, []).extend(values)
        daemon.say(f"peers: {world.name}: {done} of {len(world.runs)} runs")
    ours = percentile(times["bm, occupancy"], 50)
    rows = []
    for method in looks[0]["grids"]:
        result, ms = pooled(looks, method), percentile(times[method], 50)
        rows.append({**result, "set": world.name, "method": method, "frames": len(looks), "cells to find": result["true"], "ms p50": ms,
                     "of ours": ms / ours})
    judge(section, world, {row["method"]: row["F1"] or 0 for row in rows})
    for _, _, sets in world.variants().values():
        section.command(daemon.command_line({**world.runs[0][1], **sets, "main.threads": 1}, world.runs[0][2]))
    section.command(" ".join(["vdisp-peers", *world.peer_words(), "DIR/000000"]))
    return rows


def judge(section, world, scores):
    """Gates are for the default matcher and the map that planners are meant to read."""
    mine = scores["bm, occupancy"]
    name, best = max(((n, s) for n, s in scores.items() if not n.startswith(("bm", "sgm"))), key=lambda entry: entry[1])
    if world.name == "kitti_lidar":
        section.gate("kitti_lidar: F1 of bm, occupancy, pooled (aim 0.95)", mine >= 0.92, f"{mine:.3f}", ">= 0.92")
        section.gate("kitti_lidar: F1 of bm, occupancy ahead of the paper's and of the packages'", mine > best, f"{mine:.3f}; {name}: {best:.3f}",
                     "the greater")
    else:
        section.note(f"{world.name}: F1 of bm, occupancy is {'ahead' if mine > best else 'behind'}: {mine:.3f}; {name}: {best:.3f}")
