"""recordings.py: what the tests of recordings share: how one is made, read, fed, replayed and compared.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import hashlib
import json
import subprocess
import threading
import time

from programs import BIN, ProgramTest, Running, run, wait_until

SMALL = {"sim.width": 320, "sim.height": 240, "image source.ndisp": 32, "sim.rate": 30}
NOT_OF_THE_FRAME = ("truth/", "camera/status")  # a replay has no truth and no cameras


def sets(*more, **named):
    values = {**SMALL, **dict(item.split("=", 1) for item in more)}
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def counted_from_the_first(told, first):
    """What never goes back in a daemon's life counts on where a recording begins, and from the start in a replay: told from the first frame on.
    `first` belongs to one dump."""
    for name in ("map_changes", "fused_changes"):
        if name in told:
            told[name]["generation"] -= first.setdefault(name, told[name]["generation"])
    if "memory" in told:
        told["memory"]["forgotten"] -= first.setdefault("memory", told["memory"]["forgotten"])
    for track in told.get("tracks", {}).get("tracks", []):
        track["id"] -= first.setdefault("tracks", track["id"])


def hashed(frame, first):
    """A hash for each stage of a dumped frame, and the members of frame.json that tell of it."""
    found = {}
    for path in sorted(frame.rglob("*")):
        name = str(path.relative_to(frame))
        if path.is_dir() or name == "timing.json" or name.startswith(NOT_OF_THE_FRAME):
            continue
        if name != "frame.json":
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
            continue
        told = json.loads(path.read_text())
        told["files"] = told["truth_scene"] = told["camera_status"] = told["synthetic"] = None
        for part in ("stages", "rejected"):
            told[part] = {key: value for key, value in told[part].items() if not key.startswith(NOT_OF_THE_FRAME)}
        counted_from_the_first(told, first)
        found["frame.json"] = json.dumps(told, sort_keys=True)
    return found


class RecordingTest(ProgramTest):
    def index(self, folder):
        with open(folder / "index.csv") as file:
            return list(csv.DictReader(file))

    def inputs(self, folder):
        with open(folder / "inputs.csv") as file:
            return list(csv.DictReader(file))

    def replay(self, recording, dump, *options):
        result = run("vdisp-probe", "replay", recording, "--", "--dump", dump, "--set", "main.middleware=none", *options, timeout=200)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def assert_same_stages(self, live, again, least, first=0):
        """Every frame of the dump `again` equals that of `live` with the same sequence."""
        frames = {json.loads((path / "frame.json").read_text())["sequence"]: path for path in live.iterdir()}
        seen, of_live, of_again = 0, {}, {}
        for path in sorted(again.iterdir()):
            sequence = json.loads((path / "frame.json").read_text())["sequence"]
            a, b = hashed(frames[sequence], of_live), hashed(path, of_again)
            self.assertEqual(sorted(a), sorted(b), sequence)
            for name in a:
                self.assertEqual(a[name], b[name], f"frame {sequence}: {name}")
            seen += 1
        self.assertGreaterEqual(seen, least)
        return seen

    def end(self, sender):
        try:
            sender.stdin.close()
        except OSError:  # the daemon was gone before
            pass
        sender.terminate()  # by itself it would wait for another daemon

    def feed(self, stop):
        """Odometry, IMU, orders and events at rates of their own, some of them refused."""
        def odometry():
            lines, begin = "x,y,yaw\n", time.monotonic()
            with subprocess.Popen([BIN / "vdisp-probe", "send", "odometry", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as sender:
                try:
                    sender.stdin.write(lines)
                    while not stop.is_set():
                        passed = time.monotonic() - begin
                        jump = 50 if int(passed * 50) % 40 == 39 else 0
                        sender.stdin.write(f"{0.4 * passed + jump},{0.02 * passed},{0.05 * passed}\n")
                        sender.stdin.flush()
                        time.sleep(0.02)
                except OSError:
                    pass
                self.end(sender)
        def others():
            count = 0
            with subprocess.Popen([BIN / "vdisp-probe", "send", "imu", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as imu, \
                 subprocess.Popen([BIN / "vdisp-probe", "send", "drive", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as drive:
                try:
                    while not stop.is_set():
                        imu.stdin.write(f"0.1,{0.01 * (count % 7)},9.8,0.01,0.02,{0.001 * count}\n")
                        drive.stdin.write(f"0.3,{(0, 0.5, -0.5)[count // 20 % 3]}\n")
                        imu.stdin.flush(), drive.stdin.flush()
                        if count % 25 == 10:
                            run("vdisp-probe", "send", "event", f'door "{count}", left')
                        count += 1
                        time.sleep(0.03)
                except OSError:
                    pass
                self.end(imu)
                self.end(drive)
        threads = [threading.Thread(target=work) for work in (odometry, others)]
        for thread in threads:
            thread.start()
        return threads

    def small_recording(self, *more):
        drive = self.folder / "drive"
        made = run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none", *more), "--frames", 3, "--record", drive)
        self.assertEqual(made.returncode, 0, made.stderr)
        return drive

    def start(self, *options, first=(), **named):
        daemon = Running("vdispd", *first, "--sim", *sets(*options), stdout=subprocess.DEVNULL, **named)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 60), daemon.text())
        return daemon

    def flights(self):
        place = self.folder / "flight"
        return sorted(path.name for path in place.iterdir()) if place.exists() else []
