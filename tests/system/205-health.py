#!/usr/bin/python3
"""205: what the daemon counts: losses by kind, latency and deadline, in shared memory, by vdisp-probe and for Prometheus; and compare, which
shows a change on the same frame.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import time

import cv2

from programs import ROOT, ProgramTest, Running, isolated_main, run, wait_until

SMALL = ("--set", "sim.width=320", "--set", "sim.height=240", "--set", "image source.ndisp=32", "--set", "sim.rate=20")


class Daemon(ProgramTest):
    def start(self, *options):
        daemon = Running("vdispd", "--sim", *SMALL, *options, stdout=subprocess.DEVNULL)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 30), daemon.text())
        self.assertIsNone(daemon.process.poll(), daemon.text())
        return daemon

    def probe(self, *words, code=0):
        result = run("vdisp-probe", *words)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stdout if code == 0 else result.stderr

    def health(self):
        return json.loads(self.probe("stats", "--once", "--json"))["health"]

    def wait_for(self, good):
        """The first health that is good."""
        found = {}
        def look():
            found.update(self.health())
            return good(found)
        self.assertTrue(wait_until(look, 12), found)
        return found


class Health(Daemon):
    def test_frames_and_latency_are_counted_and_nothing_is_lost_in_health(self):
        self.start()
        told = self.wait_for(lambda h: h["frames"] > 30)
        self.assertEqual((told["no_pair"], told["blind_frames"], told["drops"], told["cameras"]), (0, 0, 0, None))
        latency = told["latency"]
        self.assertEqual(latency["count"], told["frames"])
        self.assertLess(0.1, latency["p50_ms"])
        self.assertLessEqual(latency["p50_ms"], latency["p99_ms"])
        self.assertLessEqual(latency["p99_ms"], latency["p999_ms"])
        self.assertLessEqual(latency["p999_ms"], latency["max_ms"])
        self.assertEqual((told["deadline_ms"], told["deadline_of"]), (50, "pair"))
        self.assertGreater(told["images"], told["frames"] * 5)
        self.assertEqual(told["inputs"]["odometry"], {"accepted": 0, "refused": 0})
        words = self.probe("stats", "--once")
        self.assertIn("map after p50", words)
        self.assertIn("deadline 50.0 ms, missed", words)

    def test_blind_frames_are_counted_by_their_reason(self):
        self.start("--set", "sim.event=cap", "--set", "sim.eventFrame=5")
        told = self.wait_for(lambda h: h["frames"] > 20)
        self.assertEqual(told["blind"]["too_dark"], told["blind_frames"])
        self.assertEqual(told["frames"] - told["blind_frames"], told["latency"]["count"])
        self.assertGreater(told["blind_frames"], 10)
        self.assertEqual(told["no_pair"], 0, "there is a pair, dark as it is")
        self.assertIn("too_dark", self.probe("stats", "--once"))

    def test_bad_pairs_are_counted_as_such(self):
        folder = self.write_pairs(6)
        (folder / "left" / "000002.png").write_bytes(b"no picture")
        config = self.write_config("loop=yes\nrate=20\n", middleware="shm")
        with Running("vdispd", "-c", config, stdout=subprocess.DEVNULL) as daemon:
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0), daemon.text())
            told = self.wait_for(lambda h: h["frames"] > 20)
            self.assertEqual(told["blind"].get("bad_pair"), told["no_pair"])
            self.assertAlmostEqual(told["no_pair"], told["frames"] / 6, delta=2)

    def test_a_tree_that_is_slower_than_its_frames_misses_deadlines(self):
        self.start("--set", "sim.rate=1000", "--set", "sim.scene=empty", "--set", "main.threads=1")
        told = self.wait_for(lambda h: h["frames"] > 50)
        self.assertEqual(told["deadline_ms"], 1)
        self.assertGreater(told["deadline_misses"], 0.9 * told["frames"])

    def test_a_deadline_that_is_set_counts_at_once(self):
        self.start()
        self.wait_for(lambda h: h["frames"] > 5)
        self.probe("set", "main.deadline", "0.01")
        told = self.wait_for(lambda h: h["deadline_misses"] > 10)
        self.assertEqual((told["deadline_ms"], told["deadline_of"]), (0.01, "exposure"))
        self.assertEqual(told["config_generation"], 1)

    def test_rubbish_on_the_control_socket_and_refused_samples_are_counted(self):
        self.start()
        client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        client.connect("/run/vdisp/control")
        client.send(b"rubbish")
        client.close()
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
            client.connect("/run/vdisp/control")
            body = struct.pack("=q10d", time.clock_gettime_ns(time.CLOCK_MONOTONIC), float("nan"), 0, 0, *[float("nan")] * 7)
            client.send(struct.pack("=IHHII", 0x43534456, 1, 1, 16 + len(body), 7) + body)
            told = self.wait_for(lambda h: h["control"]["connections_closed"] == 1 and h["inputs"]["odometry"]["refused"] == 1)
        self.assertEqual(told["inputs"]["odometry"]["accepted"], 0)
        words = self.probe("stats", "--once")
        self.assertIn("odometry refused 1 of 1", words)
        self.assertIn("1 closed", words)

    def test_maps_for_which_readers_left_no_block_are_counted(self):
        self.start("--set", "sim.rate=60")
        self.wait_for(lambda h: h["frames"] > 5)
        with Running("vdisp-reader", "hold", "map", "40", "3", stdout=subprocess.DEVNULL) as reader:  # the map has 32 blocks
            told = self.wait_for(lambda h: h["map_drops"] > 5)
            reader.process.wait(20)
        self.assertGreaterEqual(told["drops"], told["map_drops"])
        self.assertRegex(self.probe("stats", "--once"), r"dropped \d+ of \d+ images, \d+ maps")


class Latency(Daemon):
    def test_it_tells_percentiles_and_a_histogram_that_adds_up(self):
        self.start()
        self.wait_for(lambda h: h["frames"] > 30)
        told = json.loads(self.probe("latency", "--json"))
        self.assertEqual((told["of"], told["seconds"]), ("daemon", None))
        self.assertEqual(sum(bucket["count"] for bucket in told["histogram"]), told["count"])
        at = [bucket for bucket in told["histogram"] if bucket["from_ms"] < told["p50_ms"] <= bucket["to_ms"]]
        self.assertEqual(len(at), 1, "p50 is the end of its bucket")
        words = self.probe("latency")
        self.assertIn("since the start of the daemon", words)
        self.assertRegex(words, r"p50 [\d.]+ ms  p99 [\d.]+ ms  p99.9 [\d.]+ ms  max [\d.]+ ms  mean")
        self.assertIn("#", words)

    def test_a_measurement_holds_only_what_came_in_its_time(self):
        self.start()
        self.wait_for(lambda h: h["frames"] > 60)
        told = json.loads(self.probe("latency", "--seconds", "2", "--json"))
        self.assertGreater(told["count"], 10)
        self.assertLess(told["count"], 75)
        self.assertGreater(told["seconds"], 2)

    def test_in_a_readers_hands_it_is_longer_and_nothing_is_missed(self):
        self.start()
        told = json.loads(self.probe("latency", "--reader", "--seconds", "3", "--json"))
        self.assertEqual(told["of"], "reader")
        self.assertGreater(told["count"], 20)
        self.assertLessEqual(told["missed"], 2)
        daemon = json.loads(self.probe("latency", "--json"))
        self.assertGreater(told["p50_ms"], 0.5 * daemon["p50_ms"])

    def test_a_reader_measures_each_map_also_where_the_views_are_published_long_after_it(self):
        self.start()
        with Running("vdisp-reader", "count", "truth/map_cells", "8", stdout=subprocess.DEVNULL):
            time.sleep(1)  # made last, of the left view, and slowly
            told = json.loads(self.probe("latency", "--reader", "--seconds", "4", "--json"))
            made = json.loads(self.probe("latency", "--json"))
        self.assertGreaterEqual(told["count"] + told["missed"] + 1, 4 * 20 * 0.6)
        self.assertLess(told["p50_ms"], made["p50_ms"] + 4, "it is the map that is waited for")

    def test_without_a_daemon_it_is_69(self):
        self.assert_refused(run("vdisp-probe", "latency"), 69, "vdispd")


class Metrics(Daemon):
    def test_the_file_is_whole_at_any_moment_and_says_what_stats_says(self):
        file = self.folder / "vdisp.prom"
        daemon = self.start("--set", f"main.metrics={file}", "--set", "sim.rate=60")
        end = time.monotonic() + 3
        looks = 0
        while time.monotonic() < end:
            text = file.read_text()
            self.assertTrue(text.startswith("# HELP vdisp_up"), text[:80])
            self.assertRegex(text.splitlines()[-1], r"^vdisp_log_lines_lost_total \d+$")
            looks += 1
        self.assertGreater(looks, 100)
        values = {}
        for line in file.read_text().splitlines():
            if line.startswith("#"):
                self.assertRegex(line, r"^# (HELP|TYPE) vdisp_\w+ .+$")
                continue
            found = re.match(r"^(vdisp_\w+(?:\{[^}]*\})?) ([0-9.e+-]+)$", line)
            self.assertTrue(found, line)
            self.assertNotIn(found.group(1), values)
            values[found.group(1)] = float(found.group(2))
        self.assertGreater(values["vdisp_frames_total"], 20)
        buckets = [values[key] for key in values if key.startswith("vdisp_latency_seconds_bucket")]
        self.assertEqual(buckets, sorted(buckets))
        self.assertEqual(buckets[-1], values["vdisp_latency_seconds_count"])
        self.assertIn('vdisp_stage_runs_total{stage="map"}', values)
        self.assertEqual(values['vdisp_blind_frames_total{reason="no_floor"}'], 0)
        self.assertEqual([p.name for p in self.folder.iterdir() if "part" in p.name and p != file][:1], [])
        daemon.process.terminate()
        self.assertEqual(daemon.process.wait(10), 0)
        self.assertIn('vdisp_up{name="IPLObstacleDetection"} 0', file.read_text())

    def test_a_place_that_is_gone_when_the_daemon_ends_is_said_and_it_ends_well(self):
        place = self.folder / "gone"
        place.mkdir()
        daemon = self.start("--set", f"main.metrics={place}/vdisp.prom")
        shutil.rmtree(place)
        daemon.process.terminate()
        self.assertEqual(daemon.process.wait(20), 0, daemon.text())
        self.assertIn("metrics: ", daemon.text())

    def test_what_the_flight_recorder_could_not_write_is_counted(self):
        (self.folder / "no-folder").write_text("a file")
        file = self.folder / "vdisp.prom"
        daemon = self.start("--set", "recorder.seconds=1", "--set", f"recorder.folder={self.folder}/no-folder", "--set", f"main.metrics={file}")
        self.assertIn('vdisp_flight_recorder_folders_total{result="failed"} 0', file.read_text())
        daemon.process.send_signal(signal.SIGUSR1)
        self.assertTrue(wait_until(lambda: 'vdisp_flight_recorder_folders_total{result="failed"} 1' in file.read_text(), 8), file.read_text())
        self.assertIn('vdisp_flight_recorder_folders_total{result="written"} 0', file.read_text())
        self.assertIn("vdisp_flight_recorder_steps_lost_total 0", file.read_text())

    def test_a_disk_that_fills_is_said_once_and_costs_no_frame(self):
        disk = self.folder / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], check=True)
        self.addCleanup(subprocess.run, ["umount", disk])
        daemon = self.start("--set", f"main.metrics={disk}/vdisp.prom")
        (disk / "filler").write_bytes(b"x" * (1 << 15))
        try:
            with open(disk / "more", "wb", buffering=0) as more:
                while True:
                    more.write(b"x" * 4096)
        except OSError:
            pass
        self.assertTrue(wait_until(lambda: "metrics: " in daemon.text(), 5), daemon.text())
        time.sleep(2.5)
        self.assertEqual(daemon.text().count("metrics: "), 1, daemon.text())
        before = self.health()["frames"]
        time.sleep(1)
        self.assertGreater(self.health()["frames"], before)
        (disk / "more").unlink()
        (disk / "filler").unlink()
        self.assertTrue(wait_until(lambda: "is written again" in daemon.text(), 5), daemon.text())


class Compare(Daemon):
    def test_old_and_new_are_of_the_same_frame_and_differ_as_the_parameter_says(self):
        self.start("--set", "sim.scene=flat", "--set", "Map.minCount=4")
        page = self.folder / "page.png"
        told = json.loads(self.probe("compare", "thresh=40", "-o", page, "--json"))
        self.assertEqual(told["changes"], ["image source.thresh: 10 -> 40"])
        stages = {stage["stage"]: stage for stage in told["stages"]}
        self.assertEqual((stages["left"]["differing"], stages["right"]["differing"]), (0, 0), "the same frame")
        self.assertGreater(stages["disparity"]["differing"], 100)
        self.assertTrue(stages["map"]["old_valid"])
        picture = cv2.imread(str(page))
        self.assertEqual(picture.shape[1], 1400)
        self.assertGreater(picture.std(), 10)
        self.assertEqual(json.loads(self.probe("get", "thresh", "--json"))["value"], "10", "the daemon goes on as it was")

    def test_what_changes_nothing_differs_nowhere_so_old_and_new_have_one_history(self):
        self.start()
        told = json.loads(self.probe("compare", "thresh=10", "--frames", "3", "--json"))
        self.assertEqual([stage["stage"] for stage in told["stages"] if stage["differing"]], [])
        self.assertGreaterEqual(told["frames"][1] - told["frames"][0], 2)
        self.assertGreater(len(told["stages"]), 15)

    def test_it_compares_with_what_is_set_now_and_with_keys_that_need_a_restart(self):
        self.start()
        self.probe("set", "thresh", "30")
        told = json.loads(self.probe("compare", "thresh=30", "image source.ndisp=48", "--json"))
        self.assertEqual(told["changes"], ["image source.thresh: 30 -> 30", "image source.ndisp: 32 -> 48"])
        stages = {stage["stage"]: stage for stage in told["stages"]}
        self.assertGreater(stages["disparity"]["differing"], 0)
        self.assertIsNone(stages["vdisparity"]["pixels"], "of another size")

    def test_what_is_made_of_the_pair_again_is_what_the_daemon_made_of_it(self):
        # One pair again and again, and no floor: the disparity knows nothing of the frame before.
        golden = ROOT / "tests/golden"
        config = self.folder / "vdisp.cfg"
        config.write_text(f"[image source]\nsource = files\nleft = {golden}/left/000000.png\nright = {golden}/right/000000.png\n"
                          f"paramfile = {golden}/calibration.yml\nloop = yes\nrate = 10\nndisp = 32\nalign = none\n[main]\ndetectors = none\n")
        with Running("vdispd", "-c", config, stdout=subprocess.DEVNULL) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 30), daemon.text())

            def measured(name):
                self.probe("dump", self.folder / name, "disparity", "left")
                return self.frame(self.folder / name, 0)["rejected"]["disparity"]["measured"]
            before = measured("before")
            stages = {stage["stage"]: stage for stage in json.loads(self.probe("compare", "thresh=30", "--json"))["stages"]}
            self.assertEqual(stages["disparity"]["counted"]["old"], before)
            self.probe("set", "thresh", "30")
            time.sleep(1)  # the newest frame may be the one before
            after = measured("after")
            self.assertLess(after, before)
            self.assertEqual(stages["disparity"]["counted"]["new"], after, "what compare showed is what set brings")

    def test_on_a_replayed_recording_it_compares_too_and_what_is_the_daemons_own_cannot_be_changed(self):
        made = run("vdispd", "--sim", *SMALL, "--set", "sim.rate=0", "--set", "main.middleware=none", "--frames", 5, "--record", self.folder / "drive")
        self.assertEqual(made.returncode, 0, made.stderr)
        sets = [word for item in (f"image source.recording={self.folder}/drive", "image source.source=files", "image source.loop=yes", "image source.rate=10",
                                  "image source.ndisp=32", "recorder.seconds=2", f"recorder.folder={self.folder}/flights") for word in ("--set", item)]
        with Running("vdispd", *sets, stdout=subprocess.DEVNULL) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 30), daemon.text())
            told = json.loads(self.probe("compare", "thresh=40", "--frames", "2", "--json"))
            stages = {stage["stage"]: stage for stage in told["stages"]}
            self.assertGreater(stages["disparity"]["differing"], 100)
            for key in ("recorder.keep=3", "recorder.seconds=9", "drive.port=/dev/null", "image source.recording=elsewhere"):
                self.assert_refused(run("vdisp-probe", "compare", key, "-o", self.folder / "x.png"), 64, "cannot be compared")

    def test_what_cannot_be_compared_is_refused(self):
        self.assert_refused(run("vdisp-probe", "compare", "thresh=1", "-o", self.folder / "x.png"), 69, "vdispd")
        self.start()
        for words, code, said in ((["thresh"], 64, "KEY=VALUE"), (["treshold=3"], 64, "treshold"), (["thresh=99"], 78, "must be a number from 0 to 40"),
                                  (["sim.seed=3"], 64, "cannot be compared"), (["main.name=x"], 64, "cannot be compared"),
                                  (["image source.paramfile=x.yml"], 64, "rectified pair")):
            result = run("vdisp-probe", "compare", *words, "-o", self.folder / "x.png")
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(said, result.stderr)
        self.assert_refused(run("vdisp-probe", "compare", "thresh=3", "--stage", "nosuch", "-o", self.folder / "x.png"), 64, "nosuch", "disparity")
        plain = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")}
        self.assert_refused(run("vdisp-probe", "compare", "thresh=3", env=plain), 69, "display", "-o FILE")
        self.assertEqual([p.name for p in self.folder.iterdir()], [])


if __name__ == "__main__":
    isolated_main()
