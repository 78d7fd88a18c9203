#!/usr/bin/python3
"""130: vdisp-calibrate: formats there and back, calibrations from boards, and faults that were put in are named with their fix.

SPDX-License-Identifier: Apache-2.0
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import time
import unittest

import cv2
import numpy

from programs import BIN, ROOT, ProgramTest, Running, isolated_main, run, wait_until

DATA = ROOT.parent / "shared/data"
WIDTH, HEIGHT, F, BASELINE = 480, 360, 400.0, 0.1
CAMERA_HEIGHT, PITCH = 0.6, 0.35
BOARD_SQUARE = 0.05


def matrix(name, rows, cols, numbers):
    return f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {', '.join(str(float(n)) for n in numbers)} ]\n"


def rectified_text(baseline=BASELINE, f=F):
    p = [f, 0, WIDTH / 2, 0, 0, f, HEIGHT / 2, 0, 0, 0, 1, 0]
    right = list(p)
    right[3] = -f * baseline
    return f"%YAML:1.0\n---\nimage_width: {WIDTH}\nimage_height: {HEIGHT}\n" + matrix("P1", 3, 4, p) + matrix("P2", 3, 4, right)


def raw_text(rotation=numpy.eye(3)):
    """The same cameras before rectification, the right one turned by `rotation`."""
    k = [F, 0, WIDTH / 2, 0, F, HEIGHT / 2, 0, 0, 1]
    text = f"%YAML:1.0\n---\nimage_width: {WIDTH}\nimage_height: {HEIGHT}\n"
    for i in (1, 2):
        text += matrix(f"M{i}", 3, 3, k) + matrix(f"D{i}", 1, 5, [0] * 5)
    return text + matrix("R", 3, 3, rotation.ravel()) + matrix("T", 3, 1, rotation @ [-BASELINE, 0, 0])


def turned(image, axis, degrees):
    """What the camera sees when it is turned about an axis."""
    k = numpy.array([[F, 0, WIDTH / 2], [0, F, HEIGHT / 2], [0, 0, 1]])
    vector = numpy.zeros(3)
    vector[axis] = math.radians(degrees)
    rotation, _ = cv2.Rodrigues(vector)
    return cv2.warpPerspective(image, k @ rotation @ numpy.linalg.inv(k), (WIDTH, HEIGHT), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


class Scene:
    """Textured flat ground, a wall behind it and a board that faces the camera, seen by ray casting: truth by construction."""

    def __init__(self, seed):
        random = numpy.random.default_rng(seed)
        texture = sum(cv2.resize(random.random((n, n)), (2048, 2048), interpolation=cv2.INTER_CUBIC) for n in (256, 512, 1024))
        self.texture = cv2.normalize(texture, None, 20, 235, cv2.NORM_MINMAX).astype(numpy.float32)

    def view(self, x):
        """From x m to the right of the left camera; three rays across each pixel."""
        fine = 3
        u, v = numpy.meshgrid((numpy.arange(WIDTH * fine) + 0.5) / fine - 0.5, (numpy.arange(HEIGHT * fine) + 0.5) / fine - 0.5)
        rx, ry = (u - WIDTH / 2) / F, (v - HEIGHT / 2) / F
        down = ry * math.cos(PITCH) + math.sin(PITCH)
        ahead = math.cos(PITCH) - ry * math.sin(PITCH)
        ground = numpy.where(down > 1e-3, CAMERA_HEIGHT / numpy.maximum(down, 1e-3), 1e9)
        wall = 5 / ahead
        z = numpy.minimum(ground, wall)
        px, ph, pv = x + rx * z, ahead * z, down * z
        cells = 90  # texels a metre
        across = (px * cells + 1024).astype(numpy.float32) % 2040
        along = (numpy.where(ground < wall, ph, 10 + pv) * cells).astype(numpy.float32) % 2040
        image = cv2.remap(self.texture, across, along, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        board = 1.3 - ph * 0  # m along the view: the board is parallel to the image
        bx, by = (x + rx * board) / BOARD_SQUARE + 4, (ry * board) / BOARD_SQUARE + 6
        inside = (bx > -2) & (bx < 10) & (by > -2) & (by < 7)
        black = ((numpy.floor(bx) + numpy.floor(by)).astype(int) & 1 == 0) & (bx > -1) & (bx < 9) & (by > -1) & (by < 6)
        image = numpy.where(inside & (board < z), numpy.where(black, 30, 230), image)
        return cv2.resize(image.astype(numpy.float32), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).round().astype(numpy.uint8)


VIEWS = [(Scene(seed).view(0), Scene(seed).view(BASELINE)) for seed in (1, 2)]
BOARD = ["--board", "9x6", "--square", str(BOARD_SQUARE)]


class Formats(ProgramTest):
    def test_there_and_back_through_every_format(self):
        start = self.folder / "start.yml"
        rotation, _ = cv2.Rodrigues(numpy.array([0.01, -0.02, 0.03]))
        start.write_text(raw_text(rotation))
        first = json.loads(run("vdisp-calibrate", "show", start, "--json").stdout)
        before = start
        for name in ("a.ini", "pair", "b.yml", "other", "c.ini", "d.yml"):
            self.assertEqual(run("vdisp-calibrate", "convert", before, self.folder / name).returncode, 0, name)
            before = self.folder / name
        last = json.loads(run("vdisp-calibrate", "show", before, "--json").stdout)
        for side in ("left", "right"):
            for key, numbers in first[side].items():
                numpy.testing.assert_allclose(last[side][key], numbers, rtol=1e-9, atol=1e-9, err_msg=side + key)
        numpy.testing.assert_allclose(last["rotation"], rotation.ravel(), atol=1e-9)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["a.ini", "b.yml", "c.ini", "d.yml", "other", "pair", "start.yml"])

    def test_show_tells_people_the_baseline(self):
        path = self.folder / "c.yml"
        path.write_text(rectified_text())
        self.assertIn("baseline    100.000 mm", run("vdisp-calibrate", "show", path).stdout)

    def test_kitti_text_needs_the_size_for_ros_and_takes_it(self):
        path = self.folder / "calib.txt"
        p = "7.2e+02 0 6.0e+02 {} 0 7.2e+02 1.7e+02 0 0 0 1 0\n"
        path.write_text("P0: " + p.format(0) + "P1: " + p.format(-360))
        self.assert_refused(run("vdisp-calibrate", "convert", path, self.folder / "ros"), 78, "image size", "--size")
        self.assertEqual(run("vdisp-calibrate", "convert", path, self.folder / "ros", "--size", "1242x375").returncode, 0)
        self.assertEqual(json.loads(run("vdisp-calibrate", "show", self.folder / "ros", "--json").stdout)["width"], 1242)

    def test_bad_input_is_one_line_and_nothing_is_written(self):
        good = rectified_text()
        out = self.folder / "out.ini"
        out.write_text("as it was")
        for name, text, words in (("cut", good[: good.index("P2") + 60], ("P2",)),
                                  ("nan", good.replace("-40.0", ".nan"), ("P2", "finite")),
                                  ("exchanged", rectified_text(-BASELINE), ("left and right exchanged",)),
                                  ("old", "# SVS Engine v 1.9\n", ("too old", "2.1")),
                                  ("other", "hello\n", ("no known format",)),
                                  ("nothing", "", ("empty",))):
            path = self.folder / (name + ".txt")
            path.write_text(text)
            self.assert_refused(run("vdisp-calibrate", "convert", path, out), 78, str(path), *words)
            self.assertEqual(out.read_text(), "as it was")
        self.assertFalse([p for p in self.folder.iterdir() if p.name.startswith(".")])

    def test_places_that_cannot_be_written_are_73_and_wrong_words_64(self):
        path = self.folder / "c.yml"
        path.write_text(rectified_text())
        self.assert_refused(run("vdisp-calibrate", "convert", path, self.folder / "no/such/out.ini"), 73, "no/such")
        self.assert_refused(run("vdisp-calibrate", "convert", path, self.folder / "out.xyz"), 64, ".xyz")
        self.assert_refused(run("vdisp-calibrate", "mend", path), 64, "mend")
        self.assert_refused(run("vdisp-calibrate"), 64, "subcommand")
        self.assert_refused(run("vdisp-calibrate", "show", self.folder / "none.yml"), 66, "none.yml")


class Solve(ProgramTest):
    def solve(self, name, *options):
        if not (DATA / "calib_boards" / name).is_dir():
            self.skipTest(f"no {DATA}/calib_boards/{name}")
        where = DATA / "calib_boards" / name
        return run("vdisp-calibrate", "solve", where / "left*.jpg", where / "right*.jpg", "--board", "9x6", "--square", "0.025", *options, timeout=120)

    def test_real_boards_are_solved_as_well_as_by_an_established_calibrator(self):
        for name, most in (("opencvdoc", 0.23), ("sourishg", 0.26)):
            result = self.solve(name, "--json", "-o", self.folder / "c.ini", "--report", self.folder / "r.png")
            self.assertEqual(result.returncode, 0, result.stderr)
            found = json.loads(result.stdout)
            self.assertLessEqual(found["rms_px"], most, name)
            self.assertLess(found["rows_median_px"], 0.25, name)
            self.assertGreaterEqual(sum(view["used"] for view in found["views"]), len(found["views"]) - 2)
            shown = json.loads(run("vdisp-calibrate", "show", self.folder / "c.ini", "--json").stdout)
            self.assertAlmostEqual(shown["view"]["baseline_m"], found["baseline_m"], 6)
            self.assertGreater(cv2.imread(str(self.folder / "r.png")).std(), 10)

    def test_a_table_that_cannot_be_written_is_74_and_the_calibration_is_there(self):
        where = DATA / "calib_boards/opencvdoc"
        if not where.is_dir():
            self.skipTest(f"no {where}")
        with open("/dev/full", "w") as full:
            result = subprocess.run([BIN / "vdisp-calibrate", "solve", where / "left*.jpg", where / "right*.jpg", *BOARD, "-o", self.folder / "c.yml"],
                                    stdout=full, stderr=subprocess.PIPE, text=True, timeout=120)
        self.assert_refused(result, 74, "standard output cannot be written")
        self.assertTrue((self.folder / "c.yml").exists())

    def test_exchanged_views_are_told(self):
        where = DATA / "calib_boards/opencvdoc"
        if not where.is_dir():
            self.skipTest(f"no {where}")
        result = run("vdisp-calibrate", "solve", where / "right*.jpg", where / "left*.jpg", *BOARD, "-o", self.folder / "c.yml")
        self.assertEqual(result.returncode, 78)
        self.assertIn("exchanged", result.stderr.splitlines()[-1])
        self.assertFalse((self.folder / "c.yml").exists())

    def test_what_is_no_board_is_refused_with_the_number_of_views(self):
        self.write_pairs(count=3)
        result = self.solve_here()
        self.assert_refused(result, 66, "in 0 of 3 pairs, needed are 5")
        self.assertEqual(result.stdout.count("no board found in either view"), 3)
        self.assertFalse((self.folder / "c.yml").exists())

    def solve_here(self):
        return run("vdisp-calibrate", "solve", self.folder / "left", self.folder / "right", "--board", "9x6", "--square", "0.03", "-o", self.folder / "c.yml")

    def test_no_images_are_66_and_no_board_size_is_64(self):
        self.assert_refused(run("vdisp-calibrate", "solve", self.folder / "a*.png", self.folder / "b*.png", *BOARD), 66, "a*.png")
        self.assert_refused(run("vdisp-calibrate", "solve", self.folder / "a", self.folder / "b"), 64, "--board")


class Check(ProgramTest):
    def check(self, left=None, right=None, calibration=None, config="", options=()):
        """Findings by name, the exit code and the output, for the views of the scene or what a function makes of them."""
        for side, change in (("left", left), ("right", right)):
            (self.folder / side).mkdir(exist_ok=True)
            for i, views in enumerate(VIEWS):
                image = views[0] if side == "left" else views[1]
                cv2.imwrite(str(self.folder / side / f"{i}.png"), change(image) if change else image)
        (self.folder / "c.yml").write_text(calibration or rectified_text())
        (self.folder / "vdisp.cfg").write_text(config or self.config())
        result = run("vdisp-calibrate", "check", self.folder / "left", self.folder / "right", "-c", self.folder / "vdisp.cfg", "--json", *options, timeout=120)
        self.assertIn(result.returncode, (0, 78), result.stderr)
        report = json.loads(result.stdout)
        return {finding["name"]: finding for finding in report["findings"]}, result.returncode

    @staticmethod
    def config(angle=PITCH, height=CAMERA_HEIGHT):
        return f"[image source]\nparamfile=c.yml\nndisp=80\n[mounting]\nheight={height}\n[Limit obstacle]\nangRot={angle}\n[Map]\nangRot={angle}\n"

    def faults(self, findings):
        return sorted(name for name, finding in findings.items() if finding["verdict"] == "FAULT")

    def test_a_good_set_is_fine_and_its_camera_is_measured(self):
        findings, code = self.check(options=BOARD)
        self.assertEqual(self.faults(findings), [])
        self.assertEqual(code, 0)
        self.assertLess(findings["rows"]["value"], 0.2)
        self.assertAlmostEqual(findings["height"]["value"], CAMERA_HEIGHT, delta=0.02 * CAMERA_HEIGHT)
        self.assertAlmostEqual(findings["pitch"]["value"], PITCH, delta=0.01)
        self.assertAlmostEqual(findings["scale"]["value"], 1, delta=0.01)
        for name in ("blind", "at_1_m", "at_2_m", "at_3_m", "at_5_m"):
            self.assertIn(name, findings)
        # Z^2 / (f B) by a quarter of a pixel.
        self.assertAlmostEqual(findings["at_5_m"]["value"], 25 / (F * BASELINE) / 4, delta=1e-6)

    def test_exchanged_cameras(self):
        other = [(b, a) for a, b in VIEWS]
        VIEWS[:], before = other, list(VIEWS)
        try:
            findings, code = self.check()
        finally:
            VIEWS[:] = before
        self.assertEqual((self.faults(findings), code), (["order"], 78))
        self.assertIn("exchange left and right", findings["order"]["fix"])

    def test_two_pixels_of_vertical_shift(self):
        shift = lambda image: numpy.roll(image, 2, axis=0)
        findings, code = self.check(right=shift)
        self.assertEqual((self.faults(findings), code), (["rows", "shift"], 78))
        self.assertAlmostEqual(findings["shift"]["value"], 2, delta=0.1)
        self.assertIn("vdisp-calibrate solve", findings["shift"]["fix"])

    def test_half_a_degree_of_rotation_about_the_view(self):
        for sign in (1, -1):
            findings, code = self.check(right=lambda image: turned(image, 2, 0.5 * sign))
            self.assertIn("rotation", self.faults(findings))
            self.assertEqual(code, 78)
            self.assertAlmostEqual(findings["rotation"]["value"], 0.5 * sign, delta=0.05)
            self.assertIn("vdisp-calibrate solve", findings["rotation"]["fix"])

    def test_half_a_degree_of_rotation_about_x_is_a_shift_of_as_many_rows(self):
        findings, _ = self.check(right=lambda image: turned(image, 0, 0.5))
        self.assertIn("shift", self.faults(findings))
        self.assertAlmostEqual(findings["shift"]["value"], -F * math.tan(math.radians(0.5)), delta=0.15)
        self.assertRegex(findings["shift"]["text"], r"turned by 0\.(49|50|51) deg about x")
        self.assertEqual(findings["size"]["verdict"], "fine")

    def test_half_a_degree_of_rotation_about_the_upright(self):
        findings, _ = self.check(right=lambda image: turned(image, 1, 0.5))
        self.assertNotEqual(findings["yaw"]["verdict"], "fine")
        self.assertAlmostEqual(findings["yaw"]["value"], 0.5, delta=0.1)

    def test_a_wrong_calibration_of_how_the_right_camera_is_turned(self):
        vector = numpy.array([0, 0, math.radians(0.5)])
        findings, _ = self.check(calibration=raw_text(cv2.Rodrigues(vector)[0]))
        self.assertIn("rotation", self.faults(findings))
        self.assertAlmostEqual(abs(findings["rotation"]["value"]), 0.5, delta=0.05)

    def test_a_wrong_angle(self):
        findings, code = self.check(config=self.config(angle=0.1))
        self.assertEqual((self.faults(findings), code), (["pitch"], 78))
        self.assertRegex(findings["pitch"]["fix"], r"angRot = 0\.3[45]")

    def test_a_wrong_baseline_by_the_floor_and_by_the_board(self):
        findings, _ = self.check(calibration=rectified_text(1.12 * BASELINE))
        self.assertEqual(self.faults(findings), ["height"])
        self.assertIn("baseline is wrong", findings["height"]["fix"])
        findings, _ = self.check(calibration=rectified_text(1.12 * BASELINE), options=BOARD)
        self.assertEqual(self.faults(findings), ["height", "scale"])
        self.assertAlmostEqual(findings["scale"]["value"], 1.12, delta=0.01)
        self.assertRegex(findings["scale"]["fix"], r"(99|100)\.\d mm instead of 112\.0")

    def test_a_wrong_height_is_told_from_a_wrong_baseline_by_the_board(self):
        findings, _ = self.check(config=self.config(height=0.52), options=BOARD)
        self.assertEqual(self.faults(findings), ["height"])
        self.assertRegex(findings["height"]["fix"], r"\[mounting\] height = 0\.(59|60)")

    def test_no_texture_is_not_to_be_told(self):
        grey = numpy.full((HEIGHT, WIDTH), 128, numpy.uint8)
        for side in ("left", "right"):
            (self.folder / side).mkdir()
            cv2.imwrite(str(self.folder / side / "0.png"), grey)
        (self.folder / "c.yml").write_text(rectified_text())
        result = run("vdisp-calibrate", "check", self.folder / "left", self.folder / "right", "--calibration", self.folder / "c.yml")
        self.assertEqual(result.returncode, 66, result.stdout + result.stderr)
        self.assertIn("not to be told", result.stdout)

    def test_bad_input(self):
        self.write_pairs()
        left, right = self.folder / "left", self.folder / "right"
        (self.folder / "c.yml").write_text(rectified_text())
        self.assert_refused(run("vdisp-calibrate", "check", left, right, "--calibration", self.folder / "c.yml"), 78, "160x96", f"{WIDTH}x{HEIGHT}")
        self.assert_refused(run("vdisp-calibrate", "check", left, right, "--set", "Floor.nonsense=1"), 78, "nonsense")
        self.assert_refused(run("vdisp-calibrate", "check", self.folder, right), 66, "no images in this folder")


class CheckOfTheRunningDaemon(ProgramTest):
    """The same scene, and what a function makes of the right views, as the daemon's cameras."""

    def check(self, right=None, calibration=None, options=(), sets=(), name="c.yml"):
        for side in (0, 1):
            folder = self.folder / ("left", "right")[side]
            folder.mkdir(exist_ok=True)
            for i, views in enumerate(VIEWS):
                cv2.imwrite(str(folder / f"{i:06d}.png"), right(views[side]) if right and side else views[side])
        (self.folder / name).write_text(calibration or rectified_text())
        config = self.write_config(f"ndisp=80\nparamfile='{name}'\nrate=10\nloop=yes\n[mounting]\nheight={CAMERA_HEIGHT}\n[Limit obstacle]\n"
                                   f"angRot={PITCH}\n[Map]\nangRot={PITCH}\n", middleware="shm")
        config.write_text(config.read_text().replace("ndisp=32\n", "").replace("debug=0", "debug=1"))
        with Running("vdispd", "-c", config, *sets) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 20), daemon.text())
            result = run("vdisp-calibrate", "check", "--pairs", "4", "--seconds", "2", "--json", *options, timeout=120)
        self.assertIn(result.returncode, (0, 78), result.stderr + daemon.text())
        report = json.loads(result.stdout)
        self.assertGreaterEqual(report["pairs"], 2)
        return {finding["name"]: finding for finding in report["findings"]}, result.returncode

    def faults(self, findings):
        return sorted(name for name, finding in findings.items() if finding["verdict"] == "FAULT")

    def test_a_good_one_is_fine_and_measured_by_what_the_daemon_is_set_to(self):
        findings, code = self.check(options=BOARD)
        self.assertEqual((self.faults(findings), code), ([], 0))
        self.assertEqual(findings["height"]["verdict"], "fine")
        self.assertAlmostEqual(findings["height"]["value"], CAMERA_HEIGHT, delta=0.02 * CAMERA_HEIGHT)
        self.assertAlmostEqual(findings["pitch"]["value"], PITCH, delta=0.01)
        self.assertAlmostEqual(findings["scale"]["value"], 1, delta=0.01)
        self.assertIn("at_5_m", findings)

    def test_a_calibration_whose_name_would_mean_something_in_a_line_of_the_configuration_is_found(self):
        findings, code = self.check(name="rover $UNSET #2.yml")
        self.assertEqual((self.faults(findings), code), ([], 0))

    def test_a_shift_a_rotation_and_a_wrong_angle_are_named(self):
        findings, code = self.check(right=lambda image: numpy.roll(image, 2, axis=0))
        self.assertEqual((self.faults(findings), code), (["rows", "shift"], 78))
        self.assertAlmostEqual(findings["shift"]["value"], 2, delta=0.1)
        findings, _ = self.check(calibration=raw_text(cv2.Rodrigues(numpy.array([0, 0, math.radians(0.5)]))[0]))
        self.assertIn("rotation", self.faults(findings))
        self.assertAlmostEqual(abs(findings["rotation"]["value"]), 0.5, delta=0.05)
        findings, _ = self.check(sets=("--set", "Limit obstacle.angRot=0.1", "--set", "Map.angRot=0.1"))
        self.assertEqual(self.faults(findings), ["pitch"])

    def test_exchanged_views_are_told_and_another_calibration_can_be_tried(self):
        VIEWS[:] = [(b, a) for a, b in VIEWS]
        try:
            findings, code = self.check()
        finally:
            VIEWS[:] = [(b, a) for a, b in VIEWS]
        self.assertEqual((self.faults(findings), code), (["order"], 78))
        (self.folder / "wrong.yml").write_text(rectified_text(1.12 * BASELINE))
        findings, _ = self.check(options=["--calibration", self.folder / "wrong.yml", *BOARD])
        self.assertIn("scale", self.faults(findings))

    def test_without_a_daemon_it_is_69_and_with_one_view_64(self):
        self.assert_refused(run("vdisp-calibrate", "check"), 69, "vdispd")
        self.assert_refused(run("vdisp-calibrate", "check", self.folder), 64, "RIGHT")


