#!/usr/bin/python3
"""145: scripts/record-worlds: labelled recordings of worlds by seed, gone on from where they are complete, made anew where they are others.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from programs import BIN, ROOT, isolated_main, run

SMALL = ("--set", "sim.width=160", "--set", "sim.height=120")
WORLDS, PAIRS = 3, 10


def record_worlds(folder, *words):
    command = [str(ROOT / "scripts" / "record-worlds"), str(folder), "--bin", str(BIN), "--worlds", str(WORLDS), "--pairs", str(PAIRS), *SMALL]
    return subprocess.run([*command, *map(str, words)], capture_output=True, text=True, timeout=120)


def made(folder):
    """When each recording's list was written."""
    return {path.parent.name: path.stat().st_mtime_ns for path in folder.glob("*/index.csv")}


class Worlds(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp()) / "training"
        cls.done = record_worlds(cls.folder)
        assert cls.done.returncode == 0, cls.done.stderr

    def copy(self):
        copy = pathlib.Path(tempfile.mkdtemp()) / "copy"
        shutil.copytree(self.folder, copy)
        self.addCleanup(shutil.rmtree, copy.parent)
        return copy

    def test_each_scene_is_recorded_with_even_seeds_and_labels(self):
        infos = {path.parent.name: json.loads(path.read_text()) for path in self.folder.glob("*/recording.json")}
        self.assertEqual(sorted(infos), ["garage-2", "office-6", "rocks-4"])
        for name, info in infos.items():
            self.assertEqual(f"{info['world']}-{info['seed']}", name)
            self.assertEqual((info["width"], info["height"]), (160, 120))
        rows = [row for path in self.folder.glob("*/index.csv") for row in csv.DictReader(path.read_text().splitlines())]
        self.assertEqual(len(rows), PAIRS)
        self.assertLessEqual({row["label"] for row in rows}, {"forward", "left", "right"})
        self.assertIn(f"{PAIRS} pairs in {self.folder}: ", self.done.stdout.splitlines()[-1])

    def test_test_worlds_have_odd_seeds_from_the_first_on(self):
        with tempfile.TemporaryDirectory() as folder:
            done = record_worlds(folder, "--test", "--first", 101)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(sorted(made(pathlib.Path(folder))), ["garage-205", "office-203", "rocks-201"])

    def test_the_same_command_keeps_what_is_complete_and_only_that(self):
        folder = self.copy()
        before = made(folder)
        lines = (folder / "rocks-4" / "index.csv").read_text().splitlines()
        (folder / "rocks-4" / "index.csv").write_text("\n".join(lines[:-1]) + "\n")
        done = record_worlds(folder)
        self.assertEqual((done.returncode, done.stdout), (0, self.done.stdout.replace(str(self.folder), str(folder))), done.stderr)
        after = made(folder)
        self.assertEqual({name for name in after if after[name] != before[name]}, {"rocks-4"})
        self.assertEqual((folder / "rocks-4" / "index.csv").read_text().splitlines(), lines)

    def test_other_options_record_anew(self):
        folder = self.copy()
        before = made(folder)
        done = record_worlds(folder, "--pitch", 0, 0)
        self.assertEqual(done.returncode, 0, done.stderr)
        after = made(folder)
        self.assertEqual({name for name in after if after[name] != before[name]}, set(before))
        pictures = [root / "garage-2" / "left" for root in (self.folder, folder)]
        self.assertNotEqual(*[sorted(path.iterdir())[0].read_bytes() for path in pictures])

    def test_a_folder_that_it_has_not_made_is_kept(self):
        folder = self.copy()
        (folder / ".office-6.json").unlink()
        before = made(folder)
        done = record_worlds(folder, "--pitch", 0, 0)
        self.assertEqual(done.returncode, 74, done.stdout)
        self.assertIn("office-6 is there, and was not made by this script", done.stderr)
        self.assertEqual(made(folder)["office-6"], before["office-6"])

    def test_what_it_records_is_what_the_training_reads(self):
        found = run("vdisp-train", "train", *sorted(self.folder.glob("[!.]*-*")), "--hold-out", 0, "--size", "160x120", "-o", self.folder.parent / "a.model")
        # So few pairs may lack a label; nothing else is wrong with them.
        self.assertIn(found.returncode, (0, 66), found.stderr)
        if found.returncode:
            self.assertIn("no pair with label", found.stderr)


if __name__ == "__main__":
    isolated_main()
