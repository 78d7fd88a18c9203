#!/usr/bin/python3
"""070: the control socket of the real daemon: parameters change between two frames, what comes in is judged, and no client, however
many, silent, loud or killed, costs a frame.

SPDX-License-Identifier: Apache-2.0
"""
import grp
import json
import math
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import struct
import subprocess
import threading
import time

from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

SOCKET = "/run/vdisp/control"
SMALL = ("--set", "sim.width=160", "--set", "sim.height=120", "--set", "image source.ndisp=32", "--set", "sim.rate=30")
NAN = float("nan")
ODOMETRY, IMU, DRIVE, EVENT, SET, GET, SAVE, UNDO = range(1, 9)
REPLY_BYTES = 1968


def message(kind, body, version=1, magic=0x43534456, size=None):
    """As docs/control.md has it."""
    return struct.pack("=IHHII", magic, version, kind, size if size is not None else 16 + len(body), 7) + body


def now():
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC)


def odometry(x, y=0.0, yaw=0.0, stamp=None):
    return message(ODOMETRY, struct.pack("=q10d", now() if stamp is None else stamp, x, y, yaw, *[NAN] * 7))


def parameter(kind, key="", value=""):
    return message(kind, struct.pack("=96s256sII", key.encode(), value.encode(), 0, 0))


def connected():
    client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    client.connect(SOCKET)
    client.settimeout(5)
    return client


