# run.py: one soak: the daemon, two readers that stay, and all that comes and goes around them.
# SPDX-License-Identifier: Apache-2.0
import json
import random
import statistics
import subprocess
import time

from proof.crowd import Crowd
from proof.programs import end, held_by, wait_until
from proof.senders import Hoarders, Senders
from proof.tuner import Tuner
from proof.watched import Watched, sockets

FAVOURED = ["nice", "-n", "-15"]  # the daemon and those who stay: what is proved is the memory, not the scheduler
FOR_EVER = 1000000  # s
SETTLED = 7  # s, until the flight recorder's ring is full and every thread has run
CONFIG = """[main]
detectors = vdisparity, snow
metrics = {work}/vdisp.prom
[image source]
source = sim
[census]
scale = {scale}
[snow]
model = {work}/soak.model
[Map]
minCount = 3
[control]
maxAge = 2
maxSpeed = 100
[recorder]
seconds = 5
memory = 16
folder = {work}/flights
keep = 3
free = 0
[sim]
rate = {rate:g}
width = {width}
height = {height}
"""


class Failed(Exception):
    """What is to be soaked does not even begin."""


class Run:
    """From start() to finish(); then it holds what is claimed and told."""

    def __init__(self, programs, options):
        self.programs, self.options = programs, options
        self.random = random.Random(options.seed)
        self.paced = options.rate > 0
        self.before = FAVOURED if self.paced else []  # as fast as they come, nobody else would get anything
        width, height = map(int, options.size.split("x"))
        self.config = programs.work / "vdisp.cfg"
        self.config.write_text(CONFIG.format(work=programs.work, rate=options.rate, width=width, height=height, scale=width // 320))
        made = programs.run("vdisp-make-model", programs.work / "soak.model")
        if made.returncode:
            raise Failed(made.stderr.strip())

    def start(self):
        self.began = time.monotonic()
        self.watched = Watched(self.programs, self.config, self.options.set, self.before)
        if not self.watched.ready:
            raise Failed("vdispd does not become ready: " + self.watched.said().decode(errors="replace").strip()[-300:])
        self.watched.wait_for(lambda health: True, 5)
        self.held_before = held_by(self.watched.process.pid)
        self.stay()
        self.settle()
        self.crowd = Crowd(self.programs, self.options.readers, self.seeded(), min(75, max(5, self.options.seconds / 10)))
        self.hoarders = Hoarders(self.programs, self.seeded(), min(120, max(8, self.options.seconds / 4)))
        self.tuner = Tuner(self.watched, self.config, self.seeded(), min(3, self.options.seconds / 30))

    def stay(self):
        """Those who stay to the end."""
        self.planner_output = open(self.programs.work / "planner", "w+")
        self.planner = self.programs.start("vdisp-follow-c", FOR_EVER, "orders", output=self.planner_output, before=self.before)
        self.latency = self.programs.start("vdisp-probe", "latency", "--reader", "--seconds", FOR_EVER, "--json", output=-1, before=self.before)
        self.senders = Senders(self.programs, self.seeded())

    def settle(self):
        end_of_settling = time.monotonic() + SETTLED
        while time.monotonic() < end_of_settling:
            self.senders.step()
            time.sleep(0.05)
        if not self.watched.alive() or not self.watched.wait_for(lambda health: health["frames"] > 0, 5):
            raise Failed("vdispd ended, or tells nothing: " + self.watched.said().decode(errors="replace").strip()[-300:])
        self.settled = len(self.watched.samples)

    def seeded(self):
        return random.Random(self.random.random())

    def frames(self):
        health = self.watched.health()
        return health["frames"] if health else 0

    def over(self):
        enough = self.options.frames is not None and self.frames() >= self.options.frames
        return enough or time.monotonic() - self.began >= self.options.seconds or not self.watched.alive() or self.watched.silent() is not None

    def step(self):
        self.crowd.step()
        self.senders.step()
        self.hoarders.step()
        time.sleep(0.02)

    def finish(self):
        """All go, the two that stayed last; a new reader comes; the daemon ends."""
        self.lived = self.watched.alive()
        self.tuner.stop()
        self.hoarders.finish()
        self.crowd.finish()
        self.senders.finish()
        if self.lived:
            self.new_reader = self.attach()
            time.sleep(2.5)  # what was counted is told once a second
            self.health, self.stages = self.watched.health(), self.watched.newest["stages"]
            self.samples = self.watched.samples[self.settled:]
        self.steady, self.hands = self.count_of_planner(), self.count_of_latency()
        if self.lived:
            self.sockets_clean = wait_until(lambda: len(sockets()) <= 1, 3)  # that of the probe that counts
            wait_until(lambda: held_by(self.watched.process.pid)["handles"] <= self.held_before["handles"], 3)  # a reader's is closed after it
            self.sockets, self.held_after = sockets(), held_by(self.watched.process.pid)
        self.seconds, self.uncounted = time.monotonic() - self.began, self.watched.silent()
        self.code = self.watched.stop()
        self.said = self.watched.said().decode(errors="replace")

    def attach(self):
        """How long a new reader takes to a map, s; None where it gets none."""
        begin = time.monotonic()
        try:
            done = self.programs.run("vdisp-planner", "--frames", 1, timeout=5, before=self.before)
        except subprocess.TimeoutExpired:
            return None
        return time.monotonic() - begin if done.returncode == 0 else None

    def count_of_planner(self):
        code = end(self.planner)
        self.planner_output.seek(0)
        fields = self.planner_output.read().splitlines()[-1].split()
        return {"code": code, **dict(zip(fields[::2], map(int, fields[1::2])))}

    def count_of_latency(self):
        self.latency.terminate()
        return json.loads(self.latency.communicate(timeout=10)[0] or "null")

    def rate(self):
        """Frames a second, in the median second."""
        pairs = zip(self.samples, self.samples[1:])
        return statistics.median((after["frames"] - before["frames"]) / (after["at"] - before["at"]) for before, after in pairs)

    def kill(self):
        """When it failed, or was interrupted."""
        for process in [getattr(self, name, None) for name in ("planner", "latency")]:
            if process:
                process.kill()
        for each in ("tuner", "hoarders", "senders"):
            if hasattr(self, each):
                getattr(self, each).stop() if each == "tuner" else getattr(self, each).finish()
        if hasattr(self, "crowd"):
            self.crowd.kill()
        if hasattr(self, "watched"):
            self.watched.stop()
