#!/usr/bin/python3
"""check: vdisp-bench runs, and its JSON is what scripts read. No time is judged.

usage: check.py VDISP-BENCH
SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib
import subprocess
import sys
import tempfile

NAMES = {"rectify", "matcher48", "matcher64", "matcher48_aligned", "speckle", "tree48", "backend", "census", "snow", "sgm64"}
MAY_BE_SKIPPED = set()
MEMBERS = {"name": str, "threads": int, "ours_ms": float, "peer_ms": float, "ratio": float}


def main():
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "times.json"
        done = subprocess.run([sys.argv[1], "--quick", "--json", file], capture_output=True, text=True)
        print(done.stdout, done.stderr)
        if done.returncode != 0:
            return f"ended with {done.returncode}"
        rows = json.loads(file.read_text())
    skipped = {line.split(":")[0] for line in done.stdout.splitlines() if ": skipped: " in line}
    names = subprocess.run([sys.argv[1], "--list"], capture_output=True, text=True, check=True).stdout.split()
    for row in rows:
        if row.keys() != MEMBERS.keys() or any(not isinstance(row[k], (kind, int)) for k, kind in MEMBERS.items()):
            return f"not the members that scripts read: {row}"
        if row["ours_ms"] <= 0 or abs(row["ratio"] - row["peer_ms"] / row["ours_ms"]) > 1e-6:
            return f"no times: {row}"
    if not NAMES <= set(names):
        return f"not listed: {sorted(NAMES - set(names))}"
    wanted = (NAMES - (skipped & MAY_BE_SKIPPED)) | (set(names) - skipped)
    missing = {(n, t) for n in wanted for t in (1, 2)} - {(r["name"], r["threads"]) for r in rows}
    if missing:
        return f"not timed: {sorted(missing)}"
    wrong = subprocess.run([sys.argv[1], "--only", "nothing"], capture_output=True, text=True)
    if wrong.returncode != 64 or "'nothing'" not in wrong.stderr:
        return f"an unknown name ended with {wrong.returncode}: {wrong.stderr}"
    return 0


sys.exit(main())
