# tuner.py: parameters set and taken back, vdisp.cfg changed, broken and mended, and the flight recorder asked, while the daemon runs.
# SPDX-License-Identifier: Apache-2.0
import os
import signal
import threading

from proof.programs import wait_until

# What leaves the map as it is, all in all: no frame may become blind by it.
LIVE = {"image source.thresh": (8, 14), "image source.unique": (8, 14), "image source.SpeckleSize": (60, 200), "Map.minCount": (3, 9),
        "Memory.keep": (5, 60), "decide.near": (1, 2), "control.maxAge": (2, 4), "recorder.keep": (2, 5), "main.debug": (1, 2)}
LIMIT = 10  # s, for the daemon to have done what was asked


class Tuner:
    """A thread. `pause`: mean s between two changes."""

    def __init__(self, watched, config, random, pause):
        self.watched, self.programs, self.config, self.random, self.pause = watched, watched.programs, config, random, pause
        self.text = config.read_text()
        self.done = {word: 0 for word in ("set", "undo", "reload", "refused", "flight")}
        self.faults = []
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        works = [self.set_and_undo] * 6 + [self.change_file, self.hang_up, self.break_file, self.dump_flight]
        while not self.over.wait(self.random.expovariate(1 / self.pause)):
            try:
                self.random.choice(works)()
            except Exception as error:
                self.faults.append(f"{type(error).__name__}: {error}")

    def stop(self):
        self.over.set()
        self.thread.join(6 * LIMIT)

    def value(self, key):
        told = self.programs.json("vdisp-probe", "get", key, "--json", timeout=LIMIT)
        return float(told["value"]) if told else None

    def expect(self, key, wanted, what):
        if not wait_until(lambda: self.value(key) == wanted, LIMIT):
            self.faults.append(f"{what}: {key} is {self.value(key)}, not {wanted}")

    def set_and_undo(self):
        key = self.random.choice(list(LIVE))
        before, wanted = self.value(key), self.random.randint(*LIVE[key])
        for word, words, after in (("set", (key, wanted), wanted), ("undo", (), before)):
            done = self.programs.run("vdisp-probe", word, *words, timeout=LIMIT)
            self.done[word] += 1
            if done.returncode:
                self.faults.append(f"{word} {key} {wanted}: exit code {done.returncode}: {done.stderr.strip()}")
            self.expect(key, after, word)
            self.over.wait(0.2)

    def write(self, text):
        """As an editor does: another file takes the old one's place."""
        new = self.config.with_suffix(".new")
        new.write_text(text)
        os.replace(new, self.config)

    def change_file(self):
        for count in (self.random.randint(4, 9), 3):
            self.write(self.text.replace("minCount = 3", f"minCount = {count}"))
            self.expect("Map.minCount", count, "a changed file")
            self.done["reload"] += 1

    def counted(self, key, before, what):
        if not self.watched.wait_for(lambda health: health[key] > before, LIMIT):
            self.faults.append(f"{what}: {key} is still {before}")

    def hang_up(self):
        before = self.watched.health()["reloads"]
        os.kill(self.watched.process.pid, signal.SIGHUP)
        self.counted("reloads", before, "SIGHUP")
        self.done["reload"] += 1

    def break_file(self):
        before = self.watched.health()["reloads_refused"]
        self.write(self.text + "\n[Map]\nminCount = none\nnosuch = 1\n")
        self.counted("reloads_refused", before, "a file with faults")
        self.done["refused"] += 1
        self.write(self.text)
        self.expect("Map.minCount", 3, "a file that was mended")

    def dump_flight(self):
        done = self.programs.run("vdisp-probe", "dump-flight", timeout=60)
        self.done["flight"] += 1
        if done.returncode:
            self.faults.append(f"dump-flight: exit code {done.returncode}: {done.stderr.strip()}")
