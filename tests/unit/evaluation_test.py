#!/usr/bin/python3
# evaluation_test.py: the arithmetic of scripts/evaluate: cells compared, alarms dated, results gone on from.
# SPDX-License-Identifier: Apache-2.0
import json
import pathlib
import re
import sys
import tempfile
import types
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))
try:
    import numpy as np
    from evaluation import approach, drive, kinds, map_pictures, peer_maps, recorded, snow
    from evaluation.daemon import Daemon
    from evaluation.report import Section
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)


def cells(*marked, shape=(6, 6)):
    mask = np.zeros(shape, bool)
    for cell in marked:
        mask[cell] = True
    return mask


EVERYWHERE = np.ones((6, 6), bool)


class Comparison(unittest.TestCase):
    def test_a_cell_beside_the_true_one_is_right_and_one_two_off_is_wrong(self):
        beside = recorded.shares(recorded.compare_cells(cells((2, 3)), cells((2, 2)), EVERYWHERE))
        self.assertEqual((beside["precision"], beside["recall"]), (1, 1))
        far = recorded.compare_cells(cells((2, 4)), cells((2, 2)), EVERYWHERE)
        self.assertEqual((far["hit"], far["wrong"], far["met"]), (0, 1, 0))

    def test_what_the_truth_has_not_looked_at_is_not_judged(self):
        counts = recorded.compare_cells(cells((5, 5)), cells((0, 0)), EVERYWHERE & ~cells((5, 5)))
        self.assertEqual((counts["hit"], counts["wrong"]), (0, 0))

    def test_a_cell_may_be_right_that_need_not_be_found(self):
        counts = recorded.compare_cells(cells((5, 5)), cells((0, 0)), EVERYWHERE, cells((0, 0), (5, 4)))
        self.assertEqual((counts["hit"], counts["wrong"], counts["true"]), (1, 0, 1))

    def test_frames_are_pooled_before_shares_are_taken(self):
        truth = cells((2, 2)), EVERYWHERE, cells((2, 2))
        looks = [{"truth": truth, "grids": {"ours": cells((2, 2))}}, {"truth": truth, "grids": {"ours": cells((5, 5), (5, 4), (0, 5))}}]
        self.assertEqual(peer_maps.pooled(looks, "ours")["precision"], 0.25)

    def test_a_missed_cell_a_wrong_and_a_right_one_have_their_colours(self):
        picture = map_pictures.judged(cells((0, 0), (5, 5)), cells((0, 1), (3, 3)), EVERYWHERE, cells((0, 1), (3, 3)))
        self.assertEqual([tuple(picture[c]) for c in ((0, 0), (5, 5), (3, 3), (2, 0))],
                         [map_pictures.RIGHT, map_pictures.WRONG, map_pictures.MISSED, map_pictures.OBSERVED])


class Approach(unittest.TestCase):
    camera = {"f": 500.0, "cx": 320.0}

    def grid(self, ahead, right):
        return approach.GRID.mask(np.array([right]), np.array([ahead]))

    def test_range_is_of_the_nearest_cell_among_the_columns(self):
        both = self.grid(2.05, 0.0) | self.grid(1.45, 0.02)
        self.assertAlmostEqual(approach.box_range(both, (310, 330), self.camera), 1.45)

    def test_what_stands_beside_the_columns_has_no_range(self):
        self.assertIsNone(approach.box_range(self.grid(1.05, 0.8), (310, 330), self.camera))

    def test_alarm_is_for_what_is_near_and_in_the_way(self):
        self.assertTrue(approach.alarmed(self.grid(0.75, 0.1)))
        self.assertFalse(approach.alarmed(self.grid(0.85, 0.1)))
        self.assertFalse(approach.alarmed(self.grid(0.75, 0.6)))

    def test_lateness_is_of_the_alarm_that_is_the_boards(self):
        self.assertEqual(approach.lateness([3, 98, 99, 100, 101, 102, 103, 104], [99, 100, 101, 102]), (-1, 2, 1))
        self.assertEqual(approach.lateness([], [99, 100]), (None, None, 0))


