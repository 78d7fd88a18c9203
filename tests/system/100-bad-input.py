#!/usr/bin/python3
"""100: bad input, the daemon alone: one clear line, the right exit code, nothing half-written.

SPDX-License-Identifier: Apache-2.0
"""
import os
import pty
import subprocess

import cv2

from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

CALIBRATION = """%YAML:1.0
---
image_width: {width}
image_height: 96
P1: !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [ {f}, 0., 80., 0., 0., {f}, 48., 0., 0., 0., 1., 0. ]
P2: !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [ {f}, 0., 80., {tx}, 0., {f}, 48., 0., 0., 0., 1., 0. ]
"""


class BadInput(ProgramTest):
    def test_wrong_usage_is_64(self):
        self.assert_refused(run("vdispd", "--nonsense"), 64, "--nonsense", "--help")
        self.assert_refused(run("vdispd", "--frames", "-3"), 64, "--frames")

    def test_paths_that_are_empty_are_64_and_no_run_without_output(self):
        self.assert_refused(run("vdispd", "--sim", "--dump", ""), 64, "--dump", "empty")
        self.assert_refused(run("vdispd", "--sim", "--dot", ""), 64, "--dot", "empty")

    def test_frames_is_a_whole_number_from_1(self):
        for wrong in ("0", "99999999999999999999", "2.5"):
            self.assert_refused(run("vdispd", "--sim", "--frames", wrong), 64, wrong, "whole number")

    def test_a_configuration_that_cannot_be_printed_is_74(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([BIN / "vdispd", "--print-config"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assert_refused(result, 74, "standard output")

    def test_the_printed_configuration_names_the_pools_and_reads_back(self):
        printed = run("vdispd", "--sim", "--print-config").stdout
        self.assertRegex(printed, "# pool [0-9]+ bytes x [0-9]+ .* map")
        (self.folder / "printed.cfg").write_text(printed)
        self.assertEqual(run("vdispd", "-c", self.folder / "printed.cfg", "--check-config").returncode, 0)

    def test_a_lost_terminal_ends_the_daemon_cleanly(self):
        pid, terminal = pty.fork()
        if pid == 0:
            os.execv(BIN / "vdispd", ["vdispd", "--sim"])
        said = b""
        while b"ready" not in said:
            said += os.read(terminal, 4096)
        os.close(terminal)
        self.assertTrue(wait_until(lambda: os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT), 5))
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), 0)
        self.assertEqual(os.listdir("/dev/shm"), [])

    def test_all_complaints_about_a_configuration_come_at_once_and_it_ends_with_78(self):
        path = self.write_config("[Floor]\niterRansac=99999\nitrRansac=5\n[Map]\nrange=abc\n")
        result = run("vdispd", "-c", path, "--check-config")
        self.assertEqual(result.returncode, 78)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 3, result.stderr)
        self.assertIn("vdisp.cfg:10: iterRansac = 99999", result.stderr)
        self.assertIn("iterRansac", lines[1])
        self.assertIn("vdisp.cfg:13", lines[2])

    def test_a_missing_configuration_is_66(self):
        self.assert_refused(run("vdispd", "-c", self.folder / "none.cfg"), 66, "none.cfg")

    def test_no_camera_is_69_and_names_the_simulator(self):
        self.assert_refused(run("vdispd", "-c", self.write_config(source="auto")), 69, "--sim")

    def test_no_images_are_66(self):
        self.assert_refused(run("vdispd", "-c", self.write_config()), 66, str(self.folder))

    def test_unreadable_calibration_is_78(self):
        self.write_pairs()
        (self.folder / "c.yml").write_text("%YAML:1.0\n---\nP1: [1, 2")
        self.assert_refused(run("vdispd", "-c", self.write_config(f"paramfile={self.folder}/c.yml\n")), 78, "c.yml")
        self.assert_refused(run("vdispd", "-c", self.write_config(f"paramfile={self.folder}/no.yml\n")), 78, "no.yml")

    def test_contradictory_calibration_is_78(self):
        self.write_pairs()
        good = {"width": 160, "f": 100.0, "tx": -9.0}
        for wrong, word in (({"f": -1.0}, "-1"), ({"tx": 0.0}, "baseline"), ({"tx": 9.0}, "baseline"), ({"width": 640}, "640")):
            (self.folder / "c.yml").write_text(CALIBRATION.format(**{**good, **wrong}))
            self.assert_refused(run("vdispd", "-c", self.write_config(f"paramfile={self.folder}/c.yml\n")), 78, word)
        (self.folder / "c.yml").write_text(CALIBRATION.format(**good))
        self.assertEqual(run("vdispd", "-c", self.write_config(f"paramfile={self.folder}/c.yml\n")).returncode, 0)

    def test_images_of_another_size_than_configured_are_78(self):
        self.write_pairs()
        self.assert_refused(run("vdispd", "-c", self.write_config("width=640\nheight=480\n")), 78, "160x96", "640x480")

    def test_more_disparities_than_columns_are_78(self):
        self.write_pairs(width=60)
        self.assert_refused(run("vdispd", "-c", self.write_config(), "--set", "image source.ndisp=64"), 78, "60 columns", "ndisp")

    def test_keys_of_another_matcher_are_78_and_tell_what_fits(self):
        self.write_pairs()
        for matcher, key, value, fits in (("census", "prefilter", "log", "sobel"), ("opencv", "prefilter", "log", "sobel"),
                                          ("bm", "census", "5x5", "3x3"), ("opencv-sgbm", "census", "5x5", "3x3")):
            self.assert_refused(run("vdispd", "-c", self.write_config(), "--set", f"image source.matcher={matcher}", "--set",
                                    f"image source.{key}={value}"), 78, f"{key} = {value}", f"the matcher is {matcher}", f"{key} = {fits}")

    def test_a_bad_pair_is_counted_and_blind_and_the_run_goes_on(self):
        self.write_pairs(6)
        (self.folder / "right" / "000001.png").unlink()
        whole = (self.folder / "left" / "000002.png").read_bytes()
        (self.folder / "left" / "000002.png").write_bytes(whole[: len(whole) // 2])
        cv2.imwrite(str(self.folder / "left" / "000003.png"), cv2.imread(str(self.folder / "left" / "000000.png"))[:50])
        (self.folder / "left" / "000004.png").write_bytes(b"no image at all")
        dump = self.folder / "dump"
        result = run("vdispd", "-c", self.write_config(), "--dump", dump)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("6 steps, 4 blind", result.stderr)
        for i, valid in enumerate((True, False, False, False, False, True)):
            frame = self.frame(dump, i)
            self.assertEqual(frame["stages"]["disparity"]["valid"], valid, i)
            self.assertEqual(frame["sequence"], i)
            if not valid:
                self.assertEqual((frame["valid"], frame["reason"]), (False, "bad_pair"))
                self.assertFalse(frame["stages"]["map"]["valid"])
                self.assertFalse((dump / f"{i:06d}" / "disparity.png").exists())

    def test_a_wrong_mounting_is_said_once_with_what_was_measured(self):
        small = ["main.middleware=none", "image source.source=sim", "sim.scene=flat", "sim.width=320", "sim.height=240", "sim.rate=0",
                 "image source.ndisp=32", "mounting.height=0.8"]
        def said(*sets):
            words = [word for item in [*small, *sets] for word in ("--set", item)]
            return [line for line in run("vdispd", *words, "--frames", 40).stderr.splitlines() if "mounting" in line]
        self.assertEqual(said("sim.imu=yes", "mounting.pitch=0.2618"), [])
        told = said("mounting.height=1.2")
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], "does not agree with .mounting.: measured height 0[.](79|80|81) m .* configured 1.20 m")
        told = said("sim.imu=yes", "mounting.pitch=0.38")
        self.assertEqual(len(told), 2, told)
        self.assertRegex(told[0], "measured .* pitch 0.2[56][0-9] rad, configured .* 0.380 rad")
        self.assertRegex(told[1], "gravity differs from the floor.* over the floor .* pitch 0.2[56].* by the IMU 0.3[78]")

    def test_without_calibration_disparity_and_floor_line_are_given_and_metres_are_blind(self):
        self.write_pairs()
        dump = self.folder / "dump"
        self.assertEqual(run("vdispd", "-c", self.write_config(), "--dump", dump).returncode, 0)
        stages = self.frame(dump, 0)["stages"]
        self.assertTrue(stages["disparity"]["valid"] and stages["vdisparity"]["valid"])
        for stage in ("limit", "height", "map"):
            self.assertFalse(stages[stage]["valid"])

    def test_a_read_only_folder_is_73_and_nothing_is_written(self):
        self.write_pairs()
        os.makedirs(self.folder / "ro")
        subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "none", self.folder / "ro"], check=True)
        self.addCleanup(subprocess.run, ["umount", self.folder / "ro"])
        self.assert_refused(run("vdispd", "-c", self.write_config(), "--dump", self.folder / "ro" / "d"), 73, "ro/d")

    def test_a_full_disk_is_74_and_only_whole_frames_remain(self):
        self.write_pairs(50)
        os.makedirs(self.folder / "small")
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", self.folder / "small"], check=True)
        self.addCleanup(subprocess.run, ["umount", self.folder / "small"])
        dump = self.folder / "small" / "d"
        self.assert_refused(run("vdispd", "-c", self.write_config(), "--dump", dump), 74, "No space left")
        left = sorted(p.name for p in dump.iterdir())
        self.assertGreater(len(left), 1)
        self.assertEqual(left, [f"{i:06d}" for i in range(len(left))])
        for i in range(len(left)):
            self.assertTrue(self.frame(dump, i)["stages"]["disparity"]["valid"])

    def test_a_folder_with_another_run_is_refused(self):
        self.write_pairs()
        config = self.write_config()
        self.assertEqual(run("vdispd", "-c", config, "--dump", self.folder / "d").returncode, 0)
        self.assert_refused(run("vdispd", "-c", config, "--dump", self.folder / "d"), 73, "empty folder")

    def test_a_video_that_ends_ends_the_run_with_0(self):
        size = (320, 96)
        video = cv2.VideoWriter(str(self.folder / "v.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10, size)
        self.write_pairs(4)
        for i in range(4):
            views = [cv2.imread(str(self.folder / side / f"{i:06d}.png")) for side in ("left", "right")]
            video.write(cv2.hconcat(views))
        video.release()
        config = self.folder / "video.cfg"
        config.write_text(f"[main]\nmiddleware=none\n[image source]\nsource=files\nndisp=32\nleft={self.folder}/v.avi\n")
        result = run("vdispd", "-c", config)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("4 steps, 0 blind", result.stderr)

    def test_two_runs_give_the_same_bytes(self):
        self.write_pairs(4)
        config = self.write_config()
        for name in ("a", "b"):
            self.assertEqual(run("vdispd", "-c", config, "--dump", self.folder / name).returncode, 0)
        result = subprocess.run(["diff", "-r", "-x", "timing.json", self.folder / "a", self.folder / "b"], capture_output=True)
        self.assertEqual(result.returncode, 0, result.stdout.decode())

    def test_frames_ends_the_run_after_so_many(self):
        self.write_pairs(5)
        self.assertIn("2 steps", run("vdispd", "-c", self.write_config(), "--frames", 2).stderr)


isolated_main()
