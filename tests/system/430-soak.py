#!/usr/bin/python3
"""430: scripts/soak in short: everything on, readers that come, go, hang and die, and what it claims holds; and it tells when a claim does
not. scripts/latency measures what it says.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True

from evaluation.report import Section
from proof import claims
from proof.readers import KINDS, frames_of_dump, not_rising

BIN = pathlib.Path(os.environ.get("VDISP_BIN", "build/release/bin")).resolve()


def programs():
    """Everything that runs: pid, command."""
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            yield int(folder.name), (folder / "cmdline").read_text().split("\0")
        except OSError:
            pass  # ended meanwhile


def parent(pid):
    return int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])


class Claims(unittest.TestCase):
    """What a soak makes of its figures."""

    def setUp(self):
        self.samples = [{"at": float(i), "drops": {}, "memory_kib": 50000, "shared": 1 << 26} for i in range(100)]
        self.hoarders = types.SimpleNamespace(explain=lambda before, after: 40 <= after <= 45)
        health = {"blind_frames": 0, "blind": {}, "no_pair": 0, "map_drops": 0, "inputs": {"odometry": {"accepted": 9, "refused": 0}},
                  "control": {"requests_refused": 0}, "log_lines_lost": 0, "reloads_refused": 2}
        held = {"handles": 18, "threads": 14}
        nobody = types.SimpleNamespace(faults=[], done={"refused": 2})
        self.run_found = types.SimpleNamespace(
            health=health, samples=self.samples, watched=types.SimpleNamespace(samples=self.samples), hoarders=self.hoarders, tuner=nobody, crowd=nobody,
            senders=nobody, paced=True, held_before=held, held_after=dict(held), sockets=["vdisp-0-1-2"], sockets_clean=True,
            steady={"code": 0, "fallen": 0, "refused": 0, "missed": 0}, new_reader=0.02, uncounted=None)

    def failed(self):
        section = Section("soak", "")
        for claim in (claims.losses, claims.held, claims.readers):
            claim(section, self.run_found)
        return [gate["gate"] for gate in section.gates if not gate["passed"]]

    def test_all_hold_where_nothing_is_wrong(self):
        self.assertEqual(self.failed(), [])

    def test_each_loss_fails_the_claim_that_is_about_it(self):
        health = self.run_found.health
        for change, gate in ((lambda: health.update(blind_frames=1, blind={"no_floor": 1}), "no frame was blind"),
                             (lambda: health.update(no_pair=1), "every frame had a pair"),
                             (lambda: health.update(map_drops=1), "no map was dropped"),
                             (lambda: health["inputs"]["odometry"].update(refused=1), "nothing that came in was refused"),
                             (lambda: health["control"].update(requests_refused=1), "no connection and no request was refused"),
                             (lambda: health.update(log_lines_lost=1), "no line of the log was lost"),
                             (lambda: health.update(reloads_refused=3), "files with faults were refused, and no others"),
                             (lambda: self.run_found.held_after.update(handles=19), "as many handles as before the readers"),
                             (lambda: self.run_found.held_after.update(threads=13), "as many threads as before the readers"),
                             (lambda: self.samples[50].update(shared=1 << 27), "shared memory keeps its size"),
                             (lambda: self.run_found.steady.update(fallen=1), "the planner that stayed saw frames in order"),
                             (lambda: self.run_found.steady.update(missed=1), "the planner that stayed missed no frame"),
                             (lambda: setattr(self.run_found, "new_reader", None), "a new reader has a map within 1 s"),
                             (lambda: setattr(self.run_found, "uncounted", "exit code 69: vdispd has ended"), "the probe that counts told the figures to the end"),
                             (lambda: setattr(self.run_found, "sockets_clean", False), "no socket of the dead is left")):
            with self.subTest(gate=gate):
                before = len(self.failed())
                change()
                self.assertIn(gate, self.failed())
                self.assertEqual(len(self.failed()), before + 1)

    def test_memory_may_grow_at_first_and_not_for_ever(self):
        for i, sample in enumerate(self.samples):
            sample["memory_kib"] = 50000 + min(i, 20) * 100
        self.assertEqual(self.failed(), [])
        for i, sample in enumerate(self.samples):
            sample["memory_kib"] = 50000 + i * 30
        self.assertEqual(self.failed(), ["the daemon's memory is flat in the second half"])

    def test_drops_are_allowed_while_a_reader_keeps_all_and_at_no_other_time(self):
        for i, sample in enumerate(self.samples):
            sample["drops"] = {"disparity": 7} if i >= 42 else {}
        self.assertEqual(self.failed(), [])
        self.samples[80]["drops"] = {"disparity": 8}
        self.assertEqual(self.failed(), ["no image was dropped but where a reader kept all"])

    def test_numbers_of_frames_that_fall_or_stay_are_found(self):
        self.assertIsNone(not_rising([1, 2, 5]))
        self.assertEqual(not_rising([1, 5, 5]), "5 after 5")
        self.assertEqual(not_rising([1, 5, 2, 9]), "2 after 5")
        for kind, line in (("planner", b"map 12 (synthetic): no way is free"), ("c", b"frames 1 missed 0 fallen 0 blind 0 unfresh 0 orders 0 refused 0 sequence 12"),
                           ("incremental", b'{"state": "fresh", "sequence": 12, "synthetic": true'), ("map", b'{"state":"fresh","reason":"none","age_s":0.1,"sequence":12,'),
                           ("stats", b'{"state":"running","steps":12,')):
            check = next(known for known in KINDS if known.name == kind).check
            self.assertEqual(check(line + b"\n", None), [12], kind)
        c = next(kind for kind in KINDS if kind.name == "c").check
        lines = b"".join(b"frames %d missed 0 sequence %d\n" % pair for pair in ((0, 0), (3, 12), (3, 12), (5, 9)))
        self.assertEqual(c(lines, None), [12, 9], "a second without a frame is no fault, one that fell is")

    def test_a_frame_that_a_killed_dump_left_half_made_is_none(self):
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            for name, sequence in (("000000", 18), ("000001", 20), (".000002.part", 31)):
                (folder / "dump" / name).mkdir(parents=True)
                (folder / "dump" / name / "frame.json").write_text(json.dumps({"sequence": sequence}))
            self.assertEqual(frames_of_dump(b"", folder), [18, 20])


class Scripts(unittest.TestCase):
    def setUp(self):
        # Not in /tmp: the scripts have a private one, and what they leave is to be seen.
        holder = tempfile.TemporaryDirectory(dir=BIN)
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def script(self, name, *words, timeout=120):
        """The finished script and what it wrote as JSON."""
        file = self.folder / "told.json"
        done = subprocess.run([ROOT / "scripts" / name, "--bin", BIN, "--json", file, *map(str, words)], capture_output=True, text=True, timeout=timeout)
        if done.returncode == 77:
            self.skipTest(done.stderr.strip())
        told = json.loads(file.read_text()) if file.exists() and file.stat().st_size else None
        return done, told

    def test_everything_at_once_holds_and_is_counted(self):
        done, told = self.script("soak", "--minutes", 0.4, "--keep", self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        figures, gates = told["figures"], {gate["gate"]: gate["passed"] for gate in told["gates"]}
        self.assertGreater(len(gates), 20)
        self.assertTrue(all(gates.values()))
        self.assertGreater(figures["frames"], 500)
        self.assertGreater(figures["readers"]["killed"] + figures["readers"]["stopped, killed"], 3)
        self.assertGreater(figures["steady"]["frames"], 400)
        for what in ("set", "undo"):
            self.assertGreater(figures["tuning"][what], 2)
        for kind in ("odometry", "imu", "drive"):
            self.assertGreater(figures["health"]["inputs"][kind]["accepted"], 100)
        self.assertIn("IPLObstacleDetection", (self.folder / "vdispd.log").read_text())
        self.assertGreater(len(json.loads((self.folder / "samples.json").read_text())), 15)
        self.assertFalse(list(pathlib.Path("/tmp").glob("soak-*")), "its folders are its own")

    def begun(self, *words):
        """A soak whose readers come and go, and its daemon."""
        soak = subprocess.Popen([ROOT / "scripts/soak", "--bin", BIN, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(soak.kill)
        self.assertRegex(soak.stderr.readline(), r"^soak: \d+ s, \d+ frames, 0 blind")
        time.sleep(2)
        daemons = [pid for pid, command in programs() if command[0] == str(BIN / "vdispd") and parent(pid) == soak.pid]
        self.assertEqual(len(daemons), 1)
        return soak, daemons[0]

    def test_a_daemon_that_ends_is_said_with_1(self):
        soak, daemon = self.begun("--minutes", "5")
        os.kill(daemon, signal.SIGSEGV)
        output, errors = soak.communicate(timeout=40)
        self.assertEqual(soak.returncode, 1, errors)
        self.assertRegex(output, r"MISSED: the daemon lived.*ended by itself after \d+ s with -11")
        self.assertIn("does not hold: the daemon lived", errors)

    def test_a_soak_that_is_ended_leaves_nobody_behind(self):
        soak, _ = self.begun("--minutes", "5")
        soak.terminate()
        soak.communicate(timeout=40)
        self.assertEqual(soak.returncode, 143)
        self.assertEqual([command for _, command in programs() if command[0].startswith(str(BIN) + "/vdisp")], [])

    def test_wrong_words_are_64_and_a_daemon_that_does_not_start_is_said(self):
        for words, said in ((["soak"], "how long"), (["soak", "1", "--minutes", "2"], "name one"), (["soak", "--minutes", "0.1"], "too short"),
                            (["soak", "1", "--readers", "9"], "1 to 5"), (["latency", "nosuch"], "idle, busy"), (["latency", "--seconds", "1"], "from 2")):
            done, _ = self.script(*words)
            self.assertEqual(done.returncode, 64, done.stderr)
            self.assertIn(said, done.stderr)
        done, _ = self.script("soak", "--minutes", "0.5", "--set", "sim.scene=nosuch")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("sim.scene", done.stderr)

    def test_latency_is_measured_by_the_reader_and_by_the_daemon(self):
        done, told = self.script("latency", "--seconds", 4, "--pairs", 20, "--size", "320x240")
        self.assertEqual(set(told["cases"]), {"idle", "busy"}, done.stderr)
        for name, case in told["cases"].items():
            hands, daemon = case["hands"], case["daemon"]
            self.assertGreater(hands["count"], 20, name)
            self.assertGreater(hands["p50_ms"], 0.9 * daemon["p50_ms"])
            self.assertEqual(sum(bucket["count"] for bucket in hands["histogram"]), hands["count"])
            self.assertEqual(hands["blind"], 0)
            gates = {gate["gate"]: gate["passed"] for gate in case["gates"]}
            self.assertFalse(gates["maps measured"], "too few for p99.9, and that is said")
        self.assertEqual(done.returncode, 1)
        self.assertIn("does not hold: maps measured", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
