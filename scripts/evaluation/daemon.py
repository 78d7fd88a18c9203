# daemon.py: runs vdispd with --dump, several at once, and reads what it wrote.
# SPDX-License-Identifier: Apache-2.0
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import cv2

from evaluation.report import plain


class Skipped(Exception):
    """A section or a row that cannot be measured here, and why."""


class RunFailed(Exception):
    """The daemon did not end with 0; the text holds the command and its last words."""


class Frame:
    """One frame's folder of a dump."""

    def __init__(self, folder):
        self.folder = folder
        self.json = json.loads((folder / "frame.json").read_text())

    def image(self, stage):
        """The picture of a stage as the dump has it; None where the stage was blind."""
        return cv2.imread(str(self.folder / (stage + ".png")), cv2.IMREAD_UNCHANGED)

    def valid(self, stage):
        return self.json["stages"][stage]["valid"]

    def camera(self, stage):
        return self.json["stages"][stage]["camera"]

    @property
    def floor(self):
        return self.json["floor"]


class Daemon:
    """Makes runs. Dumps are deleted once measured, unless `keep` names a folder for them."""

    def __init__(self, binary, data, keep=None, jobs=2, quick=False):
        self.binary, self.data, self.jobs, self.quick = pathlib.Path(binary), pathlib.Path(data), jobs, quick
        self.keep = pathlib.Path(keep) if keep else None
        self.work = pathlib.Path(tempfile.mkdtemp(prefix="vdisp-evaluate-"))
        self.empty = self.work / "defaults.cfg"  # so that no installed vdisp.cfg has a say
        self.empty.write_text("")
        self.memo = {}
        self.first = None  # seed of the sections kinds... and drive
        self.kinds, self.sets = None, {}  # kinds of scenes asked for (None: all), and parameters for them
        self.peers = self.binary.parent / "vdisp-peers"
        self.model = None  # of the snow detector; None: vdisparity drives
        self.pictures = self.resume = None  # folders for pictures, and for results to go on from
        self.start = time.monotonic()

    def close(self):
        shutil.rmtree(self.work, ignore_errors=True)

    def say(self, text):
        print(f"evaluate: {text}, {time.monotonic() - self.start:.0f} s", file=sys.stderr, flush=True)

    def identity(self):
        """Says which daemon and which scripts these are, so that results of others are not taken for their own."""
        parts = [self.binary] + sorted(self.binary.parent.glob("vdisp_sim.so")) + sorted(pathlib.Path(__file__).parent.glob("*.py"))
        return hashlib.sha256(b"".join(part.read_bytes() for part in parts)).hexdigest()

    def remembered(self, name, settings, work):
        """What work() gives; with --resume kept in a file, and taken from there where daemon and settings are the same."""
        if not self.resume:
            return work()
        path, settings = self.resume / f"{name}.json", plain({"daemon": self.identity(), "settings": settings})
        if path.is_file():
            kept = json.loads(path.read_text())
            if {key: kept[key] for key in settings} == settings:
                self.say(f"{name}: taken from {path}")
                return kept["results"]
        results = plain(work())
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".partial")
        partial.write_text(json.dumps({**settings, "results": results}))
        partial.replace(path)
        return results

    def set_folder(self, *names):
        """A data set's folder; Skipped where it is missing."""
        folder = self.data.joinpath(*names)
        if not folder.exists():
            raise Skipped(f"no {folder}")
        return folder

    @staticmethod
    def options(sets, frames):
        words = []
        for key, value in sets.items():
            words += ["--set", f"{key}={value}"]
        return words + (["--frames", str(frames)] if frames else [])

    def command_line(self, sets, frames=None):
        """As a reader would type it; paths of data sets begin at the project."""
        words = ["vdispd"] + self.options(sets, frames) + ["--dump", "DIR"]
        return " ".join(f"'{w}'" if " " in w else w for w in words).replace(str(self.data), "../shared/data")

    def dump(self, name, sets, frames=None):
        """Runs the daemon; the folder of the dump and its frames' folders in order."""
        folder = (self.keep or self.work) / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.parent.mkdir(parents=True, exist_ok=True)
        sets = {"main.middleware": "none", "main.debug": 0, **sets}
        command = [str(self.binary), "-c", str(self.empty)] + self.options(sets, frames) + ["--dump", str(folder)]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise RunFailed(f"exit {done.returncode}: {done.stderr.strip()[-400:]} ({' '.join(command)})")
        return folder, sorted(p for p in folder.iterdir() if p.is_dir() and p.name.isdigit())

    def run(self, sets, frames, record=None):
        """Runs the daemon without a dump; `record`: a folder for a recording of it."""
        sets = {"main.middleware": "none", "main.debug": 0, **sets}
        command = [str(self.binary), "-c", str(self.empty)] + self.options(sets, frames)
        if record:
            shutil.rmtree(record, ignore_errors=True)
            record.parent.mkdir(parents=True, exist_ok=True)
            command += ["--record", str(record)]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise RunFailed(f"exit {done.returncode}: {done.stderr.strip()[-400:]} ({' '.join(command)})")

    def measure(self, name, sets, frames, look):
        """look(Frame) of each frame of one run."""
        folder, places = self.dump(name, sets, frames)
        if not places:
            raise RunFailed(f"the dump of {name} is empty: {self.command_line(sets, frames)}")
        try:
            return [look(Frame(place)) for place in places]
        finally:
            if not self.keep:
                shutil.rmtree(folder, ignore_errors=True)

    def measure_all(self, title, runs, look):
        """runs: (name, sets, frames). A list of what look() gave, run by run, in order."""
        return self.each(title, runs, lambda run: self.measure(*run, look))

    def each(self, title, runs, work):
        """What work(run) gives for each, in order; several at once."""
        results, start = [None] * len(runs), time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            waiting = {pool.submit(work, run): i for i, run in enumerate(runs)}
            try:
                for done, future in enumerate(concurrent.futures.as_completed(waiting), 1):
                    results[waiting[future]] = future.result()
                    if done % 10 == 0 or done == len(runs):
                        print(f"evaluate: {title}: {done} of {len(runs)} runs, {time.monotonic() - start:.0f} s", file=sys.stderr)
            except BaseException:
                for future in waiting:
                    future.cancel()
                raise
        return results


def build(root, peers=False):
    """Set-up and release build, with vdisp-peers if wanted; the folder of the programs."""
    options = os.environ.get("VDISP_CMAKE_OPTIONS", "") + (" -DVDISP_PEERS=ON" if peers else "")
    for command in (["scripts/setup", "peers" if peers else "evaluate"], ["scripts/build", "release"]):
        code = subprocess.run(command, cwd=root, stdout=sys.stderr, env={**os.environ, "VDISP_CMAKE_OPTIONS": options}).returncode
        if code != 0:
            sys.exit(code)
    return os.path.join(root, "build", "release", "bin")
