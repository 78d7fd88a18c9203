#!/usr/bin/python3
"""415: the fault table tells of tests and counters that exist.

SPDX-License-Identifier: Apache-2.0
"""
import ast
import pathlib
import re
import unittest

from programs import ROOT

HERE = pathlib.Path(__file__).parent
COUNTER = re.compile(r"`(\w+_total)`")


def cases(file):
    """Class.test of a file of tests."""
    return {f"{part.name}.{case.name}" for part in ast.parse(file.read_text()).body if isinstance(part, ast.ClassDef)
            for case in part.body if isinstance(case, ast.FunctionDef) and case.name.startswith("test_")}


class FaultTable(unittest.TestCase):
    def setUp(self):
        lines = (ROOT / "docs/faults.md").read_text().splitlines()
        self.rows = [line.strip("|").split(" | ") for line in lines if line.startswith("| ") and not line.startswith(("| fault", "| ---"))]

    def test_every_fault_has_a_proof_that_is_there_and_is_run(self):
        self.assertGreater(len(self.rows), 25)
        listed = (HERE / "CMakeLists.txt").read_text()
        for row in self.rows:
            self.assertEqual(len(row), 5, row)
            file, proofs = None, 0
            for word in re.findall(r"`([^`]+)`", row[4]):
                if re.match(r"\d{3}-[\w-]+[.](py|sh)$", word):
                    file = HERE / word
                    self.assertTrue(file.exists(), f"{row[0]}: there is no {word}")
                    self.assertIn(f"({word} system ", listed)
                    proofs += 1
                elif ".test_" in word:
                    self.assertIn(word, cases(file), f"{row[0]}: {file.name} has no such test")
            self.assertGreater(proofs, 0, row[0])
            for name in {word for word in re.findall(r"`([^`]+)`", row[4]) if word.endswith(".py")}:
                self.assertRegex(row[4], f"`{re.escape(name)}` (`\\w+[.]test_|the same)", f"{row[0]}: which test of {name}?")

    def test_every_counter_is_one_of_the_daemon(self):
        told = (ROOT / "daemon/metrics.cpp").read_text()
        counters = {name for row in self.rows for name in COUNTER.findall(row[2])}
        self.assertGreater(len(counters), 8)
        for name in counters:
            self.assertIn(f'"{name}"', told)


if __name__ == "__main__":
    unittest.main(verbosity=2)
