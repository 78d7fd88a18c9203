# approach.py: section approach: a robot drives up to a box with a chessboard and away again; the map's range of it against the board's.
# SPDX-License-Identifier: Apache-2.0
import csv

import cv2
import numpy as np

from evaluation import kinds, recorded
from evaluation.recorded import FLOOR_SETS
from evaluation.simulated import GRID, MATCHERS, percentile

ALARM, LATE, NEAR_BOARD = 0.8, 3, 0.6  # m, frames, m
NAME = "robot_indoor"


class Board:
    """Where the chessboard is seen: per frame its range [m] and the columns that it covers. Made with the published baseline and focal
    length, which the daemon uses as well: their common scale error is in both, and cancels."""

    def __init__(self, path):
        with open(path) as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.range = {int(r["frame"]): float(r["Z_mm"]) / 1000 for r in rows}
        self.columns = {int(r["frame"]): (float(r["xmin"]), float(r["xmax"])) for r in rows}

    def alarms(self):
        """Frames in which it is nearer than ALARM."""
        return [n for n, z in sorted(self.range.items()) if z < ALARM]


def box_range(cells, columns, camera, grid=GRID):
    """Middle of the nearest obstacle cell [m ahead] that the board's columns see, and None without one. Nothing else is known of the
    board here: its range has no say."""
    for row in range(grid.rows - 1, -1, -1):
        ahead = (grid.rows - 0.5 - row) * grid.cell
        first, last = ((column - camera["cx"]) / camera["f"] * ahead / grid.cell + grid.columns / 2 for column in columns)
        if cells[row, max(int(first), 0) : max(int(last) + 1, 0)].any():
            return ahead
    return None


def alarmed(cells, corridor=0.5, grid=GRID):
    """An obstacle cell nearer than ALARM in a corridor of so many m before the camera: what a rover would stop for."""
    rows, half = round(ALARM / grid.cell), corridor / grid.cell / 2
    return bool(cells[grid.rows - rows :, int(grid.columns / 2 - half) : int(np.ceil(grid.columns / 2 + half))].any())


def lateness(alarms, board):
    """Frames from the board's first and last alarm to ours nearest to them; None without one. And how many of ours lie farther off."""
    if not alarms or not board:
        return None, None, len(alarms)
    spans = np.split(np.array(alarms), np.nonzero(np.diff(alarms) > 1)[0] + 1)
    main = max(spans, key=lambda span: len(np.intersect1d(span, np.arange(board[0], board[-1] + 1))))
    far = [n for n in alarms if not board[0] - LATE <= n <= board[-1] + LATE]
    return int(main[0]) - board[0], int(main[-1]) - board[-1], len(far)


def section(daemon, section):
    folder = daemon.set_folder(NAME)
    board = Board(folder / "chessboard_range.csv")
    parts = FLOOR_SETS[NAME]
    told = recorded.floor_variants(parts)[2][1]
    rows, tracks = [], {}
    for matcher in MATCHERS:
        sets = {**recorded.source(daemon, NAME, parts), **told, "image source.matcher": matcher}

        def look(frame):
            maps = {"map": frame.image("map") >= 3 if frame.valid("map") else None}
            grid = kinds.occupancy(frame)
            maps["occupancy"] = grid >= kinds.OCCUPIED if frame.valid("occupancy") else None
            return {"frame": frame.json["sequence"], "camera": frame.camera("disparity"), **maps}

        looks = daemon.measure(f"approach-{matcher}", sets, None, look)
        for source in ("map", "occupancy"):
            track = tracks[f"{matcher}, {source}"] = follow(looks, source, board)
            rows.append(row_of(f"{matcher}, {source}", track, board))
        section.command(daemon.command_line(sets))
        daemon.say(f"approach: {matcher}")
    section.table(COLUMNS, rows, f"{len(board.range)} frames with a range of the board. Error: middle of the nearest obstacle cell (0.1 m) among "
                  "the board's columns, less the board's range, both in the published calibration's scale. Alarm: an obstacle cell nearer than "
                  f"{ALARM} m in the 0.5 m before the camera; rise and fall: frames after the board's {board.alarms()[0]} and {board.alarms()[-1]}; "
                  f"elsewhere: frames with an alarm more than {LATE} frames before or after the board's.")
    judge(section, rows)
    if daemon.pictures:
        daemon.pictures.mkdir(parents=True, exist_ok=True)
        (daemon.pictures / "approach.svg").write_text(plot(tracks, board))


