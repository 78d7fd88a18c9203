# publishing.py: what it costs to publish all stages: mean time of a step, alone and while a reader takes every image.
# SPDX-License-Identifier: Apache-2.0
import os
import re
import shlex
import subprocess

from evaluation.daemon import RunFailed, Skipped

SETS = {"image source.source": "sim", "sim.scene": "drive", "sim.rate": 30}
# iceoryx allows one RouDi on a machine: /tmp and /dev/shm of its own, and the programs where the new /tmp does not hide them.
PRIVATE = "mount --bind '{bin}' /mnt && mount -t tmpfs none /dev/shm && mount -t tmpfs none /tmp || exit 99\n"
READER = "nice -n 19 /mnt/vdisp-probe dump /tmp/dump --wait 20 --frames 1000000 >/dev/null 2>&1 &\nreader=$!\n"
DAEMON = "/mnt/vdispd -c /dev/null {options} 2>&1\ncode=$?\n[ -z \"$reader\" ] || kill $reader 2>/dev/null\nexit $code\n"


def profile(daemon, reader, options):
    """Numbers of the profile that the daemon prints at its end."""
    script = PRIVATE.format(bin=daemon.binary.resolve().parent) + (READER if reader else "") + DAEMON.format(options=options)
    done = subprocess.run(["unshare", "-m", "sh", "-c", script], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode == 99:
        raise Skipped("no private /tmp and /dev/shm here: " + done.stderr.strip())
    head = re.search(r"profile: (\d+) steps, .* blind, ([\d.]+) ms a step, .* overhead ([\d.-]+) %", done.stdout)
    if done.returncode != 0 or not head:
        raise RunFailed(f"exit {done.returncode}: {done.stdout[-400:]}{done.stderr[-200:]}")
    display = re.search(r"show_limit .* (\d+) runs", done.stdout)
    step = float(head[2])
    return {"steps": int(head[1]), "watched": int(display[1]) / int(head[1]) if display else 0.0, "step [ms]": step,
            "not in stages [ms]": step * float(head[3]) / 100}


def publish_section(daemon, section):
    if os.geteuid() != 0:
        raise Skipped("needs root, for a private /tmp and /dev/shm")
    frames, rows = 300 if daemon.quick else 900, []
    for what, middleware, reader in (("not published", "none", False), ("published, nobody watches", "shm", False),
                                     ("published, all stages watched", "shm", True)):
        options = shlex.join(daemon.options({"main.middleware": middleware, **SETS}, frames))
        rows.append({"": what, **profile(daemon, reader, options)})
    section.table([("", ""), ("steps", "d"), ("watched", ".2f"), ("step [ms]", ".2f"), ("not in stages [ms]", ".3f")], rows,
                  "Scene `drive` at 30 Hz. Watched: share of the steps in which the displays ran too. Not in stages: the part"
                  " of a step outside all stages, that is loans, publishing and the driver.")
