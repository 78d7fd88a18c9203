#!/usr/bin/python3
"""045: the incremental planner over real shared memory: follows lists, reads anew what it missed, tells no way that nobody vouches for.

SPDX-License-Identifier: Apache-2.0
"""
import json
import math
import os
import signal
import subprocess
import time

from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

PLANNER = "vdisp-incremental-planner"


class Daemon(Running):
    """The small daemon of these tests: a wall goes to and fro, 2.4 to 2.6 m ahead."""

    def __init__(self, *arguments):
        super().__init__("vdisp-publish", "--occupancy", *arguments, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline().startswith("ready"), self.text()

    def __exit__(self, *reason):
        super().__exit__(*reason)
        self.process.stdout.close()


class IncrementalPlanner(ProgramTest):
    def plans(self, *arguments, code=0):
        done = run(PLANNER, *arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def follow(self, *arguments):
        """A planner in the background, and a function that gives the lines it has said."""
        output = self.folder / "planner.out"
        with open(output, "w") as file:
            planner = Running(PLANNER, "4", "0", "--json", *arguments, stdout=file)
        return planner, lambda: [json.loads(line) for line in output.read_text().splitlines(True) if line.endswith("\n")]

    def test_follows_the_lists_and_the_plan_is_the_one_made_anew(self):
        with Daemon("--rate", "50"):
            plans = self.plans("4", "0.3", "--json", "--compare", "--frames", "100")
        plans = [plan for plan in plans if plan["state"] == "fresh"]
        self.assertGreater(len(plans), 95)
        self.assertEqual(plans[0]["read"], "whole")
        self.assertGreater(sum(plan["read"] == "listed" for plan in plans), 30)
        self.assertGreater(sum(plan["read"] == "nothing" for plan in plans), 30)
        for plan in plans:
            self.assertTrue(plan["as_anew"] and plan["synthetic"], plan)
            self.assertLess(math.dist(plan["path"][0], (0, 0)), 0.1)
            self.assertLess(math.dist(plan["path"][-1], (4, 0.3)), 0.1)
            # The wall of that frame, as the daemon draws it.
            phase = plan["sequence"] // 2 % 72
            left = (25.5 - (phase if phase < 36 else 72 - phase)) / 10
            for x, y in plan["path"]:
                self.assertFalse(2.4 < x < 2.6 and left - 1.5 < y < left, plan)
        listed = [plan for plan in plans if plan["read"] == "listed"]
        self.assertLess(max(plan["fed"] for plan in listed), 100)
        followed, anew = (sorted(plan[key] for plan in listed)[len(listed) // 2] for key in ("took_us", "anew_us"))
        print(f"median of {len(listed)} changed frames: {followed:.0f} us, anew {anew:.0f} us")

    def test_plans_in_the_map_that_remembers_of_the_real_daemon(self):
        """A rover drives round; the goal stays 3 m ahead of it."""
        sets = ("sim.width=320", "sim.height=240", "image source.ndisp=32", "sim.scene=drive", "sim.odometry=yes", "sim.rate=10")
        with Running("vdispd", "--sim", *[word for item in sets for word in ("--set", item)]):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0, 10))
            plans = self.plans("3", "0", "--fused", "--json", "--compare", "--frames", "40")
        plans = [plan for plan in plans if plan["state"] == "fresh"]
        self.assertGreater(len(plans), 20)
        self.assertTrue(all(plan["memory"] and plan["as_anew"] for plan in plans), plans[-1])
        self.assertGreater(sum(plan["read"] == "listed" for plan in plans), 10)
        for plan in plans:
            if plan["path"]:
                self.assertLess(math.dist(plan["path"][0], (0, 0)), 0.1)
                self.assertLess(math.dist(plan["path"][-1], (3, 0)), 0.1)

    def test_reads_the_whole_grid_after_it_was_stopped(self):
        with Daemon("--rate", "50"):
            planner, plans = self.follow("--compare")
            with planner:
                self.assertTrue(wait_until(lambda: len(plans()) > 20))
                os.kill(planner.process.pid, signal.SIGSTOP)
                time.sleep(0.5)
                before = len(plans())
                os.kill(planner.process.pid, signal.SIGCONT)
                self.assertTrue(wait_until(lambda: len(plans()) > before + 20))
            after = [plan for plan in plans()[before:] if plan["state"] == "fresh"]
        self.assertIn("whole", [plan["read"] for plan in after[:3]])
        self.assertIn("listed", [plan["read"] for plan in after])
        self.assertTrue(all(plan["as_anew"] for plan in after))

    def test_says_dead_without_a_way_and_reads_the_next_daemon_anew(self):
        planner, plans = self.follow("--compare")
        with planner:
            for turn in range(3):
                said = len(plans())
                with Daemon("--rate", "50") as daemon:
                    self.assertTrue(wait_until(lambda: len(plans()) > said + 20))
                    fresh = [plan for plan in plans()[said:] if plan["state"] == "fresh"]
                    self.assertEqual(fresh[0]["read"], "whole", f"daemon {turn}")
                    self.assertTrue(all(plan["as_anew"] for plan in fresh))
                    daemon.process.kill()
                    daemon.process.wait()
                self.assertTrue(wait_until(lambda: plans()[-1]["state"] == "dead"))
                self.assertIsNone(plans()[-1]["path"])
                self.assertIsNone(planner.process.poll())

    def test_a_blind_map_has_no_way_and_a_reason(self):
        with Daemon("--rate", "50", "--blind"):
            plans = self.plans("4", "0", "--json", "--frames", "20")
        blind = [plan for plan in plans if plan["state"] == "blind"]
        self.assertGreaterEqual(len(blind), 20)
        for plan in plans:
            self.assertIsNone(plan["path"])
        self.assertTrue(all("in time" in plan["reason"] for plan in blind), blind[0])

    def test_a_stale_map_has_no_way(self):
        with Daemon("--rate", "50") as daemon:
            planner, plans = self.follow()
            with planner:
                self.assertTrue(wait_until(lambda: len(plans()) > 5))
                os.kill(daemon.process.pid, signal.SIGSTOP)
                self.assertTrue(wait_until(lambda: plans()[-1]["state"] == "stale"))
                self.assertIsNone(plans()[-1]["path"])
                os.kill(daemon.process.pid, signal.SIGCONT)
                self.assertTrue(wait_until(lambda: plans()[-1]["state"] == "fresh"))
                said = [plan.get("read", plan["state"]) for plan in plans()]
        last = max(i for i, word in enumerate(said) if word in ("stale", "dead"))
        self.assertEqual(said[last + 1], "whole")

    def test_shows_a_picture_with_wall_and_way(self):
        with Daemon("--rate", "50"):
            done = run(PLANNER, "4", "0", "--frames", "3", "--compare")
        self.assertEqual(done.returncode, 0, done.stderr)
        picture = [line for line in done.stdout.splitlines() if line.startswith("|")]
        self.assertEqual(len(picture) % 50, 0)
        self.assertEqual({len(line) for line in picture}, {53})
        self.assertEqual(sum("#" * 15 in line for line in picture), len(picture) // 25, "two rows of wall in each picture")
        self.assertIn("o", picture[10])
        self.assertIn("o", picture[49])
        self.assertRegex(done.stdout, r"map \d+ \(synthetic\): read \w+, \d+ cells fed, .* anew \d+ us and the same; the way costs \d\.\d m")

    def test_a_goal_outside_the_map_leads_to_its_border(self):
        with Daemon("--rate", "50"):
            plans = self.plans("40", "0", "--json", "--frames", "5")
        plan = plans[-1]
        self.assertTrue(plan["goal_outside"])
        self.assertLess(math.dist(plan["path"][-1], (4.95, 0)), 0.1)

    def test_unknown_ground_is_entered_as_the_policy_says(self):
        with Daemon("--rate", "50"):
            never = self.plans("4", "0", "--json", "--frames", "5", "--unknown", "0")[-1]
            slow, fast = (self.plans("1", "0", "--json", "--frames", "5", "--unknown", speed)[-1]["cost_m"] for speed in ("0.5", "1"))
        self.assertIsNone(never["path"])
        self.assertIn("stands", never["reason"])
        self.assertAlmostEqual(slow - fast, 0.5, delta=0.06)  # 5 cells of unknown ground, each twice as dear

    def test_buffer_and_radius_keep_the_way_off_the_wall(self):
        def nearest(plan):
            phase = plan["sequence"] // 2 % 72
            left = (25.5 - (phase if phase < 36 else 72 - phase)) / 10
            return min(math.hypot(max(2.4 - x, 0, x - 2.6), max(left - 1.5 - y, 0, y - left)) for x, y in plan["path"])
        with Daemon("--rate", "50"):
            none, wide, never = (min(nearest(plan) for plan in self.plans("4", "0", "--json", "--frames", "75", *words) if plan.get("path"))
                                 for words in (("--buffer", "0"), ("--buffer", "0.5"), ("--buffer", "0", "--radius", "0.4")))
        self.assertLess(none, 0.1)
        self.assertGreater(wide, none + 0.15)
        self.assertGreater(never, 0.3)  # from cell to cell 0.4 m, from edge to edge half a cell less on either side

    def test_ends_with_69_where_no_daemon_comes(self):
        plans = self.plans("4", "0", "--json", "--frames", "5", code=69)
        self.assertEqual([plan["state"] for plan in plans], ["dead"])
        self.assertIn("vdispd", plans[0]["reason"])

    def test_refuses_wrong_words(self):
        for words in ([], ["1"], ["1", "two"], ["nan", "0"], ["1", "0", "--frames", "0"], ["1", "0", "--unknown", "2"], ["1", "0", "--what"],
                      ["1", "0", "--buffer"], ["1", "0", "--radius", "-1"]):
            done = run(PLANNER, *words)
            self.assertEqual(done.returncode, 64, words)
            self.assertIn("usage: vdisp-incremental-planner", done.stderr)
        self.assertIn("usage", run(PLANNER, "--help").stdout)


if __name__ == "__main__":
    isolated_main()