class Ways(unittest.TestCase):
    def test_collisions_and_metres_are_read_from_the_track_and_the_way_is_drawn(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "world.csv").write_text("what,corners\nwall,2,-1,2.2,-1,2.2,1,2,1\nglass,0,3,1,3,1,3.02,0,3.02\n")
            head = "time_s,x,y,yaw,speed,turn_rate,steering,expert,clearance,travelled,collision,stuck,met\n"
            line = "{},{},0,0,{},0,{},forward,{},{},{},0,{}\n"
            (folder / "track.csv").write_text(head + line.format(0, 0, 0, "forward", 1.8, 0, 0, "") + line.format(0.1, 1, 0.5, "turn_left", 0.8, 1, 0, "")
                                              + line.format(0.2, 1.8, 0, "forward", 0, 1.8, 1, "wall"))
            way = drive.Way(folder)
            found = way.numbers()
            self.assertEqual((found["collisions"], found["met"], found["stuck"], found["metres"]), (1, "1 wall", 0, 1.8))
            self.assertAlmostEqual(found["turning"], 1 / 3)
            way.picture(folder / "way.png")
            picture = drive.cv2.imread(str(folder / "way.png")).astype(int)
            red = (picture[..., 2] > 200) & (picture[..., 1] < 60)
            self.assertGreater(red.sum(), 100)
            self.assertGreater(np.nonzero(red)[1].mean(), picture.shape[1] * 0.7)  # at the wall, which is on the right

    def test_test_worlds_have_odd_seeds(self):
        seeds = {drive.world_sets(scene, n, 0.3)["sim.seed"] % 2 for scene in drive.SCENES for n in range(12)}
        self.assertEqual(seeds, {1})

    def test_other_seeds_can_be_asked_for(self):
        self.assertEqual([drive.world_sets("office", n, 0.3, first=902)["sim.seed"] for n in range(3)], [902, 904, 906])
        asked = types.SimpleNamespace(first=301, quick=True)
        self.assertEqual(list(kinds.seeds_of(asked)), list(range(301, 309)))
        asked.first = None
        self.assertEqual(list(kinds.seeds_of(asked)), list(range(1, 9)))

    def test_light_is_from_dim_to_glaring(self):
        lights = {drive.world_sets(scene, n, 0.3)["sim.light"] for scene in drive.SCENES for n in range(4)}
        self.assertLessEqual(min(lights), 0.3)
        self.assertGreaterEqual(max(lights), 3)  # as the table of parameters has it

    def test_the_snow_detector_is_shown_views_of_the_size_it_was_trained_with(self):
        sets = {**drive.world_sets("office", 0, 0.3), **drive.detector_sets("some.model")}
        self.assertEqual((sets["sim.width"] // sets["census.scale"], sets["sim.height"] // sets["census.scale"]), (320, 240))
        self.assertTrue(sets["snow.model"].is_absolute())  # a relative one would begin at the folder of the configuration
        self.assertEqual(drive.detector_sets(None), {})


class Indoor(unittest.TestCase):
    def test_the_halves_of_the_drive_have_no_frame_in_common_and_a_gap(self):
        approach_half, retreat_half = snow.HALVES.values()
        self.assertGreater(retreat_half.start - approach_half.stop, 3)


class Snow(unittest.TestCase):
    """The section with stand-ins for both programs: what is run, and what is told of it."""

    def setUp(self):
        self.ran = []
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        (pathlib.Path(folder.name) / "vdispd").write_text("")
        self.daemon = Daemon(pathlib.Path(folder.name) / "vdispd", "nowhere")
        self.addCleanup(self.daemon.close)
        self.auc = {"depth-map": (0.985, 0.93), "disparity-map": (0.97, 0.97), "contour": (0.9, 0.96), "contour-height": (0.9, 0.99)}
        before = snow.call
        self.addCleanup(setattr, snow, "call", before)
        snow.call = self.call

    def call(self, _, program, *words):
        self.ran.append(" ".join([pathlib.Path(program).name, *map(str, words)]).replace(f"{self.daemon.work}/", ""))
        if pathlib.Path(program).name == "record-worlds":
            return "garage-2: 5 forward\noffice-6: 5 left\n10 pairs\n"
        part = {"drives": 2, "forward": 5, "left": 5, "right": 0, "blind": 3}
        return json.dumps({"trained_with": part, "held_apart": part,
                           "encodings": {name: {"obstacle": {"auc": a}, "direction": {"auc": b}} for name, (a, b) in self.auc.items()}})

    def test_gates_are_of_one_encoding(self):
        section = Section("snow", "")
        snow.snow_section(self.daemon, section)
        passed = {gate["gate"]: gate["passed"] for gate in section.gates}
        self.assertTrue(passed["obstacle classifier, depth-map"])
        self.assertFalse(passed["direction classifier, depth-map"])  # others are better: a model has one encoding

    def test_blind_pairs_are_told_and_every_command_is_printed(self):
        section = Section("snow", "")
        snow.snow_section(self.daemon, section)
        self.assertIn("of these blind", section.text())
        self.assertEqual([row["of these blind"] for row in section.tables[1][2]], [3, 3])
        printed = [command.replace("scripts/", "") for command in section.commands]
        for ran in self.ran:  # but for where programs and models lie
            ran = re.sub(r" --bin \S+ --jobs \d+| --json", "", ran)
            ran = re.sub(r"(snow-\w+)/garage-2 snow-\w+/office-6", r"\1/*", ran).replace("snow/snow.model", "snow.model")
            ran = re.sub(r"--plots \S+", "--plots PLOTS", ran)
            self.assertIn(sorted(ran.split()), [sorted(command.split()) for command in printed])


class Resume(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        (pathlib.Path(self.folder.name) / "vdispd").write_text("one")
        self.daemon = Daemon(pathlib.Path(self.folder.name) / "vdispd", "nowhere")
        self.addCleanup(self.daemon.close)
        self.daemon.resume = pathlib.Path(self.folder.name) / "results"
        self.runs = 0

    def work(self):
        self.runs += 1
        return [{"edge": (1, 2), "number": np.float32(0.5)}]

    def test_the_same_is_not_run_twice_and_reads_the_same(self):
        first = self.daemon.remembered("kind", [("a", {"b": 1}, 4)], self.work)
        self.assertEqual(self.daemon.remembered("kind", [("a", {"b": 1}, 4)], self.work), first)
        self.assertEqual(self.runs, 1)

    def test_other_settings_and_another_daemon_are_run(self):
        self.daemon.remembered("kind", [1], self.work)
        self.daemon.remembered("kind", [2], self.work)
        (pathlib.Path(self.folder.name) / "vdispd").write_text("two")
        self.daemon.remembered("kind", [2], self.work)
        self.assertEqual(self.runs, 3)

    def test_without_a_folder_nothing_is_kept(self):
        self.daemon.resume = None
        self.daemon.remembered("kind", [1], self.work)
        self.daemon.remembered("kind", [1], self.work)
        self.assertEqual(self.runs, 2)


if __name__ == "__main__":
    unittest.main()
