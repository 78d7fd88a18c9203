# crowd.py: readers that come, go, hang and die, by a schedule that a seed gives; and what became of each.
# SPDX-License-Identifier: Apache-2.0
import os
import shutil
import signal
import time

from proof.readers import KINDS, not_rising

AGAIN = 5.0  # s in which one that was stopped has to read again
# Of a topic a reader holds two images, and two wait for it: 7 readers, the steady ones counted, leave a map of the 32 that there are.
MOST = 5


class Reader:
    """One life: its end, and a time during which it is stopped."""

    def __init__(self, programs, kind, number, random, longest):
        self.kind, self.name = kind, f"{kind.name} {number}"
        self.folder = programs.work / f"reader{number}"
        self.folder.mkdir()
        self.output = self.folder / "output"
        words = kind.words(random, self.folder)
        short = random.random() < 0.3  # dies or goes while it attaches
        life = random.uniform(0, 0.3) if short else random.uniform(1, 8)
        self.fate = random.choices(["ends", "killed", "stopped", "stopped, killed"], [35, 30, 20, 15])[0]
        pause = random.choices([random.uniform(0.5, 5), random.uniform(5, longest)], [9, 1])[0] if "stopped" in self.fate else 0
        self.started = time.monotonic()
        self.stops = self.started + life if pause else None
        self.goes_on = self.started + life + pause if self.fate == "stopped" else None
        self.ends = self.started + life + pause + (random.uniform(0, 3) if self.goes_on and not kind.streams else 0)
        self.written, self.asked = None, False
        with open(self.output, "wb") as output, open(self.folder / "errors", "wb") as errors:
            self.process = programs.start(*words, output=output, errors=errors)

    def size(self):
        return self.output.stat().st_size

    def send(self, number):
        if self.process.poll() is None:
            os.kill(self.process.pid, number)

    def step(self, now):
        """Does what is due; true when it has ended."""
        if self.stops and now >= self.stops:
            self.send(signal.SIGSTOP)
            self.stops = None
        if self.goes_on and now >= self.goes_on:
            self.written, self.goes_on = self.size(), None
            self.send(signal.SIGCONT)
            self.ends = max(self.ends, now + (AGAIN if self.kind.streams else 0))
        read_again = self.written is not None and self.kind.streams and self.size() > self.written
        if not self.asked and (now >= self.ends or read_again):
            self.asked = True
            self.send(signal.SIGTERM if self.fate in ("ends", "stopped") else signal.SIGKILL)
        if self.asked and now >= self.ends + AGAIN:
            self.send(signal.SIGKILL)  # it was told to go
        return self.process.poll() is not None

    def faults(self):
        """What was wrong with a life that is over. A planner has no handler: SIGTERM ends it, as it would on a rover."""
        output, code = self.output.read_bytes(), self.process.returncode
        output = output[:output.rfind(b"\n") + 1]
        faults = []
        fallen = not_rising(self.kind.check(output, self.folder))
        if fallen:
            faults.append(f"frames out of order, {fallen}")
        good = (-signal.SIGKILL,) if "killed" in self.fate else (-signal.SIGTERM,)
        if code not in (0, *good):
            last = (self.folder / "errors").read_text(errors="replace").strip().splitlines()
            faults.append(f"exit code {code}: {last[-1] if last else 'nothing said'}")
        if self.written is not None and self.kind.streams and self.process.returncode is not None and self.size() <= self.written:
            faults.append(f"read nothing within {AGAIN:.0f} s of SIGCONT")
        return faults


class Crowd:
    """So many readers at a time, stopped for 0.5 to 5 s, one in ten for `longest` s at most. Call step() often."""

    def __init__(self, programs, size, random, longest):
        self.programs, self.size, self.random, self.longest = programs, size, random, longest
        self.readers, self.number, self.next = [], 0, 0.0
        self.began = {kind.name: 0 for kind in KINDS}
        self.fates = {"ends": 0, "killed": 0, "stopped": 0, "stopped, killed": 0}
        self.faults = []

    def step(self):
        now = time.monotonic()
        for reader in [reader for reader in self.readers if reader.step(now)]:
            self.bury(reader)
        if len(self.readers) < self.size and now >= self.next:
            self.add()
            self.next = now + self.random.expovariate(1 / 0.3)

    def add(self):
        alone = any(reader.kind.alone for reader in self.readers)
        kinds = [kind for kind in KINDS if not (alone and kind.alone)]
        kind = self.random.choices(kinds, [kind.weight for kind in kinds])[0]
        self.number += 1
        self.began[kind.name] += 1
        self.readers.append(Reader(self.programs, kind, self.number, self.random, self.longest))

    def bury(self, reader):
        self.readers.remove(reader)
        self.fates[reader.fate] += 1
        self.faults += [f"{reader.name} ({reader.fate}): {fault}" for fault in reader.faults()]
        shutil.rmtree(reader.folder, ignore_errors=True)

    def finish(self):
        """Nobody comes any more; all that are there end as they would have."""
        self.size = 0
        while self.readers:
            self.step()
            time.sleep(0.02)

    def kill(self):
        for reader in self.readers:
            reader.send(signal.SIGKILL)
            reader.process.wait()
