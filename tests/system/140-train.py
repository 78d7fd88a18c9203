#!/usr/bin/python3
"""140: vdisp-train: learns to tell free from obstacle on drawn rooms, judges on whole drives held apart, and refuses what is broken.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import os
import pathlib
import pty
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

import cv2
import numpy

from programs import BIN, isolated_main, run
from small_worlds import drive, write_recording

WIDTH, HEIGHT = 160, 120
SIZE = ("--size", f"{WIDTH}x{HEIGHT}")
FRONT = (*SIZE, "--width", "32", "--block", "7")
DRIVES, PAIRS = 6, 20


def table(path):
    with open(path) as file:
        return list(csv.DictReader(file))


class Train(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.drives = [drive(cls.folder / f"drive{i}", i, PAIRS, width=WIDTH, height=HEIGHT) for i in range(DRIVES)]
        cls.with_, cls.apart = cls.drives[:4], cls.drives[4:]
        cls.model = cls.folder / "first.model"
        cls.trained = run("vdisp-train", "train", *cls.with_, "--test", *cls.apart, *FRONT, "-o", cls.model, "--json", "--compare",
                          "--plots", cls.folder / "plots")
        assert cls.trained.returncode == 0, cls.trained.stderr
        cls.report = json.loads(cls.trained.stdout)

    def setUp(self):
        self.place = pathlib.Path(tempfile.mkdtemp())

    def refused(self, code, *words, arguments, program_words=("train",)):
        """The program refuses in one line that says `words`, and the model that was there is as before."""
        model = self.place / "kept.model"
        shutil.copy(self.model, model)
        output = ("-o", model) if program_words == ("train",) else ()
        found = run("vdisp-train", *program_words, *arguments, *output)
        self.assertEqual(found.returncode, code, found.stderr)
        lines = [line for line in found.stderr.splitlines() if not line.startswith("vdisp-train: front end ")]
        self.assertEqual(len(lines), 1, found.stderr)
        for word in words:
            self.assertIn(word, lines[0])
        self.assertEqual(model.read_bytes(), self.model.read_bytes())
        self.assertEqual([path.name for path in self.place.glob(".*")], [])
        return lines[0]

    def broken(self, change, source=None):
        """A copy of a drive, changed."""
        copy = self.place / "broken"
        shutil.copytree(source or self.drives[0], copy)
        change(copy)
        return copy

    # What it learns

    def test_both_classifiers_separate_drives_that_they_have_not_seen(self):
        for encoding, found in self.report["encodings"].items():
            # Of 80 pairs it knows little; chance would give 0.5.
            self.assertGreater(found["obstacle"]["auc"], 0.95, encoding)
            self.assertGreater(found["direction"]["auc"], 0.8, encoding)
        self.assertEqual(len(self.report["encodings"]), 4)

    def test_confusion_counts_every_pair_held_apart_once(self):
        labels = [row["label"] for folder in self.apart for row in table(folder / "index.csv")]
        confusion = self.report["encodings"]["depth-map"]["obstacle"]["confusion"]
        self.assertEqual(confusion["hits"] + confusion["misses"], sum(label != "forward" for label in labels))
        self.assertEqual(confusion["false_alarms"] + confusion["rejections"], labels.count("forward"))
        direction = self.report["encodings"]["depth-map"]["direction"]["confusion"]
        self.assertEqual(direction["hits"] + direction["misses"], labels.count("left"))

    def test_the_model_does_not_depend_on_threads_and_evaluates_as_it_was_judged(self):
        again = self.place / "again.model"
        found = run("vdisp-train", "train", *self.with_, "--test", *self.apart, *FRONT, "-o", again, "--threads", 1)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertEqual(again.read_bytes(), self.model.read_bytes())
        found = run("vdisp-train", "evaluate", again, *self.apart, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        evaluated = json.loads(found.stdout)
        self.assertEqual(evaluated["obstacle"], self.report["encodings"]["depth-map"]["obstacle"])
        self.assertEqual(evaluated["direction"], self.report["encodings"]["depth-map"]["direction"])

    def test_network_front_end_and_order_change_the_model(self):
        base = self.place / "base.model"
        self.assertEqual(run("vdisp-train", "train", *self.with_[:2], "--hold-out", 0, *SIZE, "-o", base).returncode, 0)
        for options in (("--alpha", 1.2), ("--beta", 0.8), ("--theta", 2), ("--initial", 0.001), ("--passes", 1), ("--seed", 7),
                        ("--above", 0.5), ("--below", 0.5), ("--encoding", "contour"), ("--smooth", "median"), ("--block", 13),
                        ("--width", 48), ("--confidence", 1.6), ("--obstacle-sensitivity", 0.1), ("--direction-sensitivity", 0.1)):
            other = self.place / "other.model"
            found = run("vdisp-train", "train", *self.with_[:2], "--hold-out", 0, *SIZE, "-o", other, *options)
            self.assertEqual(found.returncode, 0, found.stderr)
            self.assertNotEqual(other.read_bytes(), base.read_bytes(), options)

    def test_the_front_end_is_that_of_a_configuration(self):
        config = self.place / "vdisp.cfg"
        config.write_text("[census]\nblock = 7\nencoding = contour\nconfidence = 0.5\n")
        models = [self.place / "a.model", self.place / "b.model"]
        for model, options in zip(models, (("-c", config), ("--block", 7, "--encoding", "contour", "--confidence", 0.5))):
            found = run("vdisp-train", "train", *self.with_[:2], "--hold-out", 0, *SIZE, "-o", model, *options)
            self.assertEqual(found.returncode, 0, found.stderr)
            self.assertIn("[census] encoding = contour, smooth = mean, block = 7, width = 32, confidence = 0.5", found.stdout)
        self.assertEqual(models[0].read_bytes(), models[1].read_bytes())
        config.write_text("[census]\nblock = 8\n")
        self.refused(78, "vdisp.cfg:2", "block", arguments=[*self.with_, "-c", config])
        self.refused(66, "nowhere.cfg", arguments=[*self.with_, "-c", self.place / "nowhere.cfg"])

    def test_larger_recordings_are_made_smaller_and_dark_pairs_left_out(self):
        def grow(folder):
            for path in folder.glob("*/*.png"):
                cv2.imwrite(str(path), cv2.resize(cv2.imread(str(path), 0), (2 * WIDTH, 2 * HEIGHT), interpolation=cv2.INTER_NEAREST))
            text = (folder / "recording.json").read_text()
            (folder / "recording.json").write_text(text.replace(f'"width": {WIDTH}', f'"width": {2 * WIDTH}').replace(f'"height": {HEIGHT}', f'"height": {2 * HEIGHT}'))

        def darken(folder):
            for path in sorted((folder / "left").iterdir())[:3]:
                cv2.imwrite(str(path), numpy.zeros((HEIGHT, WIDTH), numpy.uint8))
        large = self.place / "large.model"
        models = []
        for change in (grow, lambda folder: None):
            copies = [self.broken(change, source) for source in self.with_[:1]]
            self.assertEqual(run("vdisp-train", "train", *copies, "--hold-out", 0, *FRONT, "-o", large).returncode, 0)
            models.append(large.read_bytes()[:1 << 25])
            shutil.rmtree(copies[0])
        self.assertEqual(models[0][4096:], models[1][4096:])
        found = run("vdisp-train", "train", self.broken(darken), "--hold-out", 0, *FRONT, "-o", large)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertIn("left out: 3 pairs with which the daemon would be blind", found.stdout)

    def test_a_sensitivity_chosen_for_detection_finds_that_part(self):
        found = run("vdisp-train", "train", *self.with_, "--test", *self.apart, *FRONT, "-o", self.place / "a.model", "--detection", 1, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertEqual(json.loads(found.stdout)["encodings"]["depth-map"]["obstacle"]["confusion"]["misses"], 0)

    def test_no_model_is_made_whose_numbers_decide_nothing(self):
        line = self.refused(64, "--detection", arguments=[*self.with_, "--test", *self.apart, *FRONT, "--detection", 0])
        self.assertIn("--help", line)
        for theta in (0, -1, 1e300, 1e-300, "nan", "inf"):  # the weights begin with a part of it, as 32 bit numbers
            self.refused(64, "--theta", arguments=[*self.with_, "--test", *self.apart, *FRONT, "--theta", theta])
        # Whatever the promotion, weights stay numbers, and what is written can be used.
        model = self.place / "steep.model"
        found = run("vdisp-train", "train", *self.with_, "--hold-out", 0, *FRONT, "--alpha", 1e30, "-o", model)
        self.assertEqual(found.returncode, 0, found.stderr)
        found = run("vdisp-train", "evaluate", model, *self.apart)
        self.assertEqual(found.returncode, 0, found.stderr)

    # Splits

    def test_a_split_takes_whole_drives_and_depends_on_its_seed_only(self):
        splits = []
        for seed in (1, 1, 2, 3, 4):
            model = self.place / f"split{seed}.model"
            found = run("vdisp-train", "train", *self.drives, *FRONT, "--hold-out", 0.34, "--split-seed", seed, "-o", model, "--json")
            self.assertEqual(found.returncode, 0, found.stderr)
            held = json.loads(found.stdout)["held_apart"]
            self.assertEqual(held["drives"], 2)
            self.assertEqual(held["forward"] + held["left"] + held["right"], 2 * PAIRS)
            splits.append(model.read_bytes()[-2000:])
        self.assertEqual(splits[0], splits[1])
        self.assertGreater(len(set(splits)), 1)

    def test_a_drive_is_never_on_both_sides(self):
        link = self.place / "link"
        link.symlink_to(self.drives[0])
        self.refused(64, "is given twice", arguments=[*self.with_, "--test", link])
        self.refused(64, "was trained with it", arguments=[self.model, self.with_[0]], program_words=("evaluate",))

    # Files

    def test_plots_show_the_points_of_the_table(self):
        plots = self.folder / "plots"
        for name in ("roc", "obstacle", "direction"):
            xml.etree.ElementTree.parse(plots / f"{name}.svg")
            self.assertGreater(cv2.imread(str(plots / f"{name}.png")).std(), 5)
        curves = xml.etree.ElementTree.parse(plots / "obstacle.svg").getroot().iter("{http://www.w3.org/2000/svg}text")
        self.assertEqual(sum(text.text.startswith(("d", "c")) for text in curves), 4)
        points = [row for row in table(plots / "points.csv") if row["encoding"] == "contour" and row["classifier"] == "obstacle"]
        x, y = (numpy.array([float(row[key]) for row in points]) for key in ("false_acceptance", "detection"))
        self.assertAlmostEqual(float(((y[1:] + y[:-1]) / 2 * numpy.diff(x)).sum()), self.report["encodings"]["contour"]["obstacle"]["auc"], places=6)

    def test_collisions_join_the_recordings_of_a_model_and_weigh_in(self):
        crash = drive(self.place / "crash", 99, 8, ("left", "right"), WIDTH, HEIGHT)
        model = self.place / "more.model"
        shutil.copy(self.model, model)
        found = run("vdisp-train", "train", "--add", crash, "-o", model, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        report = json.loads(found.stdout)
        self.assertEqual(report["trained_with"]["drives"], 5)
        self.assertEqual(report["held_apart"], self.report["held_apart"])
        self.assertEqual(report["trained_with"]["left"] + report["trained_with"]["right"],
                         self.report["trained_with"]["left"] + self.report["trained_with"]["right"] + 8)
        self.assertIn(b"train\t3\t" + str(crash.resolve()).encode(), model.read_bytes()[-2000:])
        once = self.place / "once.model"
        found = run("vdisp-train", "train", "--add", crash, "--add-weight", 1, "--to", self.model, "-o", once)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertNotEqual(once.read_bytes()[4096:1 << 25], model.read_bytes()[4096:1 << 25])
        shutil.rmtree(crash)
        self.refused(66, "which is not there", arguments=["--add", self.drives[0], "--to", model])

    def test_killed_or_out_of_space_it_leaves_the_old_model(self):
        model = self.place / "kept.model"
        shutil.copy(self.model, model)
        process = subprocess.Popen([str(BIN / "vdisp-train"), "train", *map(str, self.drives), "--passes", "100000", "--above", "100", "--below", "1", *FRONT,
                                    "-o", str(model)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(1)
        process.send_signal(signal.SIGKILL)
        self.assertEqual(process.wait(), -signal.SIGKILL)
        self.assertEqual(model.read_bytes(), self.model.read_bytes())
        small = self.place / "small"
        small.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(small)], check=True)
        (small / "a.model").write_text("old")
        found = run("vdisp-train", "train", *self.drives, *FRONT, "-o", small / "a.model")
        self.assertEqual(found.returncode, 74, found.stderr)
        self.assertIn("No space left", found.stderr)
        self.assertEqual([path.name for path in small.iterdir()], ["a.model"])
        self.assertEqual((small / "a.model").read_text(), "old")

    # Tune

    def tune(self, *more, drives=None, pairs=60):
        return run("vdisp-train", "tune", *(drives or self.drives), "--table", self.place / "tune.csv", "--size", f"{WIDTH}x{HEIGHT}", "--blocks", "5,9",
                   "--widths", "32", "--confidences", "0.8", "--smooths", "mean", "--encodings", "contour,depth-map", "--thick", "0,0.3",
                   "--hold-out", "0.34", "--pairs", pairs, *more)

    def test_tune_tries_each_with_each_and_goes_on_where_it_was_cut_off(self):
        found = self.tune("--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        trials = json.loads(found.stdout)
        self.assertEqual(len({(t["encoding"], t["block"], t["thick"]) for t in trials}), 8)
        self.assertTrue(all(0.5 < t["obstacle_auc"] <= 1 and abs(t["obstacle_sensitivity"]) < 10 for t in trials), trials)
        table = self.place / "tune.csv"
        whole = table.read_text()
        table.write_text(whole[:whole.rindex(",") - 30])  # in the midst of the last line
        found = self.tune()
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertEqual(sorted(table.read_text().splitlines()), sorted(whole.splitlines()))
        self.assertEqual(len(found.stdout.splitlines()), 9)
        self.assertEqual(found.stderr.count("front end "), 1)
        self.assertEqual(self.tune().stderr, "")

    def test_tune_never_sees_what_train_judges_on(self):
        model = self.place / "held.model"
        found = run("vdisp-train", "train", *self.drives, *FRONT, "--hold-out", 0.34, "-o", model, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        held = [line.split("\t")[2] for line in model.read_bytes()[-2000:].decode(errors="replace").splitlines() if line.startswith("test\t")]
        self.assertEqual(len(held), 2)
        self.assertEqual(self.tune("--trials", 1).returncode, 0)
        before = (self.place / "tune.csv").read_text()
        for folder in held:  # whatever is in them
            shutil.move(folder, folder + ".away")
            shutil.copytree(self.drives[0], folder)
            text = (pathlib.Path(folder) / "recording.json").read_text()
            (pathlib.Path(folder) / "recording.json").write_text(text.replace('"seed": 0', f'"seed": {1000 + len(folder) + held.index(folder)}'))
        try:
            (self.place / "tune.csv").unlink()
            self.assertEqual(self.tune("--trials", 1).returncode, 0)
            self.assertEqual(sorted((self.place / "tune.csv").read_text().splitlines()), sorted(before.splitlines()))
        finally:
            for folder in held:
                shutil.rmtree(folder)
                shutil.move(folder + ".away", folder)

    def test_tune_tries_no_more_front_ends_than_asked(self):
        found = self.tune("--trials", 1, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertEqual(len(json.loads(found.stdout)), 4)

    def test_tune_refuses_the_table_of_other_recordings_and_what_is_no_table(self):
        self.assertEqual(self.tune("--trials", 1).returncode, 0)
        whole = (self.place / "tune.csv").read_bytes()
        found = self.tune("--trials", 1, pairs=50)
        self.assertEqual(found.returncode, 78, found.stderr)
        self.assertIn("is of other recordings", found.stderr)
        self.assertEqual((self.place / "tune.csv").read_bytes(), whole)
        (self.place / "tune.csv").write_text("my shopping list\n")
        self.assertEqual(self.tune().returncode, 78)
        self.assertEqual((self.place / "tune.csv").read_text(), "my shopping list\n")

    # Bad input

    def test_a_missing_partner_is_named(self):
        copy = self.broken(lambda folder: sorted((folder / "right").iterdir())[3].unlink())
        self.refused(66, "right/", "is missing", arguments=[copy, *self.with_[1:]])

    def test_a_damaged_picture_is_named(self):
        def cut(folder):
            path = sorted((folder / "left").iterdir())[3]
            path.write_bytes(path.read_bytes()[:500])
        self.refused(66, "left/", arguments=[self.broken(cut), *self.with_[1:], *FRONT])

    def test_broken_names_and_unknown_labels_are_named(self):
        for old, new, word in (("_forward.png", "_ahead.png", "must be left/"), (",forward,", ",ahead,", "label 'ahead' is unknown"),
                               ("100000000,", "1e8,", "timestamp_ns")):
            def change(folder, old=old, new=new):
                text = (folder / "index.csv").read_text()
                self.assertIn(old, text)
                (folder / "index.csv").write_text(text.replace(old, new))
            self.refused(66, "index.csv", word, arguments=[self.broken(change), *self.with_[1:]])
            shutil.rmtree(self.place / "broken")

    def test_one_class_only_is_refused_with_what_is_missing(self):
        straight = drive(self.place / "straight", 50, 6, ("forward",), WIDTH, HEIGHT)
        turns = drive(self.place / "turns", 51, 6, ("left",), WIDTH, HEIGHT)
        line = self.refused(66, "left and right", "to train with", arguments=[straight, "--hold-out", 0, *FRONT])
        self.assertNotIn("forward and", line)
        self.refused(66, "no pair with label forward and right", arguments=[turns, "--hold-out", 0, *FRONT])
        self.refused(66, "no pair with label right", arguments=[straight, turns, "--hold-out", 0, *FRONT])
        self.refused(66, "held apart", "left and right", arguments=[*self.with_, "--test", straight, *FRONT])
        self.refused(66, "left and right", arguments=[self.model, straight], program_words=("evaluate",))
        self.refused(66, "left and right", arguments=[*self.with_, "--test", straight, "--table", self.place / "t.csv"], program_words=("tune",))

    def test_a_class_that_is_all_dark_is_missed_and_named(self):
        def darken(folder):
            for path in (folder / "left").glob("*_left.png"):
                cv2.imwrite(str(path), numpy.zeros((HEIGHT, WIDTH), numpy.uint8))
        dark = self.broken(darken)
        self.refused(66, "no pair with label left with which the daemon would not be blind", "to train with", arguments=[dark, "--hold-out", 0, *FRONT])
        self.refused(66, "no pair with label left", "held apart", arguments=[*self.with_[1:], "--test", dark, *FRONT])
        self.refused(66, "would be blind with every pair of a class", program_words=("tune",),
                     arguments=[*self.with_[1:], "--test", dark, "--table", self.place / "t.csv", "--trials", 1, *SIZE])

    def test_a_world_of_the_simulator_is_never_on_both_sides(self):
        again = drive(self.place / "again", 2, PAIRS, width=WIDTH, height=HEIGHT)  # the seed of a drive that was trained with
        self.refused(64, "both are of one world (boxes, seed 2)", arguments=[*self.with_, "--test", again, *FRONT])
        self.refused(64, "which is of the same world (boxes, seed 2)", arguments=[self.model, again], program_words=("evaluate",))
        crash = drive(self.place / "crash", 4, PAIRS, width=WIDTH, height=HEIGHT)  # the seed of one that is judged on
        self.refused(64, "both are of one world (boxes, seed 4)", arguments=["--add", crash, "--to", self.model])

    def test_a_configuration_that_is_not_understood_is_named(self):
        wrong = self.broken(lambda folder: (folder / "vdisp.cfg").write_text("[image source]\nbayr = rggb\n"))
        self.refused(66, "vdisp.cfg:2", "bayr", "mosaics", arguments=[wrong, "--hold-out", 0, *FRONT])

    def test_a_classifier_without_both_classes_is_not_judged_and_says_so(self):
        both = drive(self.place / "both", 52, 12, ("forward", "left"), WIDTH, HEIGHT)
        found = run("vdisp-train", "evaluate", self.model, both)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertIn("direction: not judged: no pair of class right", found.stdout)
        self.assertIn("obstacle: AUC", found.stdout)

    def test_obstacle_only_needs_no_direction_and_trains_none(self):
        both = drive(self.place / "both", 53, 16, ("forward", "right"), WIDTH, HEIGHT)
        model = self.place / "obstacle.model"
        found = run("vdisp-train", "train", both, "--test", *self.apart, "--obstacle-only", *FRONT, "-o", model, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        report = json.loads(found.stdout)["encodings"]["depth-map"]
        self.assertGreater(report["obstacle"]["auc"], 0.9)
        self.assertEqual(report["direction"]["auc"], 0.5)
        straight = drive(self.place / "straight", 50, 6, ("forward",), WIDTH, HEIGHT)
        self.refused(66, "left and right", arguments=[straight, "--hold-out", 0, "--obstacle-only", *FRONT])

    def test_an_empty_test_set_is_refused(self):
        empty = write_recording(self.place / "empty", [], WIDTH, HEIGHT, seed=60)
        self.refused(66, "no labelled pair", "held apart", arguments=[*self.with_, "--test", empty, *FRONT])
        self.refused(66, "no labelled pair", arguments=[self.model, empty], program_words=("evaluate",))
        self.refused(66, "1 recording", "none remain", arguments=[self.drives[0]])
        self.refused(66, "no such folder", arguments=[self.place / "nowhere", *self.with_])

    def test_wrong_sizes_are_refused(self):
        def grow(folder):
            path = sorted((folder / "left").iterdir())[2]
            cv2.imwrite(str(path), cv2.resize(cv2.imread(str(path), 0), (200, 120)))
        self.refused(66, "200x120", "160x120", arguments=[self.broken(grow), *self.with_[1:]])
        self.refused(64, "--size", arguments=[*self.with_, "--size", "40x30"])
        self.refused(64, "--width", arguments=[*self.with_, "--width", "40"])
        self.refused(66, "whole number", "160x120", arguments=[*self.with_, "--size", "100x80"])
        self.refused(64, "--block", arguments=[*self.with_, "--block", "8"])

    def test_a_damaged_model_is_refused(self):
        for name, change, word in (("cut", lambda data: data[:5000], "cut off"), ("bit", lambda data: data[:6000000] + b"\x77" + data[6000001:], "damaged"),
                                   ("version", lambda data: data[:8] + b"\x09" + data[9:], "version 9"), ("text", lambda data: b"hello", "no model")):
            path = self.place / name
            path.write_bytes(change(self.model.read_bytes()))
            self.refused(78, word, arguments=[path, *self.apart], program_words=("evaluate",))
            path.unlink()
        self.refused(66, "No such file", arguments=[self.place / "none", *self.apart], program_words=("evaluate",))

    def test_what_cannot_be_written_is_said_before_the_work(self):
        found = run("vdisp-train", "train", *self.with_, "-o", self.place / "no" / "a.model")
        self.assertEqual(found.returncode, 73)
        self.assertIn("there is no folder", found.stderr)
        found = run("vdisp-train", "train", *self.with_, "-o", self.place)
        self.assertEqual(found.returncode, 73)
        self.assertIn("is a folder", found.stderr)

    def test_wrong_usage_is_64(self):
        for arguments in ((), ("teach",), ("train", "-o", "x"), ("train", self.drives[0], "-o", "x", "--alpha", "0.9"),
                          ("train", self.drives[0], "-o", "x", "--beta", "1.1"), ("train", *self.drives, "-o", "x", "--hold-out", 0, "--compare")):
            self.assertEqual(run("vdisp-train", *arguments).returncode, 64, arguments)
        self.assertEqual(run("vdisp-train", "--version").returncode, 0)
        self.assertIn("Exit codes", run("vdisp-train", "--help").stdout)

    def test_a_terminal_sees_a_bar_and_a_file_does_not(self):
        self.assertNotIn("\r", self.trained.stderr)
        ours, theirs = pty.openpty()
        process = subprocess.Popen([str(BIN / "vdisp-train"), "evaluate", str(self.model), *map(str, self.apart)], stdout=subprocess.DEVNULL, stderr=theirs)
        os.close(theirs)
        seen = b""
        try:
            while part := os.read(ours, 1000):
                seen += part
        except OSError:  # the other end is closed
            pass
        self.assertEqual(process.wait(), 0)
        self.assertIn(b"\rfeatures", seen)
        self.assertIn(b"100 %", seen)


if __name__ == "__main__":
    isolated_main()
