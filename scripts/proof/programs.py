# programs.py: the real programs: built, started, asked, and what the kernel says of them.
# SPDX-License-Identifier: Apache-2.0
import json
import os
import pathlib
import resource
import subprocess
import sys
import time

TICKS = os.sysconf("SC_CLK_TCK")


def binaries(root, options, *targets):
    """Set-up and release build of the targets, unless --bin or --no-build; the folder of the programs."""
    if options.bin or options.no_build:
        folder = pathlib.Path(options.bin or root / "build/release/bin").resolve()
    else:
        for command in (["scripts/setup", "bench"], ["env", "VDISP_CMAKE_OPTIONS=-DVDISP_TESTS=ON", "scripts/build", "release", *targets]):
            code = subprocess.run(command, cwd=root, stdout=sys.stderr).returncode
            if code != 0:
                sys.exit(code)
        folder = root / "build/release/bin"
    missing = [name for name in targets if not (folder / name).exists() and not (folder / (name + ".so")).exists()]
    if missing:
        sys.exit(f"{options.program}: no {missing[0]} in {folder}; leave out --no-build and --bin, or name the folder of a build with tests")
    return folder


class Programs:
    """Programs of one folder, run in `work`. `before`: words before each command, such as nice -n -15."""

    def __init__(self, folder, work):
        self.folder, self.work = folder, pathlib.Path(work)

    def command(self, program, *words, before=()):
        return [*before, str(self.folder / program), *map(str, words)]

    def start(self, program, *words, output=subprocess.DEVNULL, errors=subprocess.DEVNULL, before=()):
        return subprocess.Popen(self.command(program, *words, before=before), cwd=self.work, stdin=subprocess.DEVNULL, stdout=output, stderr=errors)

    def run(self, program, *words, timeout=60, before=()):
        return subprocess.run(self.command(program, *words, before=before), cwd=self.work, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout)

    def json(self, program, *words, timeout=60):
        """What a probe prints as JSON; None where it failed."""
        done = self.run(program, *words, timeout=timeout)
        return json.loads(done.stdout) if done.returncode == 0 and done.stdout else None


def end(process, limit=10):
    """SIGTERM, and SIGKILL where that does not end it; its exit code, None where it had to be killed."""
    if process.poll() is None:
        process.terminate()
    try:
        return process.wait(limit)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None


def wait_until(condition, limit):
    """True as soon as the condition holds, False after `limit` s."""
    last = time.monotonic() + limit
    while not condition():
        if time.monotonic() >= last:
            return False
        time.sleep(0.02)
    return True


def processor_seconds(pids):
    """User and system time that these processes have taken, and our own that have ended."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    total = (ended.ru_utime + ended.ru_stime) * TICKS
    for pid in pids:
        try:
            fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            total += int(fields[11]) + int(fields[12])
        except OSError:
            pass  # counted above
    return total / TICKS


def machine_seconds():
    """Time that the processors of this machine worked since it began, whoever for; stolen by its host included."""
    user, nice, system, _, _, irq, softirq, steal = map(int, pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9])
    return (user + nice + system + irq + softirq + steal) / TICKS


def held_by(pid):
    """What a process holds: memory of its own and shared (KiB), handles, threads."""
    status = dict(line.split(":", 1) for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines())
    kib = lambda key: int(status[key].split()[0])
    return {"memory_kib": kib("RssAnon"), "resident_kib": kib("VmRSS"), "handles": len(os.listdir(f"/proc/{pid}/fd")),
            "threads": int(status["Threads"])}
