# readers.py: the kinds of readers: how each is called, and what of its output proves that frames came in order.
# SPDX-License-Identifier: Apache-2.0
import json
import re


def numbers(pattern):
    """check(): the numbers of the frames in an output, in its order."""
    form = re.compile(pattern, re.M)
    return lambda output, _: [int(number) for number in form.findall(output)]


def frames_of_c(output, _):
    """It tells once a second, also where nothing came: only what is new counts."""
    lines = re.findall(rb"^frames (\d+) .* sequence (\d+)$", output, re.M)
    return [int(sequence) for i, (frames, sequence) in enumerate(lines) if frames != b"0" and (i == 0 or frames != lines[i - 1][0])]


def frames_of_dump(_, folder):
    """Whole frames: of one that was killed a hidden folder is left, .000012.part, which would come first."""
    whole = [file for file in sorted(folder.glob("dump/[0-9]*/frame.json")) if file.stat().st_size > 0]
    return [json.loads(file.read_text())["sequence"] for file in whole]


def steps_of_recording(_, folder):
    file = folder / "recording/inputs.csv"
    lines = file.read_text().splitlines(keepends=True) if file.exists() else []
    return [int(line.split(",", 1)[0]) for line in lines[1:] if line.endswith("\n")]


class Kind:
    """`words(random, folder)`: the command. `check(output, folder)`: numbers that have to rise. `streams`: writes at least once a second.
    `alone`: takes images of so many topics that two of them, stopped, hold all blocks of a pool."""

    def __init__(self, name, weight, words, check, streams=True, alone=False):
        self.name, self.weight, self.words, self.check, self.streams, self.alone = name, weight, words, check, streams, alone


def goal(random):
    return [f"{random.uniform(1, 4.5):.1f}", f"{random.uniform(-2, 2):.1f}"]


JSON_SEQUENCE = rb'^\{"state": ?"fresh",.*?"sequence": ?(\d+)'

KINDS = [
    Kind("planner", 3, lambda r, f: ["vdisp-planner"], numbers(rb"^map (\d+)")),
    Kind("incremental", 3, lambda r, f: ["vdisp-incremental-planner", *goal(r), "--json"], numbers(JSON_SEQUENCE)),
    Kind("fused", 2, lambda r, f: ["vdisp-incremental-planner", *goal(r), "--json", "--fused"], numbers(JSON_SEQUENCE)),
    Kind("c", 3, lambda r, f: ["vdisp-follow-c", "1000"], frames_of_c),
    Kind("map", 2, lambda r, f: ["vdisp-probe", "map", "--json"], numbers(JSON_SEQUENCE)),
    Kind("stats", 2, lambda r, f: ["vdisp-probe", "stats", "--json"], numbers(rb'^\{"state":"running","steps":(\d+)')),
    Kind("latency", 1, lambda r, f: ["vdisp-probe", "latency", "--reader", "--json"], numbers(rb'"count": ?(\d+).*"missed"'), streams=False),
    Kind("list", 1, lambda r, f: ["vdisp-probe", "list", "--json"], lambda output, _: [], streams=False),
    Kind("dump", 1, lambda r, f: ["vdisp-probe", "dump", f / "dump", "left", "disparity", "map", "occupancy", "--frames", 20], frames_of_dump, streams=False),
    Kind("all", 1, lambda r, f: ["vdisp-probe", "dump", f / "dump", "--frames", 5], frames_of_dump, streams=False, alone=True),
    Kind("record", 1, lambda r, f: ["vdisp-probe", "record", f / "recording", "--rate", 5], steps_of_recording, streams=False, alone=True),
    Kind("sheet", 1, lambda r, f: ["vdisp-probe", "sheet", f / "sheet.png"], lambda output, _: [], streams=False, alone=True),
]


def not_rising(found):
    """The first number that is not above the one before, as words; nothing where all rise."""
    for before, after in zip(found, found[1:]):
        if after <= before:
            return f"{after} after {before}"
    return None
