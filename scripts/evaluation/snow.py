# snow.py: section snow: the second detector, trained in worlds with even seeds and judged in others (census + SNoW paper, section 4),
# and what crosses from simulation to a real camera.
# SPDX-License-Identifier: Apache-2.0
import json
import pathlib
import shutil
import subprocess
import time

import cv2

from evaluation.approach import ALARM, NAME, Board
from evaluation.daemon import RunFailed, Skipped

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENCODINGS = ("depth-map", "disparity-map", "contour", "contour-height")
FIRST_TEST = 101  # worlds 101 and on have seeds from 201 on: `drive` has others, and nothing was ever tuned on them
LEAST_AUC = {"obstacle": 0.98, "direction": 0.95}
LONGEST_TRAINING = 180  # s


def call(daemon, *words):
    done = subprocess.run([str(w) for w in words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise RunFailed(f"exit {done.returncode}: {done.stderr.strip()[-400:]} ({' '.join(map(str, words))})")
    return done.stdout


def record_worlds(daemon, folder, *words):
    """Labelled recordings; those that are there already are kept."""
    call(daemon, ROOT / "scripts" / "record-worlds", folder, "--bin", daemon.binary.parent, "--jobs", daemon.jobs, *words)
    return sorted(f for f in folder.iterdir() if f.is_dir())


def write_recording(folder, frames, calibration, seconds=1 / 15):
    """frames: (number, left, right, label) as a labelled recording."""
    shutil.rmtree(folder, ignore_errors=True)
    for side in ("left", "right"):
        (folder / side).mkdir(parents=True)
    lines = ["timestamp_ns,label,left,right,speed,turn_rate"]
    for number, left, right, label in frames:
        name = f"{round(number * seconds * 1e9)}_{label}.png"
        cv2.imwrite(str(folder / "left" / name), left)
        cv2.imwrite(str(folder / "right" / name), right)
        lines.append(f"{name.split('_')[0]},{label},left/{name},right/{name},,")
    (folder / "index.csv").write_text("\n".join(lines) + "\n")
    shutil.copy(calibration, folder / "calibration.yml")
    height, width = frames[0][1].shape
    (folder / "recording.json").write_text(json.dumps({"format": "vdisp recording", "version": 1, "program": "scripts/evaluate", "source": "files",
                                                       "epoch": 0, "width": width, "height": height, "synthetic": True}))


def indoor(daemon, folder):
    """The recorded drive up to a box, in four parts: forward, or where the board is nearer than ALARM, left (there is no side in it)."""
    data = daemon.set_folder(NAME)
    board = Board(data / "chessboard_range.csv")
    videos = [cv2.VideoCapture(str(data / f"robot{side}.mp4")) for side in "LR"]
    frames = []
    while True:
        views = [video.read() for video in videos]
        if not all(good for good, _ in views):
            break
        number = len(frames)
        grey = [cv2.cvtColor(view, cv2.COLOR_BGR2GRAY) for _, view in views]
        frames.append((number, *grey, "left" if board.range.get(number, ALARM) < ALARM else "forward"))
    frames = [f for f in frames if f[0] in board.range]
    # Each part has frames of both kinds: every fourth stretch of eight frames.
    parts = [[f for f in frames if f[0] // 8 % 4 == part] for part in range(4)]
    for part, these in enumerate(parts):
        write_recording(folder / f"part-{part}", these, data / "calibration.yml")
    write_recording(folder / "all", frames, data / "calibration.yml")
    return [folder / f"part-{part}" for part in range(4)], folder / "all"


def train(daemon, model, drives, tests, *words):
    start = time.monotonic()
    found = json.loads(call(daemon, daemon.binary.parent / "vdisp-train", "train", *drives, "-o", model, "--test", *tests, "--json", *words))
    return found, time.monotonic() - start


def snow_section(daemon, section):
    """Trains with --compare, judges on worlds of other seeds; with --pictures the curves of all encodings in one plot each."""
    worlds, pairs, tests, test_pairs = (6, 1200, 3, 450) if daemon.quick else (36, 20000, 12, 5400)
    work = daemon.resume or daemon.work
    plots = (daemon.pictures or work) / "snow"
    learned = record_worlds(daemon, work / "snow-train", "--worlds", worlds, "--pairs", pairs)
    daemon.say(f"snow: {len(learned)} worlds to train with")
    judged = record_worlds(daemon, work / "snow-test", "--worlds", tests, "--pairs", test_pairs, "--test", "--first", FIRST_TEST)
    daemon.say(f"snow: {len(judged)} worlds to judge by")
    model = plots / "snow.model"
    plots.mkdir(parents=True, exist_ok=True)
    _, seconds = train(daemon, model, learned, judged)
    found, _ = train(daemon, model, learned, judged, "--compare", "--plots", plots)
    rows = [{"encoding": name, **{f"{which} AUC": found["encodings"][name][which]["auc"] for which in LEAST_AUC}} for name in ENCODINGS]
    section.table((("encoding", ""), ("obstacle AUC", ".4f"), ("direction AUC", ".4f")), rows,
                  f"{len(learned)} worlds, {pairs} pairs to train with (even seeds); {len(judged)} worlds, {test_pairs} pairs to judge by (odd seeds from {2 * FIRST_TEST - 1} on)")
    for which, least in LEAST_AUC.items():
        best = max(row[f"{which} AUC"] for row in rows)
        section.gate(f"{which} classifier, best encoding", best >= least, f"{best:.4f}", f"AUC of at least {least}")
    section.gate("training, front end included", seconds < LONGEST_TRAINING, f"{seconds:.0f} s", f"less than {LONGEST_TRAINING} s")
    section.command("scripts/record-worlds DIR; vdisp-train train DIR/* -o snow.model --test TEST/* --compare --plots PLOTS")
    try:
        real(daemon, section, work / "snow-indoor", model, plots)
    except Skipped as why:
        section.note(f"{NAME} skipped: {why}")


def real(daemon, section, folder, model, plots):
    parts, whole = indoor(daemon, folder)
    program = daemon.binary.parent / "vdisp-train"
    crossed = json.loads(call(daemon, program, "evaluate", model, whole, "--json", "--plots", plots / "indoor"))["obstacle"]
    own, _ = train(daemon, plots / "indoor.model", parts[:2], parts[2:], "--obstacle-only", "--plots", plots / "indoor-own")
    rows = [{"trained with": "simulated worlds alone", "AUC": crossed["auc"]},
            {"trained with": "half of that drive", "AUC": own["encodings"][own["encoding"]]["obstacle"]["auc"]}]
    section.table((("trained with", ""), ("AUC", ".4f")), rows,
                  f"{NAME}: alarm for a box nearer than {ALARM} m, by the board's range; the second row is judged on the other half, stretches of eight frames apart")
