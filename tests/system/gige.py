"""gige.py: GigE cameras that are programs: real packets on the loopback addresses of a network namespace.

SPDX-License-Identifier: Apache-2.0
"""
import shutil
import socket
import struct
import subprocess

import cv2

from programs import BIN, wait_until

LEFT, RIGHT, THIRD = "127.0.0.1", "127.0.0.2", "127.0.0.3"

# Registers of the standard (bootstrap), and of Aravis' own camera.
CONTROL, PACKET_SIZE = 0x0a00, 0x0d04
WIDTH, HEIGHT, GAIN, GAIN_AUTO, EXPOSURE, ACQUISITION, PIXELS, PERIOD = 0x100, 0x104, 0x110, 0x114, 0x120, 0x124, 0x128, 0x138
TRIGGER_MODE, TRIGGER_SOURCE = 0x300, 0x304
CODES = {0x01080001: "gray8", 0x01100007: "gray16", 0x01080009: "rggb", 0x0108000b: "bggr", 0x02180014: "rgb8"}


# A real camera has a processor of its own: where it is permitted these do not wait for one that is busy.
AT_ONCE = ["chrt", "-f", "20"] if subprocess.run(["chrt", "-f", "20", "true"], capture_output=True).returncode == 0 else []


def ask(address, command, payload=b"", limit=0.3):
    """The payload of the answer to a GVCP command, by another program than the camera's master; None: no answer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.settimeout(limit)
        try:
            s.sendto(struct.pack(">BBHHH", 0x42, 0x01, command, len(payload), 7) + payload, (address, 3956))
            return s.recv(2000)[8:]
        except OSError:
            return None


def register(address, where):
    answer = ask(address, 0x80, struct.pack(">I", where))
    return None if answer is None else struct.unpack(">I", answer[:4])[0]


class GigeCamera:
    """With a picture: the stand-in vdisp-gige-camera, which writes the time into its first 64 pixels. Without: Aravis' own, whose every
    pixel is known from column, row and the frame's number. Ends with the test."""

    def __init__(self, test, address, serial, picture=None, lost=0, late_ms=0):
        if picture is None and not shutil.which("arv-fake-gv-camera-0.8"):
            test.skipTest("arv-fake-gv-camera-0.8 is not installed (scripts/setup test)")
        if picture is None:
            self.command = ["arv-fake-gv-camera-0.8", "-i", address, "-s", serial, *(["-r", str(lost)] if lost else [])]
        else:
            name = test.folder / f"{serial}.pgm"
            cv2.imwrite(str(name), picture)
            self.command = [str(BIN / "vdisp-gige-camera"), address, serial, str(name), str(late_ms)]
        self.test, self.address = test, address
        self.start()
        test.addCleanup(self.kill)

    def start(self):
        self.process = subprocess.Popen([*AT_ONCE, *self.command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.test.assertTrue(wait_until(lambda: ask(self.address, 0x02) is not None), f"{self.command} does not answer")

    def kill(self):
        self.process.kill()
        self.process.wait()
