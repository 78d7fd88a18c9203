"""faults.py: what the tests of faults have in common: a small daemon, a reader that misses nothing, and a clock that is stepped.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import re
import struct
import subprocess

from programs import BIN, ProgramTest, Running, run, wait_until


def hasten():
    """Before the others in the queue for the processor, where that is permitted: what is tested is the fault, not the scheduler."""
    try:
        os.nice(-15)
    except OSError:
        pass


def mount(test, place, size="50m"):
    """A small disk of its own there, as long as the test takes."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size},mode=1777", "none", place], check=True)
    test.addCleanup(subprocess.run, ["umount", "-l", place])


class Steady:
    """A reader of every map for so many seconds from now on."""

    def __init__(self, seconds, **options):
        self.seconds = seconds
        self.process = subprocess.Popen([BIN / "vdisp-reader", "count", "map", str(seconds)], stdout=subprocess.PIPE, text=True,
                                        preexec_fn=hasten, **options)

    def missed(self):
        """Frames that it did not see; None: it saw hardly any, or slept through too many."""
        text = self.process.communicate(timeout=self.seconds + 20)[0]
        found = {word: int(number) for word, number in re.findall(r"(\w+) (\d+)", text)}
        awake = found["asleep"] <= found["frames"] / 50
        return found["missed"] if awake and found["frames"] > 15 * self.seconds and found["reconnections"] == 0 else None


class SteppedClock:
    """A wall clock of their own for programs with this environment."""

    def __init__(self, folder):
        self.file = folder / "clock"
        self.seconds = 0
        self.file.write_bytes(bytes(8))
        self.preloaded = {"LD_PRELOAD": str(BIN / "vdisp_stepped_clock.so"), "VDISP_CLOCK": str(self.file)}
        self.environment = {**os.environ, **self.preloaded}

    def step(self, seconds):
        self.set(self.seconds + seconds)

    def set(self, seconds):
        """So far ahead of the true one."""
        self.seconds = seconds
        with open(self.file, "r+b") as file:
            file.write(struct.pack("=q", seconds * 1_000_000_000))


class FaultTest(ProgramTest):
    small = [word for item in ("sim.width=160", "sim.height=120", "image source.ndisp=32", "sim.rate=30") for word in ("--set", item)]

    def start(self, *options, extra_env=None, **named):
        daemon = Running("vdispd", "--sim", *self.small, *options, stdout=subprocess.DEVNULL, preexec_fn=hasten,
                         env={**os.environ, **(extra_env or {})}, **named)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 20), daemon.text())
        self.assertIsNone(daemon.process.poll(), daemon.text())
        return daemon

    def health(self):
        result = run("vdisp-probe", "stats", "--once", "--json", "--wait", "20")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["health"]

    def frames_of_a_new_reader(self, **options):
        """Frames that one who attaches now gets of the five it wants."""
        result = run("vdisp-planner", "--frames", 5, **options)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return 5 if re.search(r"^map \d+", result.stdout, re.M) else result.stdout