class Capture(ProgramTest):
    """A board before cameras that the daemon reads: every pose for three frames, at rest."""

    POSES = [(x, y, z, across, down) for z, spread, tilt in ((0.75, 0.9, 0.0), (0.9, 1.0, 0.55)) for x, y, across, down in (
        (0, 0, 0.0, 0.0), (-0.23, -0.17, tilt, 0.2), (0.23, -0.17, -tilt, 0.2), (-0.23, 0.17, tilt, -0.3), (0.23, 0.17, -tilt, -0.3), (0, 0.17, 0.0, -tilt),
        (0, -0.17, 0.0, tilt), (-0.23, 0, tilt, 0), (0.23, 0, -tilt, 0)) for x, y in ((x * spread * z / 0.75, y * spread * z / 0.75),)]

    @staticmethod
    def views(pose):
        x, y, z, across, down = pose
        rotation = cv2.Rodrigues(numpy.array([0, across, 0.0]))[0] @ cv2.Rodrigues(numpy.array([down, 0, 0.0]))[0]
        square, fine, scale = 0.03, 40, 3
        u, v = numpy.meshgrid((numpy.arange(12 * fine) + 0.5) / fine, (numpy.arange(9 * fine) + 0.5) / fine)
        inside = (u > 1) & (u < 11) & (v > 1) & (v < 8)
        board = numpy.where(inside & ((numpy.floor(u) + numpy.floor(v)).astype(int) & 1 == 0), 30, 230).astype(numpy.uint8)
        pair = []
        for side in (0, 1):
            shift = numpy.array([x + BASELINE / 2 - side * BASELINE, y, z])
            k = numpy.array([[F * scale, 0, (WIDTH / 2 + 0.5) * scale - 0.5], [0, F * scale, (HEIGHT / 2 + 0.5) * scale - 0.5], [0, 0, 1]])
            # Texel to place on the board, to camera, to pixel of an image three times as large.
            place = numpy.array([[square / fine, 0, (0.5 / fine - 6) * square], [0, square / fine, (0.5 / fine - 4.5) * square], [0, 0, 1]])
            pose_matrix = numpy.column_stack([rotation[:, 0], rotation[:, 1], shift])
            large = cv2.warpPerspective(board, k @ pose_matrix @ place, (WIDTH * scale, HEIGHT * scale), flags=cv2.INTER_LINEAR, borderValue=110)
            pair.append(cv2.GaussianBlur(cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA), (0, 0), 0.6))
        return pair

    def test_takes_views_by_itself_that_solve_to_the_cameras(self):
        for side in ("left", "right"):
            (self.folder / side).mkdir()
        number = 0
        for pose in self.POSES:
            left, right = self.views(pose)
            for _ in range(3):
                cv2.imwrite(str(self.folder / "left" / f"{number:06d}.png"), left)
                cv2.imwrite(str(self.folder / "right" / f"{number:06d}.png"), right)
                number += 1
        config = self.write_config("rate=6\nloop=yes\n", middleware="shm")
        taken = self.folder / "taken"
        with Running("vdispd", "-c", config, "--set", "main.debug=1") as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 20), daemon.text())
            result = run("vdisp-calibrate", "capture", taken, "--board", "9x6", "--square", "0.03", "--views", "12", "--seconds", "40", timeout=90)
        self.assertEqual(result.returncode, 0, result.stderr)
        names = sorted(path.name for path in (taken / "left").iterdir())
        self.assertGreaterEqual(len(names), 12, result.stdout)
        self.assertEqual(names, sorted(path.name for path in (taken / "right").iterdir()))
        self.assertEqual(result.stdout.count(" taken"), len(names))
        if "complete: " in result.stdout:
            self.assertIn("--board 9x6 --square 0.03 -o rover.yml", result.stdout)
        solved = run("vdisp-calibrate", "solve", taken / "left", taken / "right", "--board", "9x6", "--square", "0.03", "--json")
        found = json.loads(solved.stdout)
        self.assertAlmostEqual(found["baseline_m"], BASELINE, delta=0.01 * BASELINE)
        for f in found["fx"]:
            self.assertAlmostEqual(f, F, delta=0.01 * F)

    def test_views_are_numbered_on_behind_the_last_one_whatever_gaps_are_before_it(self):
        for side, view in zip(("left", "right"), self.views(self.POSES[0])):
            (self.folder / side).mkdir()
            cv2.imwrite(str(self.folder / side / "000000.png"), view)
        taken = self.folder / "taken"
        for side, numbers in (("left", (0, 1, 3)), ("right", (0, 1, 3, 4))):  # 2 was bad; of 4 one half is left
            (taken / side).mkdir(parents=True)
            for number in numbers:
                (taken / side / f"{number:06d}.png").write_bytes(b"an earlier capture's")
            (taken / side / "notes.txt").write_text("also here")
        config = self.write_config("rate=6\nloop=yes\n", middleware="shm")
        with Running("vdispd", "-c", config, "--set", "main.debug=1") as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 20), daemon.text())
            result = run("vdisp-calibrate", "capture", taken, "--board", "9x6", "--square", "0.03", "--seconds", "4", timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("000005.png taken", result.stdout)
        self.assertEqual(sorted(path.name for path in (taken / "left").glob("*.png")), [f"{i:06d}.png" for i in (0, 1, 3, 5)])

    def screen(self):
        """What Xvfb shows: its framebuffer is a file in the format of xwd."""
        data = (self.folder / "Xvfb_screen0").read_bytes()
        header = numpy.frombuffer(data, ">u4", 25)
        size, width, height, line, colours = (int(header[i]) for i in (0, 4, 5, 12, 19))
        rows = numpy.frombuffer(data, numpy.uint8, line * height, size + 12 * colours).reshape(height, line)
        return rows[:, : 4 * width].reshape(height, width, 4)[:, :, :3].copy()

    def test_a_window_shows_what_is_taken_and_its_keys_take_undo_and_quit(self):
        if not (shutil.which("Xvfb") and shutil.which("xdotool")):
            self.skipTest("needs Xvfb and xdotool")
        read, write = os.pipe()
        server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1100x760x24", "-nolisten", "tcp", "-noreset", "-fbdir", str(self.folder)],
                                  pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        os.close(write)
        with os.fdopen(read) as number:
            display = {**os.environ, "DISPLAY": ":" + number.readline().strip()}

        def do(*words):
            return subprocess.run(words, env=display, capture_output=True, text=True).stdout.strip()

        for side, view in zip(("left", "right"), self.views(self.POSES[0])):
            (self.folder / side).mkdir()
            cv2.imwrite(str(self.folder / side / "000000.png"), view)
        config = self.write_config("rate=6\nloop=yes\n", middleware="shm")
        taken = self.folder / "taken"
        pairs = lambda: len(list((taken / "right").glob("*.png"))) if (taken / "right").is_dir() else 0
        with Running("vdispd", "-c", config, "--set", "main.debug=1") as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 20), daemon.text())
            with Running("vdisp-calibrate", "capture", taken, "--board", "9x6", "--square", "0.03", "--window", "--seconds", "60", env=display,
                         stdout=subprocess.DEVNULL) as capture:
                self.assertTrue(wait_until(lambda: pairs() == 1, 15), capture.text())  # by itself, and the same pose no second time
                do("xdotool", "windowfocus", "--sync", do("xdotool", "search", "--name", "vdisp-calibrate capture").split()[0])
                do("xdotool", "key", "space")
                self.assertTrue(wait_until(lambda: pairs() == 2, 10), capture.text())
                time.sleep(1)
                screen = self.screen()
                for left in (1, 0):
                    do("xdotool", "key", "u")
                    self.assertTrue(wait_until(lambda: pairs() <= left, 10), f"{pairs()}; {capture.text()}")
                do("xdotool", "key", "q")
                self.assertEqual(capture.process.wait(10), 0, capture.text())
        self.assertGreater(int((screen == (255, 220, 80)).all(axis=2).sum()), 200)  # the board that was found, over the views
        if "VDISP_KEEP_SCREEN" in os.environ:
            cv2.imwrite(os.environ["VDISP_KEEP_SCREEN"], screen)

    def test_without_a_display_the_window_is_69_and_the_terminal_is_named(self):
        plain = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")}
        words = ("vdisp-calibrate", "capture", self.folder / "taken", "--board", "9x6", "--square", "0.03", "--window")
        self.assert_refused(run(*words, env=plain), 69, "DISPLAY", "--window", "terminal")

    def test_without_a_daemon_it_is_69(self):
        self.assert_refused(run("vdisp-calibrate", "capture", self.folder / "taken", "--board", "9x6", "--square", "0.03"), 69, "vdispd")


