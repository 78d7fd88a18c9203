"""programs.py: runs the real programs for the system tests, each test in a mount namespace with its own /tmp, /dev/shm and /run.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import cv2
import numpy

BIN = pathlib.Path(os.environ.get("VDISP_BIN", "build/release/bin")).resolve()
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SKIPPED = 77
PATIENCE = float(os.environ.get("VDISP_PATIENCE", "1"))  # how much slower than usual programs are: sanitizers, a busy machine


def isolated_main(network=False):
    """Runs the unit tests of the calling script with private /tmp, /dev/shm and /run: there is one daemon on a machine. With `network`
    also with a network of its own, that has nothing but 127.0.0.1, 127.0.0.2 and 127.0.0.3."""
    if "VDISP_ISOLATED" not in os.environ:
        prepare = "mount -t tmpfs none /dev/shm && mount -t tmpfs none /tmp && mount -t tmpfs none /run"
        if network:
            prepare += " && ip link set lo up && ip addr add 127.0.0.2/8 dev lo && ip addr add 127.0.0.3/8 dev lo"
        unshare = ["unshare", "-m", *(["-n"] if network else []), "sh", "-c"]
        probe = subprocess.run([*unshare, prepare], capture_output=True)
        if probe.returncode:
            print("SKIPPED: a private namespace of", "mounts and network" if network else "mounts", "is not permitted here:",
                  probe.stderr.decode().strip())
            sys.exit(SKIPPED)
        os.environ["VDISP_ISOLATED"] = "1"
        command = [sys.executable, os.path.abspath(sys.argv[0]), *sys.argv[1:]]
        os.execvp("unshare", [*unshare, prepare + ' && exec "$@"', "sh", *command])
    unittest.main(verbosity=2)


def run(program, *arguments, timeout=60, **options):
    """The finished process, with its text output."""
    return subprocess.run([str(BIN / program), *map(str, arguments)], capture_output=True, text=True, timeout=timeout * PATIENCE, **options)


class Running:
    """A program in the background; its stderr goes to a file. Killed at the end of the with block."""

    def __init__(self, program, *arguments, **options):
        self.log = tempfile.NamedTemporaryFile("w+", suffix=".log")
        self.process = subprocess.Popen([str(BIN / program), *map(str, arguments)], stderr=self.log, **options)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()

    def text(self):
        return pathlib.Path(self.log.name).read_text()


def wait_until(condition, limit=10.0):
    """True as soon as the condition holds, False at the limit (s)."""
    end = time.monotonic() + limit * PATIENCE
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.02)
    return False


class ProgramTest(unittest.TestCase):
    """A folder of its own, and pairs whose disparity is known: a random texture seen 7 px apart."""

    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.addCleanup(self.holder.cleanup)
        self.folder = pathlib.Path(self.holder.name)

    def write_pairs(self, count=3, width=160, height=96, name="%06d.png"):
        random = numpy.random.default_rng(1)
        for side in ("left", "right"):
            (self.folder / side).mkdir(exist_ok=True)
        for i in range(count):
            texture = random.integers(0, 255, (height, width + 7), numpy.uint8)
            cv2.imwrite(str(self.folder / "left" / (name % i)), texture[:, :width])
            cv2.imwrite(str(self.folder / "right" / (name % i)), texture[:, 7:])
        return self.folder

    def write_config(self, lines="", source="files", middleware="none"):
        """A configuration for the pairs; `lines` are added at the end."""
        text = f"[main]\nmiddleware={middleware}\ndebug=0\n[image source]\nsource={source}\nndisp=32\n"
        if source == "files":
            text += f"left={self.folder}/left/%06d.png\nright={self.folder}/right/%06d.png\n"
        path = self.folder / "vdisp.cfg"
        path.write_text(text + lines)
        return path

    def frame(self, dump, number):
        return json.loads((dump / f"{number:06d}" / "frame.json").read_text())

    def assert_refused(self, result, code, *words):
        """Ended with this code after one clear line that has all the words."""
        self.assertEqual(result.returncode, code, result.stderr)
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])
