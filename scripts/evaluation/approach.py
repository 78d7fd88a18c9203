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
        cv2.imwrite(str(daemon.pictures / "approach.png"), plot(tracks, board))


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
    section.gate("range of the box: median error below one cell", error is not None and error < GRID.cell, f"{error:.3f} m" if error is not None else "never seen", "< 0.1 m")
    punctual = row["rise"] is not None and abs(row["rise"]) <= LATE and abs(row["fall"]) <= LATE
    section.gate(f"alarm at {ALARM} m rises and falls within {LATE} frames of the board's", punctual,
                 f"{row['rise']} and {row['fall']} frames", f"at most {LATE}")


WIDTH, HEIGHT, TOP, LEFT, MOST = 960, 190, 24, 40, 3.0  # of a panel, pixels; and m
GREY, RED, BLUE, BLACK = (216, 216, 216), (0, 0, 200), (160, 80, 0), (0, 0, 0)


def panel(name, track, board, frames):
    """Range over frame: the board a line, the box in the map dots; below, alarms in the colour of the dots, over the board's in black."""
    picture = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)

    def place(frame, z):
        return LEFT + round((WIDTH - LEFT - 8) * frame / frames), TOP + round((HEIGHT - TOP - 30) * (1 - min(z, MOST) / MOST))

    def text(words, x, y):
        cv2.putText(picture, words, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.42, BLACK, 1, cv2.LINE_AA)

    text(f"{name}: range of the box [m] over the frame; line: board; below: alarm, black: the board's", LEFT, 14)
    for z in (0, ALARM, 1, 2, 3):
        cv2.line(picture, place(0, z), place(frames, z), RED if z == ALARM else GREY)
        text(f"{z:g}", 8, place(0, z)[1] + 4)
    points = [place(n, z) for n, z in sorted(board.range.items())]
    cv2.polylines(picture, [np.array(points)], False, BLACK, 1, cv2.LINE_AA)
    for n, (seen, alarm, _) in track.items():
        if seen is not None:
            cv2.circle(picture, place(n, seen), 2, BLUE, -1, cv2.LINE_AA)
        if alarm:
            cv2.rectangle(picture, (place(n, 0)[0], HEIGHT - 22), (place(n + 1, 0)[0], HEIGHT - 16), BLUE, -1)
    first, last = board.alarms()[0], board.alarms()[-1]
    cv2.rectangle(picture, (place(first, 0)[0], HEIGHT - 12), (place(last + 1, 0)[0], HEIGHT - 6), BLACK, -1)
    return picture


def plot(tracks, board):
    frames = max(max(track) for track in tracks.values()) + 1
    return np.vstack([panel(name, track, board, frames) for name, track in tracks.items()])