class RealSets(ProgramTest):
    def check(self, left, right, calibration, *sets):
        for path in (left, right, calibration):
            if not (DATA / path).exists():
                self.skipTest(f"no {DATA / path}")
        words = [word for text in sets for word in ("--set", text)]
        result = run("vdisp-calibrate", "check", DATA / left, DATA / right, "--calibration", DATA / calibration, "--json", *words, timeout=120)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return {finding["name"]: finding.get("value") for finding in json.loads(result.stdout)["findings"]}

    def test_rover_minnie_raw_is_fine_and_1_67_m_high(self):
        found = self.check("rover_minnie/raw/left", "rover_minnie/raw/right", "rover_minnie/raw/calibration_opencv.yml", "mounting.height=1.67",
                           "mounting.pitch=0.616", "image source.ndisp=192")
        self.assertAlmostEqual(found["height"], 1.67, delta=0.02 * 1.67)

    def test_rover_minnie_rectified_is_fine(self):
        self.check("rover_minnie/rectified/left", "rover_minnie/rectified/right", "rover_minnie/rectified/calibration.yml")

    def test_euroc_rows_agree(self):
        self.assertLess(self.check("euroc/mav0/cam0/data", "euroc/mav0/cam1/data", "euroc")["rows"], 0.5)

    def test_kitti_is_fine(self):
        found = self.check("kitti_street/left", "kitti_street/right", "kitti_street/calibration.yml", "mounting.height=1.65", "mounting.pitch=0",
                           "image source.ndisp=96")
        self.assertAlmostEqual(found["height"], 1.65, delta=0.05 * 1.65)

    def test_robot_indoor_is_fine(self):
        self.check("robot_indoor/robotL.mp4", "robot_indoor/robotR.mp4", "robot_indoor/calibration.yml", "mounting.height=0.28", "mounting.pitch=-0.017")

    def test_euroc_exchanged_is_told_though_its_rectification_hides_it(self):
        if not (DATA / "euroc").exists():
            self.skipTest(f"no {DATA}/euroc")
        result = run("vdisp-calibrate", "check", DATA / "euroc/mav0/cam1/data", DATA / "euroc/mav0/cam0/data", "--calibration", DATA / "euroc")
        self.assertEqual(result.returncode, 78)
        self.assertIn("the views are exchanged", result.stdout)


if __name__ == "__main__":
    isolated_main()
