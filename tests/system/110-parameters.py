#!/usr/bin/python3
"""110: each parameter of the table changes the stage it names, in the direction its help states. A key without a proof, here or in 111 to 115, fails.

SPDX-License-Identifier: Apache-2.0
"""
import ast
import json
import os
import pathlib
import re
import shutil
import subprocess
import time

import numpy

from parameters import BASE, ParameterTest
from programs import BIN, Running, isolated_main, run, wait_until

HERE = pathlib.Path(__file__).parent


class Parameters(ParameterTest):
    # [main]
    def test_main_middleware(self):
        for value, files in (("shm", True), ("ddx", True), ("none", False)):
            with Running("vdispd", "--sim", "--set", f"main.middleware={value}", "--frames", "10000"):
                self.assertEqual(wait_until(lambda: run("vdisp-probe", "list").returncode == 0, 5 if files else 1.5), files, value)

    def test_main_period(self):
        times = []
        for period in (0, 2000):
            begin = time.monotonic()
            self.dump(f"main.period={period}", frames=4)
            times.append(time.monotonic() - begin)
        self.assertGreater(times[1], 6)  # three pauses
        self.assertGreater(times[1], times[0])

    def test_main_debug(self):
        def words(level, *sets):
            return len(run("vdispd", "--sim", "--frames", "3", "--set", "main.middleware=none", "--set", f"main.debug={level}", *sets).stderr)
        lost = ("--set", "Floor.minRansac=100000")
        self.assertLess(words(0, *lost), words(1, *lost))
        self.assertLess(words(1), words(2))
        self.assertLess(words(2), words(3))

    def test_main_name(self):
        with Running("vdispd", "--sim", "--set", "main.name=other"):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list", "--name", "other").returncode == 0, 5))
            self.assertEqual(run("vdisp-probe", "list").returncode, 69)

    def test_main_threads(self):
        sets = [word for item in [*self.pairs(640, 480), "image source.source=files", "image source.loop=yes", "main.middleware=none"]
                for word in ("--set", item)]
        def grows_to(count, threads):
            with Running("vdispd", *sets, "--set", f"main.threads={count}") as daemon:
                return wait_until(lambda: len(os.listdir(f"/proc/{daemon.process.pid}/task")) >= threads, 3)
        if os.cpu_count() > 1:  # on one core more threads show nothing
            self.assertFalse(grows_to(1, 4))  # the loop, the log and the parameters
            self.assertTrue(grows_to(4, 4))
        one, four = (self.dump(f"main.threads={count}") for count in (1, 4))
        numpy.testing.assert_array_equal(one.picture("disparity"), four.picture("disparity"))

    def test_main_detectors(self):
        branches = {"map": "vdisparity", "snow": "snow", "cross_check": "both", "decision": "any", "disparity": "all"}
        for detectors, there in (("vdisparity", {"vdisparity", "any"}), ("snow", {"snow", "any"}), ("none", set()),
                                 ("vdisparity, snow", {"vdisparity", "snow", "both", "any"}), ("snow,vdisparity", {"vdisparity", "snow", "both", "any"})):
            stages = self.snow(f"main.detectors={detectors}").json["stages"]
            self.assertEqual({stage for stage in branches if stage in stages}, {s for s, branch in branches.items() if branch in there | {"all"}}, detectors)

    def scheduled(self, *sets):
        """{name of a thread: (policy, real-time priority, processors)} of the running daemon, and what it has locked (kB)."""
        words = [word for item in [*BASE, "main.threads=2", *sets] for word in ("--set", item)]
        with Running("vdispd", *words) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            threads = {}
            for task in pathlib.Path(f"/proc/{daemon.process.pid}/task").iterdir():
                number = int(task.name)
                name = "loop" if number == daemon.process.pid else (task / "comm").read_text().strip() + task.name
                threads[name] = (os.sched_getscheduler(number), os.sched_getparam(number).sched_priority, os.sched_getaffinity(number))
            locked = int(re.search(r"VmLck:\s*(\d+)", pathlib.Path(f"/proc/{daemon.process.pid}/status").read_text())[1])
        return threads, locked

    def real_time(self, *sets):
        threads, _ = self.scheduled("main.debug=1", *sets)
        return [policy[:2] for policy in threads.values() if policy[0] != os.SCHED_OTHER], threads["loop"][:2]

    def refused_to_nobody(self, *words):
        """What vdispd says to a user without rights."""
        # That user need not see the build; /tmp is this test's own, and holds sockets by the names of programs.
        place = pathlib.Path("/tmp/programs")
        place.mkdir(exist_ok=True)
        for name in ("vdispd", "vdisp_sim.so"):
            shutil.copy(BIN / name, place)
        return subprocess.run(["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups", "prlimit", "--rtprio=0", "--memlock=65536",
                               place / "vdispd", *[word for item in [*BASE, *words] for word in ("--set", item)], "--frames", "1"],
                              capture_output=True, text=True, timeout=60)

    def test_main_scheduling(self):
        self.assertEqual(self.real_time("main.scheduling=other"), ([], (os.SCHED_OTHER, 0)))
        for word, policy in (("fifo", os.SCHED_FIFO), ("rr", os.SCHED_RR)):
            threads, loop = self.real_time(f"main.scheduling={word}")
            self.assertEqual(loop, (policy, 10))
            self.assertGreaterEqual(threads.count((policy, 10)), 2, threads)  # the loop and its second band
        everything, _ = self.scheduled("main.scheduling=fifo", "main.debug=1")
        self.assertIn(os.SCHED_OTHER, [policy for policy, _, _ in everything.values()])  # the log
        # What works beside the loop would keep it waiting, were it of its priority.
        everything, _ = self.scheduled("main.scheduling=fifo", "main.debug=1", f"main.metrics={self.folder}/m.prom", "recorder.seconds=1", f"recorder.folder={self.folder}/flight")
        for name in ("metrics", "flight", "parameters"):
            found = [policy for thread, (policy, _, _) in everything.items() if thread.startswith(name)]
            self.assertEqual(found, [os.SCHED_OTHER], (name, everything))
        self.assert_refused(self.refused_to_nobody("main.scheduling=fifo"), 77, "[main] scheduling = fifo", "LimitRTPRIO")

    def test_main_priority(self):
        for priority in (3, 40):
            self.assertEqual(self.real_time("main.scheduling=rr", f"main.priority={priority}")[1], (os.SCHED_RR, priority))

    def test_main_cpus(self):
        mine = sorted(os.sched_getaffinity(0))
        for text, cpus in ((str(mine[-1]), {mine[-1]}), (f"{mine[0]} , {mine[-1]}", {mine[0], mine[-1]}), ("", set(mine))):
            threads, _ = self.scheduled(f"main.cpus={text}", "main.debug=1")
            # All but the log, which was there before.
            self.assertEqual([name for name, (_, _, where) in threads.items() if where != cpus and not name.startswith("vdispd")], [], text)
        self.assert_refused(run("vdispd", "--sim", "--set", "main.cpus=1000"), 78, "[main] cpus = 1000", "processor 1000", str(mine[0]))
        for text in ("x", "3-1", "1,", "-1", "0-5000"):
            self.assert_refused(run("vdispd", "--sim", "--set", f"main.cpus={text}"), 78, "main.cpus", "as 0,2-3")

    def test_main_lockMemory(self):
        self.assertLess(self.scheduled("main.lockMemory=no", "main.debug=1")[1], 1000)
        self.assertGreater(self.scheduled("main.lockMemory=yes", "main.debug=1")[1], 20000)
        self.assert_refused(self.refused_to_nobody("main.lockMemory=yes"), 77, "[main] lockMemory = yes", "LimitMEMLOCK")

    def test_main_deadline(self):
        # The pair's way through the tree takes longer than a hundredth of a millisecond, and less than a minute.
        misses = {}
        for deadline in (0.01, 60000):
            with Running("vdispd", "--sim", "--set", f"main.deadline={deadline}", "--set", "sim.rate=20", "--set", "sim.width=320",
                         "--set", "sim.height=240"):
                def health():
                    told = run("vdisp-probe", "stats", "--once", "--json")
                    return json.loads(told.stdout)["health"] if told.returncode == 0 else {}
                self.assertTrue(wait_until(lambda: health().get("frames", 0) > 10, 15))
                misses[deadline] = health()["deadline_misses"]
                self.assertEqual(health()["deadline_ms"], deadline)
        self.assertGreater(misses[0.01], 10)
        self.assertEqual(misses[60000], 0)

    def test_main_metrics(self):
        file = self.folder / "vdisp.prom"
        self.dump(f"main.metrics={file}")
        self.assertIn("vdisp_up", file.read_text())
        self.assert_refused(run("vdispd", "--sim", "--set", "main.metrics=/dev/null/x", "--frames", 1), 73, "/dev/null/x")

    # [ipc]
    def test_ipc_memory(self):
        result = run("vdispd", "--sim", "--frames", 1, "--set", "ipc.memory=4")
        self.assert_refused(result, 78, "memory")
        self.assertEqual(run("vdispd", "--sim", "--frames", 1, "--set", "ipc.memory=256").returncode, 0)

    def test_ipc_group(self):
        self.assert_refused(run("vdispd", "--sim", "--frames", 1, "--set", "ipc.group=no-such-group"), 78, "no-such-group")
        with Running("vdispd", "--sim", "--set", "ipc.group=nogroup"):
            owner = lambda: subprocess.run(["stat", "-c", "%G", "/dev/shm/iceoryx_mgmt"], capture_output=True, text=True).stdout.strip()
            self.assertTrue(wait_until(lambda: owner() == "nogroup", 5), owner())

    # [control]
    def test_control_socket(self):
        place = self.folder / "door"
        with Running("vdispd", "--sim", "--set", f"control.socket={place}"):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "get", "thresh", "--control", place).returncode == 0))
            self.assertEqual(run("vdisp-probe", "get", "thresh").returncode, 69)

    def test_control_maxAge(self):
        self.assertEqual(self.accepted("0,0,0\n", "control.maxAge=0.2", pause=0.5)["stages"]["in/odometry"]["reason"], "no_odometry")
        self.assertTrue(self.accepted("0,0,0\n", "control.maxAge=20", pause=0.5)["stages"]["in/odometry"]["valid"])

    def test_control_maxSpeed(self):
        for speed, accepted in ((5, 1), (40, 2)):
            self.assertEqual(self.accepted("0,0,0\n1.5,0,0\n", f"control.maxSpeed={speed}", pause=0.3)["odometry"]["accepted"], accepted)

    def test_control_maxTurn(self):
        for turn, accepted in ((3, 1), (40, 2)):
            self.assertEqual(self.accepted("0,0,0\n0,0,1.5\n", f"control.maxTurn={turn}", pause=0.3)["odometry"]["accepted"], accepted)

    # recordings
    def record(self, *sets, frames=4):
        ParameterTest.runs += 1
        folder = self.folder / f"drive{ParameterTest.runs}"
        arguments = [word for item in [*BASE, *sets] for word in ("--set", item)]
        result = run("vdispd", *arguments, "--frames", frames, "--record", folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return folder

    def test_image_source_recording(self):
        drive = self.record("sim.seed=5")
        again = self.files(f"image source.recording={drive}", frames=4)
        live = self.dump("sim.seed=5", frames=4)
        numpy.testing.assert_array_equal(again.picture("disparity"), live.picture("disparity"))
        self.assertEqual(again.json["timestamp_ns"], live.json["timestamp_ns"])

    def flights(self, *sets, wait=1.2, asks=1):
        """The folders that the flight recorder wrote, oldest first, each when it was asked."""
        ParameterTest.runs += 1
        folder = self.folder / f"flight{ParameterTest.runs}"
        values = ("sim.width=160", "sim.height=120", "image source.ndisp=32", "sim.rate=30", "main.detectors=none", f"recorder.folder={folder}",
                  "recorder.free=0", "recorder.seconds=5", *sets)
        with Running("vdispd", "--sim", *[word for item in values for word in ("--set", item)]) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            time.sleep(wait)
            for _ in range(asks):
                run("vdisp-probe", "dump-flight")
        return sorted(folder.iterdir()) if folder.exists() else []

    def steps(self, *sets, **options):
        return len((self.flights(*sets, **options)[0] / "index.csv").read_text().splitlines()) - 1

    def test_recorder_seconds(self):
        self.assertEqual(self.flights("recorder.seconds=0"), [])
        self.assertLess(self.steps("recorder.seconds=0.3"), self.steps("recorder.seconds=1"))

    def test_recorder_memory(self):
        self.assertLess(self.steps("recorder.memory=1", wait=2.5), 30)  # 1 MiB holds 26 pairs of 160x120
        self.assertGreater(self.steps("recorder.memory=4", wait=2.5), 40)

    def test_recorder_folder(self):
        self.assertEqual(len(self.flights()), 1)
        self.assert_refused(run("vdispd", "--sim", "--set", "recorder.seconds=1"), 78, "without folder")

    def test_recorder_keep(self):
        self.assertEqual([len(self.flights(f"recorder.keep={keep}", asks=3, wait=0.3)) for keep in (1, 2, 10)], [1, 2, 3])

    def test_recorder_free(self):
        self.assertEqual(len(self.flights("recorder.free=1")), 1)
        self.assertEqual(self.flights("recorder.free=1048576"), [])

    def test_no_key_is_without_a_proof(self):
        section, missing, proofs = "", [], set()
        listed = (HERE / "CMakeLists.txt").read_text()
        for file in HERE.glob("11[0-5]-parameters*.py"):
            self.assertIn(f"({file.name} system ", listed)
            proofs |= {case.name for part in ast.parse(file.read_text()).body if isinstance(part, ast.ClassDef)
                       for case in part.body if isinstance(case, ast.FunctionDef) and case.name.startswith("test_")}
        for line in run("vdispd", "--print-config").stdout.splitlines():
            if line.startswith("["):
                section = line.strip("[]").lower().replace(" ", "_")
            elif re.match(r"\w+ *=", line):
                key = re.match(r"\w+", line).group()
                if not any(name.startswith(f"test_{section}_") and re.search(rf"_{key}(_|$)", name) for name in proofs):
                    if not (section == "map" and key == "angRot"):
                        missing.append(f"[{section}] {key}")
        self.assertEqual(missing, [])


isolated_main()
