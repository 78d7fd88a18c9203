#!/usr/bin/python3
# 220-firewire: vdispd with an STH-MDCS2 that a stand-in for libdc1394 plays: frames through to the map, either byte order, unplugged and back.
# SPDX-License-Identifier: Apache-2.0
"""Nothing here has met FireWire hardware: the stand-in (tests/support/dc1394_standin.cpp) proves our logic alone."""
import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

from programs import BIN

STANDIN = BIN.parent / "tests/unit/libdc1394_standin.so"
COMMON = ["-c", "/dev/null", "--set", "image source.source=dc1394", "--set", "camera.views=turns", "--set", "main.middleware=none"]


class Mdcs2(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.gone = pathlib.Path(self.folder.name) / "gone"

    def environment(self, words):
        return {**os.environ, "LD_PRELOAD": str(STANDIN), "VDISP_STANDIN": words, "VDISP_STANDIN_SIM": str(BIN / "vdisp_sim.so"),
                "VDISP_STANDIN_GONE": str(self.gone), "ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0"}

    def run_daemon(self, words, *more, frames=8):
        dump = pathlib.Path(self.folder.name) / f"dump-{words}"
        done = subprocess.run([BIN / "vdispd", *COMMON, "--frames", str(frames), "--dump", dump, *more], env=self.environment(words),
                              capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        frame = sorted(dump.glob("0*"))[-1]
        return done.stderr, json.loads((frame / "frame.json").read_text()), frame

    def test_frames_come_through_to_the_map_in_either_byte_order_with_the_calibration_of_the_camera(self):
        for words in ("mdcs2,calibration", "mdcs2,calibration,right-first"):
            log, frame, folder = self.run_daemon(words, "--set", "camera.swap=auto", frames=12)
            self.assertIn("calibration (SVS 4.0) from the memory of FireWire camera 0055050000000001", log)
            self.assertIn("opened: 640x480 gray8, both views by turns, 30 Hz", log)
            self.assertIn("exchanged, and put right" if "right-first" in words else "the right way round", log)
            self.assertTrue((folder / "map.png").exists(), sorted(p.name for p in folder.iterdir()))
            self.assertIn(b"found", json.dumps(frame).encode())

    def test_an_unplugged_camera_blinds_with_the_reason_and_comes_back(self):
        daemon = subprocess.Popen([BIN / "vdispd", *COMMON], env=self.environment("mdcs2"), stderr=subprocess.PIPE, text=True)
        try:
            time.sleep(2)
            self.gone.touch()
            time.sleep(2)
            self.gone.unlink()
            time.sleep(3)
            self.assertIsNone(daemon.poll())
        finally:
            daemon.terminate()
            log = daemon.communicate(timeout=20)[1]
        self.assertEqual(daemon.returncode, 0, log)
        self.assertEqual(log.count("frames lost"), 1, log)
        self.assertIn("FireWire camera 0055050000000001: gone from the bus", log)
        self.assertEqual(log.count("frames found"), 1, log)

    def test_without_cameras_it_ends_and_says_what_to_do(self):
        done = subprocess.run([BIN / "vdispd", *COMMON], env=self.environment("none"), capture_output=True, text=True, timeout=30)
        self.assertEqual(done.returncode, 69)
        self.assertIn("on the bus there is none; name what is to be waited for in [camera] left", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
