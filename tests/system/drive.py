"""drive.py: what stands at both ends of vdisp-drive in the tests: a motor controller on a pseudo-terminal, and a daemon that gives orders.

SPDX-License-Identifier: Apache-2.0
"""
import os
import pathlib
import re
import select
import subprocess
import termios
import threading
import time
import tty

from programs import BIN, Running, wait_until


class Controller:
    """A motor controller: notes each command with its time (s, CLOCK_MONOTONIC), and answers by `answer`: a text, or a function of the
    command; None: says nothing. Its port is a link, as those under /dev/serial/by-id, that goes when it is unplugged."""

    def __init__(self, folder, answer=None):
        self.port = pathlib.Path(folder) / "controller"
        self.answer = answer
        self.kept = b""  # what is in its line when the port is plugged in: half a command of somebody who was cut short
        self.commands, self.reading = [], True  # (time, text without its \r)
        self.stopper = None
        self.plug()

    def plug(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.master)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(self.slave))
        os.close(self.slave)  # a port that is closed by all gives EIO until it is opened again: that is waited out
        self.ended = False
        self.reader = threading.Thread(target=self.listen, args=(self.master,), daemon=True)
        self.reader.start()

    def unplug(self):
        if self.ended:
            return
        self.ended = True
        self.reader.join()
        os.close(self.master)
        self.port.unlink(missing_ok=True)

    def listen(self, master):
        left = self.kept
        while not self.ended:
            if not self.reading or not select.select([master], [], [], 0.05)[0]:
                time.sleep(0 if self.reading else 0.05)
                continue
            try:
                left += os.read(master, 4096)
            except OSError:
                time.sleep(0.01)  # nobody has opened the port
                continue
            now = time.monotonic()
            *lines, left = left.split(b"\r")
            for line in lines:
                text = line.decode("latin-1")
                self.commands.append((now, text))
                said = self.answer(text) if callable(self.answer) else self.answer
                if said is not None:
                    os.write(master, said.encode("latin-1"))

    def baud(self):
        return termios.tcgetattr(self.master)[5]

    def since(self, begin):
        return [(at, text) for at, text in self.commands[:] if at >= begin]

    def wheels(self):
        """What the last command tells the wheels; None: nothing was said yet."""
        return wheels(self.commands[-1][1]) if self.commands else None

    def moves(self, limit=10.0):
        return wait_until(lambda: self.commands and time.monotonic() - self.commands[-1][0] < 0.2 and self.wheels() != (0, 0), limit)

    def stopped_after(self, begin, limit=3.0):
        """How long after `begin` the command came after which all are stops (s); None: not within the limit."""
        def last_move():
            return max((at for at, text in self.commands[:] if wheels(text) != (0, 0)), default=begin)
        def stop():
            return next((at for at, text in self.since(last_move()) if wheels(text) == (0, 0)), None)
        # Stopped for good: no move among what came in the 0.15 s behind the stop.
        if not wait_until(lambda: stop() is not None and time.monotonic() - stop() > 0.15, limit):
            return None
        return stop() - begin


def wheels(text):
    found = re.fullmatch(r"!M (-?\d+) (-?\d+)", text)
    return (int(found[1]), int(found[2])) if found else None


class Daemon(Running):
    """Gives orders as it is told. tell() returns when it took effect (s, CLOCK_MONOTONIC)."""

    def __init__(self, rate=30):
        super().__init__("vdisp-publish-drive", "--rate", rate, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline().split()[1:] == ["ready"], self.text()

    def tell(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return int(self.process.stdout.readline().split()[0]) * 1e-9

    def __exit__(self, *reason):
        super().__exit__(*reason)
        self.process.stdin.close()
        self.process.stdout.close()


def drive(port, *options, **sets):
    """vdisp-drive on this port; sets are keys of [drive]."""
    words = [word for key, value in sets.items() for word in ("--set", f"drive.{key}={value}")]
    return Running("vdisp-drive", "--port", port, *words, *options)