class Control(ProgramTest):
    def start(self, *options):
        daemon = Running("vdispd", "--sim", *SMALL, *options, stdout=subprocess.DEVNULL)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None), daemon.text())
        self.assertIsNone(daemon.process.poll(), daemon.text())
        return daemon

    def probe(self, *words, code=0):
        result = run("vdisp-probe", *words)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stdout if code == 0 else result.stderr

    def frame_of(self, *topics):
        """frame.json of one frame of the running daemon."""
        Control.dumps = getattr(Control, "dumps", 0) + 1
        folder = self.folder / f"dump{Control.dumps}"
        self.probe("dump", folder, "--once", *topics)
        return self.frame(folder, 0)

    def input(self, kind="odometry"):
        return self.frame_of("left", f"in/{kind}")[kind]

    def wait_for_input(self, kind="odometry", **wanted):
        """The record, as soon as it says so; what was sent is seen a frame later."""
        found = {}
        def told():
            found.update(self.input(kind))
            return all(found.get(key) == value for key, value in wanted.items())
        self.assertTrue(wait_until(told), f"{wanted}: {found}")
        return found

    def assert_no_frame_is_missed(self, work, seconds=3):
        """While work() goes on the daemon steps at its 30 Hz."""
        before, begin = self.steps()
        thread = threading.Thread(target=work)
        thread.start()
        time.sleep(seconds)
        thread.join()
        after, end = self.steps()
        missed = (end - begin) * 30e-9 - (after - before)
        self.assertLess(abs(missed), 3, f"{after - before} steps in {(end - begin) * 1e-9:.2f} s")

    def steps(self):
        frame = self.frame_of("left")
        return frame["sequence"], now()

    def test_a_sender_that_takes_the_place_of_one_that_is_gone_is_heard_from_its_first_message(self):
        self.start("--set", "sim.rate=10")
        for number in range(10):
            other = connected()
            sender = connected()
            sender.send(odometry(0))
            self.wait_for_input(accepted=2 * number + 1)
            other.close()  # its place in the daemon's list is free, before the sender's
            time.sleep(0.15)
            sender.close()
            with connected() as successor:
                successor.send(odometry(0))
                time.sleep(0.15)
                self.assertEqual(self.input()["refused"], 0, f"round {number}")

    # parameters
    def test_a_live_key_changes_the_stage_from_a_known_frame_on_and_the_generation_rises(self):
        self.start()
        self.assertEqual(self.frame_of("map")["config_generation"], 0)
        self.assertEqual(self.frame_of("map")["stages"]["map"]["grid"]["min_count"], 3)
        told = json.loads(self.probe("set", "Map.minCount", "9", "--json"))
        self.assertEqual((told["key"], told["value"], told["config_generation"]), ("Map.minCount", "9", 1))
        frame = self.frame_of("map")
        self.assertGreaterEqual(frame["sequence"], told["sequence"])
        self.assertEqual((frame["config_generation"], frame["stages"]["map"]["grid"]["min_count"]), (1, 9))
        self.probe("undo")
        frame = self.frame_of("map")
        self.assertEqual((frame["config_generation"], frame["stages"]["map"]["grid"]["min_count"]), (2, 3))
        self.assertIn("nothing to undo", self.probe("undo", code=78))

    def test_every_live_key_takes_its_bounds_and_the_daemon_goes_on(self):
        self.start()
        keys = json.loads(self.probe("get", "--json"))
        live = [key for key in keys if key["live"]]
        self.assertGreater(len(live), 25)
        for key in live:
            bounds = re.match(r"a number from (\S+) to (\S+)", key["allowed"])
            words = bounds.groups() if bounds else [word for word in re.split(r", | or ", key["allowed"])]
            if key["key"] == "main.period":
                words = ["0", "40"]
            for word in words:
                result = run("vdisp-probe", "set", key["key"], word)
                if result.returncode:
                    # What contradicts another key: anglefloorMin and anglefloorMax, near and far, leastSpeed and speed.
                    self.assertRegex(result.stderr, "must be (less than|at most) ")
            self.probe("set", key["key"], key["value"])
        self.assertEqual(self.frame_of("map")["reason"], "none")
        for before, after in zip(keys, json.loads(self.probe("get", "--json"))):
            self.assertEqual(before, after)

    def test_what_cannot_be_set_is_refused_in_the_files_words(self):
        self.start()
        self.assertIn("thresh = 99, must be a number from 0 to 40 [-], default 10", self.probe("set", "thresh", "99", code=78))
        self.assertIn("must be less than anglefloorMax", self.probe("set", "anglefloorMin", "1.5", code=78))
        self.assertIn("restart", self.probe("set", "ndisp", "64", code=78))
        self.assertIn("nearest is 'minCount'", self.probe("set", "Map.minCont", "3", code=64))
        self.assertIn("[Map]", self.probe("set", "width", "3", code=64))
        self.assertIn("255", self.probe("set", "thresh", "9" * 300, code=78))
        self.assertEqual(self.frame_of("map")["config_generation"], 0)

    def test_get_tells_value_default_range_unit_and_help(self):
        self.start("--set", "Map.minCount=5")
        told = json.loads(self.probe("get", "minCount", "--json"))
        self.assertEqual((told["key"], told["value"], told["default"], told["unit"], told["live"]), ("Map.minCount", "5", "3", "pixel", True))
        self.assertIn("from 1 to 32767", told["allowed"])
        self.assertIn("obstacle", told["help"])
        self.assertIn("Map.minCount = 5  (default 3)\n", self.probe("get"))

    def test_debug_and_period_take_effect_at_once(self):
        daemon = self.start()
        self.probe("set", "main.debug", "3")
        self.assertTrue(wait_until(lambda: "floor height" in daemon.text()), "no trace of frames")
        self.probe("set", "main.period", "60000")
        time.sleep(0.2)
        begin = time.monotonic()
        self.probe("set", "main.period", "0")
        self.assertLess(time.monotonic() - begin, 1, "served while waiting")
        self.assertEqual(self.frame_of("left")["config_generation"], 3)

    # save
    def test_save_keeps_comments_and_order_and_the_next_start_reads_it(self):
        config = self.folder / "vdisp.cfg"
        config.write_text("# my rover\n[Map]\nminCount = 5  ; cells\n\n[image source]\nthresh=\"12\"\n# end\n")
        os.chmod(config, 0o640)
        daemon = self.start("-c", config)
        self.probe("set", "minCount", "7")
        self.probe("set", "max_height", "0.3")
        self.assertIn(str(config), self.probe("save"))
        self.assertEqual(config.read_text(), "# my rover\n[Map]\nminCount = 7  ; cells\n\n[image source]\nthresh=\"12\"\n# end\n"
                         "\n[Limit obstacle]\nmax_height = 0.3\n")
        self.assertEqual(config.stat().st_mode & 0o777, 0o640)
        self.assertEqual([p.name for p in self.folder.iterdir() if p.name.startswith("vdisp.cfg")], ["vdisp.cfg"])
        self.probe("set", "minCount", "8")
        self.probe("undo")
        text = config.read_text()
        self.probe("save")
        self.assertEqual(config.read_text(), text)
        daemon.process.terminate()
        daemon.process.wait()
        printed = run("vdispd", "-c", config, "--print-config").stdout
        self.assertIn("\nminCount = 7\n", printed)
        self.assertIn("\nmax_height = 0.3\n", printed)

    def test_save_goes_before_another_hand_and_refuses_a_file_with_faults_a_folder_that_is_gone_and_no_file(self):
        config = self.folder / "sub" / "vdisp.cfg"
        config.parent.mkdir()
        config.write_text("[Map]\nminCount = 5\n")
        daemon = self.start("-c", config)
        self.probe("set", "minCount", "7")
        config.write_text("[Map]\nminCount = 5\n# another hand\n")
        self.probe("save")
        self.assertEqual(config.read_text(), "[Map]\nminCount = 7\n# another hand\n")
        self.probe("set", "minCount", "8")
        config.write_text("[Map]\nminCount = 7\nminCont = 5\n")
        self.assertIn("fault", self.probe("save", code=73))
        self.assertEqual(config.read_text(), "[Map]\nminCount = 7\nminCont = 5\n")
        config.unlink()
        self.assertIn("cannot be read", self.probe("save", code=73))
        daemon.__exit__()
        self.start()
        self.assertIn("without a vdisp.cfg", self.probe("save", code=73))

    # what comes in
    def test_odometry_is_shown_ages_goes_blind_and_comes_back(self):
        daemon = self.start("--set", "control.maxAge=2")
        self.assertEqual(self.frame_of("left", "in/odometry")["stages"]["in/odometry"], {"valid": False, "reason": "no_odometry"})
        with connected() as client:
            for i in range(30):
                client.send(odometry(0.02 * i, yaw=0.01 * i))
                time.sleep(0.02)
            found = self.wait_for_input(accepted=30, refused=0)
            self.assertAlmostEqual(found["x"], 0.58)
            self.assertAlmostEqual(found["yaw"], 0.29)
            self.assertGreater(found["age_s"], 0)
            self.assertLess(found["age_s"], 2)
            time.sleep(2.2)
            frame = self.frame_of("left", "in/odometry")
            self.assertEqual(frame["stages"]["in/odometry"]["reason"], "no_odometry")
            self.assertTrue(frame["valid"], "the frame is not blind for it")
            client.send(odometry(0.6))
            self.wait_for_input(accepted=31, x=0.6)
        self.assertEqual(daemon.text().count("odometry lost"), 1, daemon.text())

    def test_the_map_remembers_while_odometry_comes_and_says_once_that_it_stopped(self):
        daemon = self.start("--set", "sim.width=320", "--set", "sim.height=240", "--set", "sim.rate=10", "--set", "sim.scene=flat",
                            "--set", "main.debug=1")

        def memory():
            frame = self.frame_of("left", "memory", "fused")
            return frame.get("memory"), frame["stages"]["fused"].get("grid")
        state, grid = memory()
        self.assertEqual((state["state"], state["cause"], state["x"], grid["frame"]), ("frame_only", "no_odometry", None, 0))
        ended = threading.Event()

        def stand():
            with connected() as client:
                while not ended.wait(0.02):
                    client.send(odometry(2.0, yaw=0.5))
        sender = threading.Thread(target=stand)
        sender.start()
        self.addCleanup(sender.join)
        self.addCleanup(ended.set)
        self.assertTrue(wait_until(lambda: memory()[0]["state"] == "fused", 10), memory())
        state, grid = memory()
        self.assertAlmostEqual(state["x"], 2.0)
        self.assertAlmostEqual(state["yaw"], 0.5)
        self.assertLess(state["lag_s"], 0.2)
        self.assertEqual(grid["frame"], 1)
        for found, needed in zip(grid["pose"], (-2 * math.cos(0.5), 2 * math.sin(0.5), -0.5)):  # the odometry's origin, as the rover sees it
            self.assertAlmostEqual(found, needed, 5)
        time.sleep(1.5)
        ended.set()
        sender.join()
        self.assertTrue(wait_until(lambda: memory()[0]["state"] == "frame_only", 10))
        self.assertIn(memory()[0]["cause"], ("late", "no_odometry"))
        self.assertEqual(daemon.text().count("the map is of the frame alone"), 1, daemon.text())
        self.assertEqual(daemon.text().count("the map is fused in the odometry frame"), 1, daemon.text())

    def test_bad_odometry_is_refused_counted_and_said_once(self):
        daemon = self.start("--set", "control.maxAge=5")
        with connected() as client:
            client.send(odometry(0))
            self.wait_for_input(accepted=1)
            bad = ((odometry(NAN), "not_finite"), (odometry(1e9), "out_of_range"), (odometry(300), "jump"),
                   (odometry(0, stamp=now() - 20_000_000_000), "late"), (odometry(0, stamp=now() + 1_000_000_000_000), "ahead"),
                   (odometry(0, stamp=-(1 << 63)), "late"))
            for number, (message_, why) in enumerate(bad):
                client.send(message_)
                self.wait_for_input(refused=number + 1, last_refusal=why)
            stamp = now()
            client.send(odometry(0, stamp=stamp))
            client.send(odometry(0, stamp=stamp - 1_000_000))
            self.wait_for_input(accepted=2, refused=7, last_refusal="backwards")
            with connected() as other:
                other.send(odometry(0))
                self.wait_for_input(refused=8, last_refusal="other_sender")
            for _ in range(100):
                client.send(odometry(NAN))
            self.wait_for_input(accepted=2, refused=108)
        self.assertLess(daemon.text().count("odometry refused at"), 10, daemon.text())

    def test_imu_drive_and_events_come_by_the_probe(self):
        self.start("--set", "control.maxAge=20")
        lines = subprocess.Popen([BIN / "vdisp-probe", "send", "imu"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.addCleanup(lambda: (lines.stdin.close(), lines.wait()))
        lines.stdin.write("az,ax,ay\n9.61,-1.95,0\n")
        lines.stdin.flush()
        imu = self.wait_for_input("imu", accepted=1)
        self.assertAlmostEqual(imu["pitch"], math.atan2(1.95, 9.61))  # nose down: up has a part to the back
        self.probe("send", "event", "collision, left")
        self.wait_for_input("event", accepted=1, labels=["collision, left"])
        orders = self.folder / "drive.csv"
        orders.write_text("# speed and turn\n0.5,0.1\n0.4,-0.1\n")
        self.assertEqual(json.loads(self.probe("send", "drive", "--file", orders, "--json")), {"sent": 2})
        self.wait_for_input("drive", accepted=2, speed=0.4, turn_rate=-0.1)
        self.assertIn("line 2: speed = 'x'", run_with_input("1,2\nx,2\n", "send", "drive", code=66))
        self.assertIn("no such thing", run_with_input("", "send", "no such thing", code=64))
        self.assertIn("lacks the column yaw", run_with_input("x,y\n", "send", "odometry", code=66))

    def test_the_operator_wins_over_the_detectors_until_the_order_is_300_ms_old(self):
        self.start("--set", "control.maxAge=20")
        def driven():
            return self.frame_of("left", "drive").get("drive_command", {})
        self.assertTrue(wait_until(lambda: driven().get("decider") == "vdisparity"))
        orders = self.folder / "drive.csv"
        orders.write_text("-0.4,0.7\n" * 100)
        with subprocess.Popen([BIN / "vdisp-probe", "send", "drive", "--file", orders, "--rate", "20"], stdout=subprocess.DEVNULL) as sender:
            self.assertTrue(wait_until(lambda: driven().get("decider") == "operator"))
            told = driven()
            self.assertEqual((told["speed"], told["turn_rate"]), (-0.4, 0.7))
            sender.terminate()
        time.sleep(0.4)
        self.assertEqual(driven()["decider"], "vdisparity")
        self.assertGreater(self.input("drive")["age_s"], 0.3)  # still there for who reads in/drive

    def test_send_keeps_the_rate_and_the_time_of_the_lines(self):
        self.start()
        poses = self.folder / "poses.csv"
        poses.write_text("timestamp_ns,x,y,yaw\n" + "".join(f"{i * 100_000_000},{i * 0.1:.1f},0,0\n" for i in range(8)))
        begin = time.monotonic()
        self.probe("send", "odometry", "--file", poses)
        self.assertAlmostEqual(time.monotonic() - begin, 0.7, delta=0.3)
        begin = time.monotonic()
        self.probe("send", "odometry", "--file", poses, "--rate", "40")
        self.assertLess(time.monotonic() - begin, 0.5)

    # clients that do not behave
    def test_what_is_no_message_ends_the_connection_with_a_reply(self):
        daemon = self.start()
        body = struct.pack("=q10d", now(), *[0.0] * 10)
        for bad in (b"x", b"\0" * 15, os.urandom(16), os.urandom(5000), message(ODOMETRY, body, version=2), message(ODOMETRY, body, magic=1),
                    message(ODOMETRY, body[:-8]), message(ODOMETRY, body + b"\0"), message(ODOMETRY, body, size=3), message(99, body), message(0, b""),
                    message(9, b"\0" * 360), message(SET, b"")):
            with connected() as client:
                client.send(bad)
                reply = client.recv(4096)
                self.assertEqual((len(reply), struct.unpack_from("=I", reply, 16)[0]), (REPLY_BYTES, 6), bad[:20])
                self.assertEqual(client.recv(10), b"")
        with connected() as client:  # texts that do not end
            client.send(message(SET, b"k" * 96 + b"v" * 256 + b"\0" * 8))
            self.assertEqual(struct.unpack_from("=I", client.recv(4096), 16)[0], 2)
        self.assertRegex(daemon.text(), r"control: process \d+ of user \d+ closed: not a message")
        self.assertEqual(self.input()["accepted"], 0)

    def test_floods_silence_and_deafness_cost_no_frame(self):
        daemon = self.start()
        idle = [connected() for _ in range(3)]
        stop = time.monotonic() + 3

        def flood():
            deaf = connected()
            deaf.setblocking(False)
            loud = connected()
            loud.setblocking(False)
            while time.monotonic() < stop:
                for client, text in ((loud, odometry(0)), (deaf, parameter(GET, "thresh"))):
                    try:
                        client.send(text)
                    except BlockingIOError:
                        time.sleep(0.0005)
                    except (BrokenPipeError, ConnectionError):
                        deaf.close()
                        deaf = connected()
                        deaf.setblocking(False)
            loud.close()
            deaf.close()
        self.assert_no_frame_is_missed(flood)
        self.assertIn("does not read its replies", daemon.text())
        self.assertIn("more than 64 messages a frame", daemon.text())
        self.assertTrue(wait_until(lambda: self.input()["accepted"] > 1000))
        self.probe("set", "thresh", "11")
        for client in idle:
            client.close()

    def test_200_connections_are_refused_from_the_17th_on_and_room_comes_back(self):
        daemon = self.start()
        clients, refused = [connected() for _ in range(200)], 0
        time.sleep(0.5)
        for client in clients:
            self.addCleanup(client.close)
            client.setblocking(False)
            try:
                reply = client.recv(4096)
                self.assertEqual(struct.unpack_from("=I", reply, 16)[0], 5)
                refused += 1
            except BlockingIOError:
                pass
        self.assertEqual(refused, 184)
        self.assertIn("all 16 connections are in use", daemon.text())
        self.assertLess(daemon.text().count("connections are in use"), 4)
        self.assertEqual(run("vdisp-probe", "get", "thresh").returncode, 69)
        time.sleep(5)  # silent for so long they make room
        self.probe("get", "thresh")
        for client in clients:
            client.close()
        self.probe("get", "thresh")

    def test_20_killed_clients_leave_no_trace(self):
        daemon = self.start()
        ends = []

        def talk(up):
            s = connected()
            os.write(up, b"+")
            while True:
                s.send(odometry(0))
                s.send(parameter(GET, "thresh"))
                s.recv(4096)

        def kill():
            for _ in range(20):
                told, up = os.pipe()
                client = os.fork()  # another Python would need longer to start than all the rest takes
                if client == 0:
                    try:
                        talk(up)
                    finally:
                        os._exit(1)
                os.close(up)
                heard = os.read(told, 1)
                time.sleep(0.02)
                os.kill(client, signal.SIGKILL)
                ends.append((heard, os.waitpid(client, 0)[1]))
                os.close(told)
        self.assert_no_frame_is_missed(kill, seconds=0.1)
        self.assertEqual(ends, [(b"+", signal.SIGKILL)] * 20)  # each talked until it was killed
        self.assertTrue(wait_until(lambda: len(os.listdir(f"/proc/{daemon.process.pid}/fd")) < 60))
        self.assertTrue(wait_until(lambda: sum("socket:" in link for link in self.open_files(daemon)) < 20))
        self.probe("set", "thresh", "11")

    def open_files(self, daemon):
        folder = pathlib.Path(f"/proc/{daemon.process.pid}/fd")
        return [os.readlink(path) for path in folder.iterdir()]

    # the socket file
    def test_a_dead_daemons_socket_is_replaced_and_a_live_ones_never(self):
        daemon = self.start()
        daemon.process.kill()
        daemon.process.wait()
        self.assertTrue(pathlib.Path(SOCKET).is_socket())
        daemon = self.start()
        self.probe("get", "thresh")
        daemon.process.terminate()
        self.assertEqual(daemon.process.wait(5), 0)
        self.assertFalse(pathlib.Path(SOCKET).exists())
        pathlib.Path(SOCKET).touch()
        self.assert_one_line(run("vdispd", "--sim", *SMALL), 73, "no socket stands there")
        pathlib.Path(SOCKET).unlink()
        stranger = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        stranger.bind(SOCKET)
        stranger.listen()
        self.assert_one_line(run("vdispd", "--sim", *SMALL), 69, "another program listens")
        stranger.close()
        self.start()

    def assert_one_line(self, result, code, words):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertRegex(result.stderr, "^vdispd: control socket [^\n]*" + words + "[^\n]*\n$")

    def test_another_place_is_named_by_the_key_and_found_by_the_option(self):
        place = self.folder / "door"
        self.start("--set", f"control.socket={place}")
        self.assertIn("thresh = 10", self.probe("get", "thresh", "--control", place))
        self.assertIn("/run/vdisp/control", self.probe("get", "thresh", code=69))

    def test_without_a_daemon_the_words_are_69_and_wait_when_asked(self):
        for words in (["set", "thresh", "1"], ["get"], ["save"], ["undo"], ["send", "event", "x"]):
            self.assert_refused(run("vdisp-probe", *words), 69, "/run/vdisp/control", "vdispd")
        with Running("vdisp-probe", "get", "thresh", "--wait", "20", stdout=subprocess.DEVNULL) as probe:
            time.sleep(0.3)
            self.start()
            self.assertEqual(probe.process.wait(10), 0, probe.text())

    def test_a_stopped_daemon_is_69_within_the_limit(self):
        daemon = self.start()
        daemon.process.send_signal(19)
        try:
            begin = time.monotonic()
            self.assertIn("did not answer", self.probe("get", "thresh", code=69))
            self.assertLess(time.monotonic() - begin, 3)
        finally:
            daemon.process.send_signal(18)

    def test_members_of_the_group_may_connect_and_others_may_not(self):
        group, nobody = grp.getgrnam("daemon"), pwd.getpwnam("nobody").pw_uid
        daemon = Running("vdispd", "--sim", *SMALL, "--set", "ipc.group=daemon", stdout=subprocess.DEVNULL, extra_groups=[group.gr_gid])
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
        binary = self.folder / "vdisp-probe"
        shutil.copy(BIN / "vdisp-probe", binary)
        os.chmod(self.folder, 0o755)

        def ask(groups):
            return subprocess.run([binary, "get", "thresh"], capture_output=True, text=True, user=nobody, group=nobody, extra_groups=groups)
        self.assert_refused(ask([]), 77, "[ipc] group")
        self.assertEqual(ask([group.gr_gid]).returncode, 0)
        with connected():
            self.assertEqual(pathlib.Path(SOCKET).stat().st_mode & 0o777, 0o660)

    def test_0_a_user_who_may_make_the_socket_nowhere_is_told_and_the_daemon_runs(self):
        # The first test: a lock that root's daemon leaves behind would be in this user's way.
        nobody = pwd.getpwnam("nobody")
        binaries = self.folder / "bin"
        shutil.copytree(BIN, binaries, ignore=lambda folder, names: [n for n in names if n not in ("vdispd", "vdisp_sim.so")])
        os.chmod(self.folder, 0o755)
        os.chmod("/run", 0o755)
        shutil.rmtree("/run/vdisp", ignore_errors=True)
        environment = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
        options = {"capture_output": True, "text": True, "user": nobody.pw_uid, "group": nobody.pw_gid, "extra_groups": [], "env": environment}
        command = [binaries / "vdispd", "--sim", *SMALL, "--frames", "3"]
        result = subprocess.run(command, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("control socket: this user may not make /run/vdisp/control", result.stderr)
        runtime = self.folder / "runtime"
        runtime.mkdir()
        os.chown(runtime, nobody.pw_uid, nobody.pw_gid)
        options["env"] = {**environment, "XDG_RUNTIME_DIR": str(runtime)}
        result = subprocess.run(command, **options)
        self.assertNotIn("control socket", result.stderr)
        self.assertTrue((runtime / "vdisp/control.lock").exists())

    def test_the_c_library_sends_sets_and_says_what_is_wrong(self):
        self.start()
        self.assertEqual(run("vdisp-control-c").returncode, 0)
        for kind in ("odometry", "imu", "drive", "event"):
            self.wait_for_input(kind, accepted=1)
        result = run("vdisp-control-c", self.folder / "nobody")
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stdout, "nobody: No such file.*vdispd")

    def test_the_library_finds_a_daemon_that_was_started_anew(self):
        daemon = self.start()
        lines = subprocess.Popen([BIN / "vdisp-probe", "send", "odometry", "--wait", "10"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (lines.stdin.close(), lines.wait(), lines.stdout.close()))
        lines.stdin.write("0,0,0\n")
        lines.stdin.flush()
        self.wait_for_input(accepted=1)
        daemon.process.kill()
        daemon.process.wait()
        self.start("--set", "control.maxAge=20")
        lines.stdin.write("1,0,0\n")
        lines.stdin.flush()
        self.wait_for_input(accepted=1, x=1)

    # recordings
    def test_the_simulators_odometry_is_its_way_bit_for_bit(self):
        def way(name):
            run("vdispd", "--sim", *SMALL, "--set", "sim.odometry=yes", "--set", "main.middleware=none", "--frames", 10, "--dump", self.folder / name)
            return [self.frame(self.folder / name, i)["odometry"] for i in range(10)]
        one, two = way("one"), way("two")
        self.assertEqual(one, two)
        moved = [((b["x"] - a["x"]) ** 2 + (b["y"] - a["y"]) ** 2) ** 0.5 for a, b in zip(one, one[1:])]
        for a, b, step in zip(one, one[1:], moved):
            self.assertAlmostEqual(step, 0.5 / 30, delta=1e-3)  # the drive scene's 0.5 m/s
            self.assertAlmostEqual(math.atan2(b["y"] - a["y"], b["x"] - a["x"]), a["yaw"], delta=0.1)  # it goes where it heads
            self.assertEqual((a["pitch"], a["roll"], a["age_s"]), (0, 0, 0))


def run_with_input(text, *words, code):
    result = subprocess.run([BIN / "vdisp-probe", *words], input=text, capture_output=True, text=True, timeout=20)
    assert result.returncode == code, (result.returncode, result.stderr)
    return result.stderr


if __name__ == "__main__":
    isolated_main()
