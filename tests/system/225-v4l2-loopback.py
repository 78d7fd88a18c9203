#!/usr/bin/python3
"""225: vdispd reads a real Video4Linux2 device: a loopback device of the kernel (v4l2loopback), into which the test writes both views side by
side. Skipped where the kernel has none: modprobe v4l2loopback makes one.

SPDX-License-Identifier: Apache-2.0
"""
import fcntl
import os
import pathlib
import struct
import sys
import threading
import time

import cv2
import numpy

from programs import SKIPPED, ProgramTest, Running, isolated_main, run, wait_until

SIZE = (320, 240)  # of one view
QUERYCAP, S_FMT = 0x80685600, 0xC0D05605
OUTPUT, FIELD_NONE, YUYV = 2, 1, struct.unpack("<I", b"YUYV")[0]


def loopbacks():
    """Devices of the driver v4l2loopback."""
    found = []
    for path in sorted(pathlib.Path("/dev").glob("video*")):
        try:
            with open(path, "rb", buffering=0) as device:
                answer = bytearray(104)
                fcntl.ioctl(device, QUERYCAP, answer)
        except OSError:
            continue
        if bytes(answer[:16]).split(b"\0")[0] == b"v4l2 loopback":
            found.append(path)
    return found


class Writer:
    """Writes a frame with both views 30 times a second, until it ends. The first four pixels of each view tell its number."""

    def __init__(self, path, views):
        self.device = os.open(path, os.O_RDWR)
        pix = struct.pack("<8I", 2 * SIZE[0], SIZE[1], YUYV, FIELD_NONE, 4 * SIZE[0], 4 * SIZE[0] * SIZE[1], 8, 0)
        fcntl.ioctl(self.device, S_FMT, bytearray(struct.pack("<II", OUTPUT, 0) + pix.ljust(200, b"\0")))
        self.frame = numpy.full((SIZE[1], 2 * SIZE[0], 2), 128, numpy.uint8)
        self.frame[:, :, 0] = numpy.hstack(views)
        self.running = True
        self.thread = threading.Thread(target=self.write)
        self.thread.start()

    def write(self):
        number = 0
        while self.running:
            number += 1
            for first in (0, SIZE[0]):
                self.frame[0, first:first + 4, 0] = number % 200 + 20
            os.write(self.device, self.frame.tobytes())
            time.sleep(1 / 30)

    def end(self):
        self.running = False
        self.thread.join()
        os.close(self.device)


class Loopback(ProgramTest):
    def setUp(self):
        super().setUp()
        texture = numpy.random.default_rng(1).integers(20, 230, (SIZE[1], SIZE[0] + 7), numpy.uint8)
        self.views = [texture[:, :SIZE[0]].copy(), texture[:, 7:].copy()]
        self.path = loopbacks()[0]
        self.sets = [word for text in ("image source.source=v4l2", "camera.views=beside", f"camera.left={self.path}", f"image source.width={SIZE[0]}",
                                       f"image source.height={SIZE[1]}", "image source.ndisp=32", "main.middleware=none") for word in ("--set", text)]

    def test_what_is_written_into_the_device_comes_out_of_it_pixel_by_pixel(self):
        writer = Writer(self.path, self.views)
        self.addCleanup(writer.end)
        dump = self.folder / "dump"
        result = run("vdispd", *self.sets, "--frames", 30, "--dump", dump)
        self.assertEqual(result.returncode, 0, result.stderr)
        seen, last = 0, 0
        for folder in sorted(dump.iterdir()):
            told = self.frame(dump, int(folder.name))
            if not told["valid"]:
                continue
            seen += 1
            self.assertGreater(told["timestamp_ns"], last)
            last = told["timestamp_ns"]
            pictures = [cv2.imread(str(folder / "camera" / f"{side}.png"), cv2.IMREAD_UNCHANGED) for side in ("left", "right")]
            self.assertEqual(pictures[0][0, 0], pictures[1][0, 0])  # of one frame
            for picture, view in zip(pictures, self.views):
                numpy.testing.assert_array_equal(picture[1:], view[1:])
        self.assertGreater(seen, 20)

    def test_a_device_that_falls_silent_blinds_and_is_seen_again(self):
        writer = Writer(self.path, self.views)
        with Running("vdispd", *self.sets, "--set", "main.debug=1") as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 15), daemon.text())
            writer.end()
            self.assertTrue(wait_until(lambda: "frames lost" in daemon.text(), 5), daemon.text())
            writer = Writer(self.path, self.views)
            self.addCleanup(writer.end)
            self.assertTrue(wait_until(lambda: "frames found" in daemon.text(), 10), daemon.text())
            self.assertIsNone(daemon.process.poll())


if __name__ == "__main__":
    if not loopbacks():
        print("SKIPPED: no loopback device of Video4Linux2 here; modprobe v4l2loopback makes one")
        sys.exit(SKIPPED)
    isolated_main()
