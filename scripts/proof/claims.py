# claims.py: what a soak claims, from what was counted in it.
# SPDX-License-Identifier: Apache-2.0
import statistics

# Memory of the daemon's own: what is done for the first time may take some, and keep it; in the second half nothing is new.
FIRST_KIB, LATER_KIB = 4096, 1024


def begin_and_end(samples, key):
    """Medians of the first and the last tenth, at least three each."""
    count = max(3, len(samples) // 10)
    return [statistics.median(sample[key] for sample in part) for part in (samples[:count], samples[-count:])]


def unexplained_drops(samples, hoarders):
    """Images dropped while no reader held all blocks, by stage."""
    found = {}
    for before, after in zip(samples, samples[1:]):
        for stage, drops in after["drops"].items():
            more = drops - before["drops"].get(stage, 0)
            if more and not hoarders.explain(before["at"], after["at"]):
                found[stage] = found.get(stage, 0) + more
    return found


def words(counts):
    return ", ".join(f"{name} {count}" for name, count in counts.items()) or "none"


def losses(section, run):
    gate, health = section.gate, run.health
    gate("the probe that counts told the figures to the end", run.uncounted is None, run.uncounted or "it did", "it did")
    gate("no frame was blind", health["blind_frames"] == 0, words(health["blind"]), "none")
    gate("every frame had a pair", health["no_pair"] == 0, health["no_pair"], 0)
    gate("no map was dropped", health["map_drops"] == 0, health["map_drops"], 0)
    drops = unexplained_drops(run.watched.samples, run.hoarders)
    gate("no image was dropped but where a reader kept all", not drops, words(drops), "none")
    refused = {kind: count["refused"] for kind, count in health["inputs"].items() if count["refused"]}
    gate("nothing that came in was refused", not refused, words(refused), "none")
    control = {key: count for key, count in health["control"].items() if count}
    gate("no connection and no request was refused", not control, words(control), "none")
    gate("no line of the log was lost", health["log_lines_lost"] == 0, health["log_lines_lost"], 0)
    broken = run.tuner.done["refused"]
    gate("files with faults were refused, and no others", health["reloads_refused"] == broken, health["reloads_refused"], broken)


def held(section, run):
    gate, before, after = section.gate, run.held_before, run.held_after
    for when, samples, most in (("", run.samples, FIRST_KIB), (" in the second half", run.samples[len(run.samples) // 2:], LATER_KIB)):
        first, last = begin_and_end(samples, "memory_kib")
        gate(f"the daemon's memory is flat{when}", last - first <= most, f"{first / 1024:.2f} to {last / 1024:.2f} MiB",
             f"at most {most / 1024:.0f} MiB more")
    sizes = {sample["shared"] for sample in run.samples}
    gate("shared memory keeps its size", len(sizes) == 1, " or ".join(f"{size / 2**20:.1f} MiB" for size in sorted(sizes)), "one size")
    for key in ("handles", "threads"):
        gate(f"as many {key} as before the readers", after[key] == before[key], f"{before[key]} to {after[key]}", "the same")
    gate("no socket of the dead is left", run.sockets_clean, len(run.sockets), "1, of the probe that counts")


def readers(section, run):
    gate, steady = section.gate, run.steady
    for what, faults in (("readers that live see frames in order, and again after they were stopped", run.crowd.faults),
                         ("senders are served, also after others were killed", run.senders.faults),
                         ("parameters are what was set, and what undo left", run.tuner.faults)):
        gate(what, not faults, "; ".join(faults[:5]) or "all", "all")
    gate("the planner that stayed saw frames in order", steady["fallen"] == 0 and steady["code"] == 0,
         f"{steady['fallen']} out of order, {steady['refused']} of its orders refused", "none")
    if run.paced:
        gate("the planner that stayed missed no frame", steady["missed"] == 0, steady["missed"], 0)
    gate("a new reader has a map within 1 s", run.new_reader is not None and run.new_reader < 1,
         "none" if run.new_reader is None else f"{run.new_reader:.2f} s", "1 s")
