#!/usr/bin/python3
"""120: the machine has no say in the results: instruction sets and threads, forced, give the same files.

SPDX-License-Identifier: Apache-2.0
"""
import re

from programs import ProgramTest, isolated_main, run

SIM = ["--sim", "--frames", 4, "--set", "main.middleware=none", "--set", "sim.scene=obstacles", "--set", "sim.rate=0"]
SMALL = ["image source.ndisp=32", "sim.width=320", "sim.height=240"]
MATCHERS = [[],
            ["image source.prefilter=log", "image source.smooth=median", *SMALL],
            ["image source.matcher=census", "image source.smooth=mean", *SMALL],
            ["image source.matcher=census", "image source.census=5x5", *SMALL],
            ["image source.matcher=sgm", *SMALL],
            ["image source.matcher=sgm", "image source.paths=8", *SMALL]]


def levels():
    """The instruction sets of this machine, simplest first, as --version tells them."""
    return re.search(r"^instruction sets here: (.+)$", run("vdispd", "--version").stdout, re.M)[1].split(", ")


class Machine(ProgramTest):
    runs = 0

    def dump(self, sets, *arguments):
        """Every file of a run but the times."""
        Machine.runs += 1
        folder = self.folder / str(Machine.runs)
        result = run("vdispd", *SIM, "--dump", folder, *(word for item in sets for word in ("--set", item)), *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        files = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != "timing.json"}
        self.assertGreater(len(files), 4 * 10)
        return files

    def assert_same(self, one, other):
        self.assertEqual(sorted(one), sorted(other))
        self.assertEqual([str(path) for path in one if one[path] != other[path]], [])

    def test_an_unknown_instruction_set_is_64_and_names_those_there_are(self):
        self.assert_refused(run("vdispd", "--sim", "--cpu", "mmx"), 64, "--cpu", "mmx", *levels())
        self.assert_refused(run("vdispd", "--sim", "--cpu", ""), 64, "--cpu", *levels())

    def test_an_instruction_set_of_another_machine_is_64(self):
        foreign = next(level for level in ("neon", "avx2") if level not in levels())
        self.assert_refused(run("vdispd", "--sim", "--cpu", foreign), 64, foreign, "plain")

    def test_help_lists_the_instruction_sets(self):
        self.assertEqual(levels()[0], "plain")
        self.assertIn(", ".join(levels()), " ".join(run("vdispd", "--help").stdout.split()))

    def test_every_instruction_set_gives_the_same_files(self):
        for sets in MATCHERS:
            plain = self.dump(sets, "--cpu", "plain")
            for level in levels()[1:]:
                with self.subTest(level=level, sets=sets):
                    self.assert_same(plain, self.dump(sets, "--cpu", level))

    def test_every_number_of_threads_gives_the_same_files(self):
        for sets in MATCHERS:
            one = self.dump(sets, "--set", "main.threads=1")
            for threads in (2, 3, 16):
                with self.subTest(threads=threads, sets=sets):
                    self.assert_same(one, self.dump(sets, "--set", f"main.threads={threads}"))

    def test_the_log_tells_level_and_threads(self):
        def log(*arguments):
            return run("vdispd", *SIM, "--set", "main.debug=2", "--set", "main.threads=3", *arguments).stderr
        self.assertRegex(log("--cpu", "plain"), "kernels for plain, threads: 3")
        self.assertRegex(log(), f"kernels for {levels()[-1]}, threads: 3")


if __name__ == "__main__":
    isolated_main()