COLUMNS = [("from", ""), ("seen", ".3f"), ("error p50 [m]", ".3f"), ("|error| p50 [m]", ".3f"), ("|error| p90 [m]", ".3f"), ("scale", ".3f"),
           ("within a cell", ".3f"), ("rise", "d"), ("fall", "d"), ("elsewhere", "d"), ("blind", "d")]


def follow(looks, source, board):
    """Per frame: (range or None, alarm, blind)."""
    track = {}
    for look in looks:
        n, cells = look["frame"], look[source]
        seen = box_range(cells, board.columns[n], look["camera"]) if cells is not None and n in board.columns else None
        track[n] = seen, cells is not None and alarmed(cells), cells is None
    return track


def row_of(name, track, board):
    errors = {n: track[n][0] - z for n, z in board.range.items() if track[n][0] is not None}
    sizes = [abs(e) for e in errors.values()]
    rise, fall, elsewhere = lateness([n for n, (_, alarm, _) in sorted(track.items()) if alarm], board.alarms())
    return {"from": name, "seen": len(errors) / len(board.range), "error p50 [m]": percentile(errors.values(), 50),
            "|error| p50 [m]": percentile(sizes, 50), "|error| p90 [m]": percentile(sizes, 90),
            "scale": percentile([1 + e / board.range[n] for n, e in errors.items()], 50),
            "within a cell": float(np.mean([s <= GRID.cell for s in sizes])) if sizes else None,
            "rise": rise, "fall": fall, "elsewhere": elsewhere, "blind": sum(blind for _, _, blind in track.values())}


def judge(section, rows):
    """Gates are for the default matcher and the map that planners are meant to read."""
    row = next(r for r in rows if r["from"] == "bm, occupancy")
    error = row["|error| p50 [m]"]
    section.gate("range of the box: median error below one cell", error is not None and error < GRID.cell, f"{error} m", "< 0.1 m")
    punctual = row["rise"] is not None and abs(row["rise"]) <= LATE and abs(row["fall"]) <= LATE
    section.gate(f"alarm at {ALARM} m rises and falls within {LATE} frames of the board's", punctual,
                 f"{row['rise']} and {row['fall']} frames", f"at most {LATE}")


COLOURS = {"bm, map": "#7fb3d5", "bm, occupancy": "#1f4e79", "sgm, map": "#f0b27a", "sgm, occupancy": "#b9500f"}


def plot(tracks, board):
    """Range over frame as SVG, one panel for each track: the board as a line, the map's range as dots, alarms as bars below."""
    width, height, top, most, wide = 900, 190, 24, 3.0, 860 / max(max(track) for track in tracks.values())
    across, down = (lambda n: 34 + wide * n), (lambda z: top + (height - top - 26) * (1 - z / most))
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height * len(tracks)}" font-family="sans-serif" font-size="11">',
             '<rect width="100%" height="100%" fill="white"/>']
    for panel, (name, track) in enumerate(tracks.items()):
        lines.append(f'<g transform="translate(0 {panel * height})"><text x="34" y="14">{name}: range of the box [m] over the frame; line: board</text>')
        for z in (0, ALARM, 1, 2, 3):
            lines.append(f'<path d="M34 {down(z):.1f}H894" stroke="{"#c00" if z == ALARM else "#ddd"}"/><text x="4" y="{down(z) + 4:.1f}">{z}</text>')
        points = " ".join(f"{across(n):.1f},{down(z):.1f}" for n, z in sorted(board.range.items()))
        lines.append(f'<polyline points="{points}" fill="none" stroke="black"/>')
        for n, (seen, alarm, _) in track.items():
            if seen is not None and seen < most:
                lines.append(f'<circle cx="{across(n):.1f}" cy="{down(seen):.1f}" r="2" fill="{COLOURS[name]}"/>')
            if alarm:
                lines.append(f'<rect x="{across(n):.1f}" y="{height - 18}" width="{wide:.2f}" height="6" fill="{COLOURS[name]}"/>')
        first, last = board.alarms()[0], board.alarms()[-1]
        lines.append(f'<rect x="{across(first):.1f}" y="{height - 10}" width="{wide * (last - first + 1):.1f}" height="6"/></g>')
    return "\n".join(lines + ["</svg>", ""])
