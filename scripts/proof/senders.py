# senders.py: odometry and IMU into the control socket, by senders that are killed and followed by others; and readers that keep all they get.
# SPDX-License-Identifier: Apache-2.0
import time

from proof.programs import end

RATE = {"odometry": 50, "imu": 100}  # Hz
SPEED = 0.5                          # m/s, of the rover in the simulator's scene `drive`


class Senders:
    """One of each kind at a time; every second one is killed."""

    def __init__(self, programs, random):
        self.programs, self.random, self.began = programs, random, time.monotonic()
        self.running = {kind: None for kind in RATE}
        self.started, self.killed, self.faults = 0, 0, []

    def step(self):
        now = time.monotonic()
        for kind, running in self.running.items():
            if running and now >= running[1] and running[0].poll() is None:
                running[0].kill()
                self.killed += 1
            if running and running[0].poll() is None:
                continue
            if running and running[0].returncode not in (0, -9):
                self.faults.append(f"sender of {kind}: exit code {running[0].returncode}: {self.said(kind)}")
            self.running[kind] = self.start(kind, now)

    def start(self, kind, now):
        """The process, and when it is killed. It goes on where the one before should have been: on a busy machine
        that is a step, and the configuration allows fast ones."""
        seconds = self.random.uniform(1, 10)
        count = int(seconds * RATE[kind])
        file = self.programs.work / f"{kind}.csv"
        if kind == "odometry":
            places = (SPEED * (now - self.began + i / RATE[kind]) for i in range(count))
            file.write_text("x,y,yaw,speed,turn_rate\n" + "".join(f"{x:.4f},0,0,{SPEED},0\n" for x in places))
        else:
            file.write_text("ax,ay,az,wx,wy,wz\n" + "0,0,9.81,0,0,0\n" * count)
        self.started += 1
        with open(self.programs.work / f"{kind}.errors", "wb") as errors:
            process = self.programs.start("vdisp-probe", "send", kind, "--file", file, "--rate", RATE[kind], errors=errors)
        return process, now + (seconds * self.random.random() if self.started % 2 else 2 * seconds + 60)

    def said(self, kind):
        return (self.programs.work / f"{kind}.errors").read_text(errors="replace").strip()

    def finish(self):
        for kind, running in self.running.items():
            if running and end(running[0]) not in (0, -9, -15):
                self.faults.append(f"sender of {kind}: exit code {running[0].returncode}: {self.said(kind)}")


class Hoarders:
    """From time to time a reader that never gives an image back takes all blocks of the pool of `disparity`: then images of that pool
    are dropped, and counted; of no other, and not any more when it is gone."""

    LASTS, TOPIC, SUBSCRIPTIONS = 2, "disparity", 30  # two blocks each, of 48

    def __init__(self, programs, random, every):
        self.programs, self.random, self.every = programs, random, every
        self.process, self.next, self.times = None, time.monotonic() + every / 2, []

    def step(self):
        now = time.monotonic()
        if self.process and self.process.poll() is not None:
            self.times[-1][1], self.process = now, None
        if self.process or now < self.next:
            return
        self.next = now + self.every * self.random.uniform(0.7, 1.3)
        self.times.append([now, None])
        self.process = self.programs.start("vdisp-reader", "hold", self.TOPIC, self.SUBSCRIPTIONS, self.LASTS)

    def finish(self):
        if self.process:
            self.process.kill()
            self.process.wait()
            self.times[-1][1] = time.monotonic()

    def explain(self, before, after):
        """True where one was there between two looks, or just before: what it held comes back within 0.3 s of its death, and the daemon
        tells once a second what it counted."""
        return any(begin <= after and (end is None or end + 2.5 >= before) for begin, end in self.times)
