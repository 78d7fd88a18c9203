# watched.py: a daemon under watch: each second what it counts, and what the kernel says it holds.
# SPDX-License-Identifier: Apache-2.0
import json
import os
import pathlib
import threading
import time

from proof.programs import end, held_by, wait_until


def shared_bytes():
    """All that lies in /dev/shm."""
    found = os.statvfs("/dev/shm")
    return (found.f_blocks - found.f_bfree) * found.f_frsize


def sockets():
    """Of readers, in /tmp: iceoryx answers there."""
    return [name for name in os.listdir("/tmp") if name.startswith("vdisp-")]


class Watched:
    """vdispd with a configuration, and vdisp-probe stats beside it for as long as it runs."""

    def __init__(self, programs, config, sets=(), before=(), first=30):
        self.programs = programs
        self.log = open(programs.work / "vdispd.log", "wb")
        self.process = programs.start("vdispd", "-c", config, *(word for text in sets for word in ("--set", text)), errors=self.log, before=before)
        self.samples, self.newest, self.stats = [], None, None
        self.ready = wait_until(lambda: b"ready: " in self.said() or self.process.poll() is not None, first) and self.alive()
        if self.ready:
            with open(programs.work / "stats.errors", "wb") as errors:
                self.stats = programs.start("vdisp-probe", "stats", "--json", output=-1, errors=errors, before=before)
            self.thread = threading.Thread(target=self._watch, daemon=True)
            self.thread.start()

    def said(self):
        return pathlib.Path(self.log.name).read_bytes()

    def alive(self):
        return self.process.poll() is None

    def silent(self):
        """Why nothing is counted any more; None while it is. Figures that stand still hide what is lost."""
        if self.stats.poll() is None and self.thread.is_alive():
            return None
        words = (self.programs.work / "stats.errors").read_text(errors="replace").strip()
        return f"exit code {self.stats.poll()}: {words[-200:] or 'nothing said'}"

    def _watch(self):
        for line in self.stats.stdout:
            told = json.loads(line)
            if not told["health"] or told["state"] != "running":
                continue
            try:
                held = held_by(self.process.pid)
            except OSError:
                return  # it has ended
            drops = {stage["stage"]: stage["drops"] for stage in told["stages"] if stage["drops"]}
            self.newest = told
            self.samples.append({"at": time.monotonic(), "frames": told["health"]["frames"], "drops": drops, "shared": shared_bytes(), **held})

    def health(self):
        """The newest; None before the first."""
        return self.newest["health"] if self.newest else None

    def wait_for(self, good, limit):
        """True as soon as the newest health is good."""
        return wait_until(lambda: self.newest is not None and good(self.newest["health"]), limit)

    def stop(self):
        """The exit code of the daemon, None where it had to be killed. The probe ends first."""
        if self.stats:
            end(self.stats)
            self.thread.join(5)
        code = end(self.process)
        self.log.close()
        return code
