#!/usr/bin/python3
"""115: each key of [drive] changes what vdisp-drive says to a controller on a pseudo-terminal, as its help says.

SPDX-License-Identifier: Apache-2.0
"""
import statistics
import subprocess
import time

from drive import Controller, Daemon, drive, wheels
from programs import ProgramTest, Running, isolated_main, wait_until

STOP = (0, 0)


class DriveParameters(ProgramTest):
    def said(self, order, seconds=1.0, then=None, after=0.5, answer=None, **sets):
        """Commands, as (time, text), from the start on: an order for so long, and what comes after it."""
        controller = Controller(self.folder, answer)
        try:
            with Daemon() as daemon, drive(controller.port, **sets) as self.link:
                daemon.tell(order)
                # The time counts from the first command, however long the start takes.
                self.assertTrue(wait_until(lambda: len(controller.commands) > 1), self.link.text())
                time.sleep(seconds)
                self.turned = daemon.tell(then) if then else None
                time.sleep(after if then else 0)
                return controller.commands[:]
        finally:
            controller.unplug()

    def steady(self, order, **sets):
        """What the wheels are told at last."""
        return wheels(self.said(order, **{"acceleration": 100, "deceleration": 100, **sets})[-1][1])

    def test_drive_port(self):
        controller = Controller(self.folder)
        try:
            with Running("vdisp-drive", "--set", f"drive.port={controller.port}"):
                self.assertTrue(wait_until(lambda: controller.commands))
            with Running("vdisp-drive", "--set", "drive.port=-", stdout=subprocess.PIPE, text=True) as link:
                self.assertEqual(link.process.stdout.readline(), "!M 0 0\\r\n")
                link.process.stdout.close()
        finally:
            controller.unplug()

    def test_drive_baud(self):
        import termios
        for baud in (9600, 57600):
            controller = Controller(self.folder)
            with drive(controller.port, baud=baud):
                self.assertTrue(wait_until(lambda: controller.commands))
                self.assertEqual(controller.baud(), getattr(termios, f"B{baud}"))
            controller.unplug()

    def test_drive_rate(self):
        def pause(rate):
            times = [at for at, _ in self.said("go 0.3 0", 2, rate=rate)]
            return statistics.median(b - a for a, b in zip(times, times[1:]))
        self.assertAlmostEqual(pause(5), 0.2, delta=0.03)
        self.assertAlmostEqual(pause(40), 0.025, delta=0.01)

    def test_drive_command(self):
        self.assertEqual(self.said("go 0.5 0.25", command="v {speed:.2} {turn}\\r", acceleration=100)[-1][1], "v 0.50 0.250")

    def test_drive_stop(self):
        texts = [text for _, text in self.said("go 0.5 0", then="blind", stop="HALT\\r")]
        self.assertEqual((texts[0], texts[-1]), ("HALT", "HALT"))
        self.assertEqual(self.said("blind", stop="", command="v {speed:.1} {turn:.1}\\r")[-1][1], "v 0.0 0.0")

    def test_drive_start(self):
        texts = [text for _, text in self.said("go 0.5 0", start="^ECHOF 1\\r")]
        self.assertEqual(texts[:3], ["!M 0 0", "!M 0 0", "^ECHOF 1"])
        self.assertEqual(texts.count("^ECHOF 1"), 1)
        self.assertNotEqual(wheels(texts[-1]), STOP)

    def test_drive_reply(self):
        self.assertNotEqual(wheels(self.said("go 0.5 0", answer="yes\r", reply="yes")[-1][1]), STOP)
        self.assertEqual({text for _, text in self.said("go 0.5 0", answer="no\r", reply="yes")}, {"!M 0 0"})

    def test_drive_replyTimeout(self):
        def commands_until_stop(seconds):
            controller = Controller(self.folder, "+\r")
            try:
                with Daemon() as daemon, drive(controller.port, reply="\\+", replyTimeout=seconds):
                    daemon.tell("go 0.3 0")
                    self.assertTrue(controller.moves())
                    begin = time.monotonic()
                    controller.answer = None
                    return controller.stopped_after(begin)
            finally:
                controller.unplug()
        self.assertAlmostEqual(commands_until_stop(0.2), 0.2, delta=0.15)
        self.assertAlmostEqual(commands_until_stop(0.8), 0.8, delta=0.15)

    def test_drive_timeout(self):
        for seconds in (0.2, 1):
            said = self.said("go 0.3 0", then="silent", after=1.6, timeout=seconds)
            last = max(at for at, text in said if wheels(text) != STOP)
            self.assertAlmostEqual(last - self.turned, seconds, delta=0.15)

    def test_drive_wheelBase(self):
        self.assertEqual(self.steady("go 0.3 0.5", wheelBase=0.4), (200, 400))
        self.assertEqual(self.steady("go 0.3 0.5", wheelBase=0.8), (100, 500))

    def test_drive_wheelScale(self):
        self.assertEqual(self.steady("go 0.3 0.5", wheelScale=100), (20, 40))

    def test_drive_reverse(self):
        found = [self.steady("go 0.3 0.5", reverse=value) for value in ("none", "left", "right", "both")]
        self.assertEqual(found, [(200, 400), (-200, 400), (200, -400), (-200, -400)])

    def test_drive_maxWheelSpeed(self):
        self.assertEqual(self.steady("go 0.6 1", maxWheelSpeed=1), (400, 800))
        self.assertEqual(self.steady("go 0.6 1", maxWheelSpeed=0.4), (200, 400))

    def change(self, said, begin=0.0):
        """Greatest change of a wheel from a command to the next, m/s a second, after `begin`; by the period, not by the clock of a busy test."""
        speeds = [wheels(text)[0] / 1000 for at, text in said if at > begin]
        return max(abs(b - a) for a, b in zip(speeds, speeds[1:])) * 20

    def test_drive_acceleration(self):
        for most in (0.4, 1.6):
            self.assertAlmostEqual(self.change(self.said("go 0.9 0", acceleration=most)) / most, 1, delta=0.5)

    def test_drive_deceleration(self):
        for most in (0.4, 1.6):
            said = self.said("go 0.9 0", 0.5, then="go 0.1 0", after=0.4, acceleration=100, deceleration=most)
            self.assertAlmostEqual(self.change(said, self.turned) / most, 1, delta=0.5)

    def test_drive_stopDeceleration(self):
        def stops_in(value):
            said = self.said("go 0.9 0", 0.5, then="blind", after=1.5, acceleration=100, stopDeceleration=value)
            return next(at for at, text in said if at > self.turned and wheels(text) == STOP) - self.turned
        self.assertLess(stops_in("off"), 0.2)
        self.assertAlmostEqual(stops_in(2), 0.45, delta=0.15)
        self.assertAlmostEqual(stops_in(1), 0.9, delta=0.2)


isolated_main()
