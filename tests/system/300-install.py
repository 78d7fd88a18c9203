#!/usr/bin/python3
"""300: what is installed works: a planner outside the tree builds against it by CMake and pkg-config, the daemon finds its simulator.

SPDX-License-Identifier: Apache-2.0
"""
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

from programs import BIN, ROOT, isolated_main, wait_until

PLANNER = ROOT / "ipc/examples/planner.cpp"
INCREMENTAL = [ROOT / "ipc/examples" / name for name in ("incremental_planner.cpp", "planned.cpp", "followed_map.cpp", "navigation.cpp")]
C_CLIENT = ROOT / "tests/support/client_c.c"
PROJECT = f"""cmake_minimum_required(VERSION 3.25)
project(outside LANGUAGES CXX C)
find_package(vdisp 0.1 REQUIRED)
add_executable(planner {PLANNER})
add_executable(incremental {' '.join(map(str, INCREMENTAL))})
add_executable(client_c {C_CLIENT})
foreach(program planner incremental client_c)
  target_link_libraries(${{program}} PRIVATE vdisp::vdisp)
endforeach()
"""


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = pathlib.Path(cls.holder.name)
        cls.prefix = cls.folder / "prefix"
        cls.install()
        (cls.pc,) = cls.prefix.glob("lib/**/vdisp.pc")
        # Only the copy counts: nothing of the build folder, and not what another prefix holds.
        cls.environment = {**os.environ, "PKG_CONFIG_PATH": str(cls.pc.parent), "LD_LIBRARY_PATH": str(cls.pc.parent.parent)}

    @classmethod
    def install(cls):
        # As a packager does it, from the built tree.
        done = subprocess.run(["cmake", "--install", str(BIN.parent), "--prefix", str(cls.prefix)], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def call(self, *words, code=0, **options):
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=60,
                              env=self.environment, cwd=self.folder, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def flags(self):
        return self.call("pkg-config", "--cflags", "--libs", "vdisp").stdout.split()

    def assert_works_without_a_daemon(self, planner, *words):
        """The planner says dead and what to do, and stays alive."""
        output = self.folder / (planner.name + ".out")
        with open(output, "w") as file:
            process = subprocess.Popen([str(planner), *words], stdout=file, stderr=file, env=self.environment)
        try:
            self.assertTrue(wait_until(lambda: "\n" in output.read_text()), "it says nothing")
            time.sleep(0.3)
            self.assertIsNone(process.poll(), output.read_text())
        finally:
            process.kill()
            process.wait()
        self.assertRegex(output.read_text(), r"^dead: .*vdispd.*\n$")

    def test_programs_manuals_and_configuration_are_there(self):
        for name in ("bin/vdispd", "bin/vdisp-probe", "bin/vdisp-planner", "bin/vdisp-incremental-planner", "share/man/man1/vdispd.1",
                     "share/man/man1/vdisp-probe.1", "bin/vdisp-calibrate", "share/man/man1/vdisp-calibrate.1", "bin/vdisp-drive", "share/man/man1/vdisp-drive.1",
                     "bin/vdisp-train", "share/man/man1/vdisp-train.1",
                     "share/man/man5/vdisp.cfg.5", "share/man/man1/vdisp-planner.1", "share/man/man1/vdisp-incremental-planner.1",
                     "etc/vdisp/vdisp.cfg", "lib/systemd/system/vdispd.service", "lib/udev/rules.d/60-vdisp.rules", "lib/sysusers.d/vdisp.conf",
                     "lib/tmpfiles.d/vdisp.conf",
                     *(f"share/bash-completion/completions/{program}" for program in ("vdispd", "vdisp-probe", "vdisp-calibrate", "vdisp-train", "vdisp-drive"))):
            self.assertTrue((self.prefix / name).is_file(), name)
        headers = {path.name for path in (self.prefix / "include/vdisp").iterdir()}
        self.assertEqual(headers, {"client.h", "client_c.h", "command.h", "control.h", "control_c.h", "image.h", "records", "records.h"})
        self.assertEqual({path.name for path in (self.prefix / "include/vdisp/records").iterdir()}, {path.name for path in (ROOT / "ipc/records").iterdir()})

    def test_an_operators_configuration_is_never_written_over(self):
        mine = self.prefix / "etc/vdisp/vdisp.cfg"
        shipped = mine.read_text()
        mine.write_text("[main]\ndebug = 3\n")
        self.install()
        self.assertEqual(mine.read_text(), "[main]\ndebug = 3\n")
        mine.write_text(shipped)

    def test_each_header_compiles_alone_in_the_tree_and_installed(self):
        for include in (self.prefix / "include", ROOT / "ipc/include"):
            for name in ("client.h", "client_c.h", "command.h", "control.h", "control_c.h", "image.h", "records.h"):
                source = f"#include <vdisp/{name}>\n"
                self.call("g++", "-std=c++20", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{include}", "-xc++", "-", input=source)
            self.call("gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{include}", "-xc", "-",
                      input="#include <vdisp/client_c.h>\n#include <vdisp/control_c.h>\n")

    def test_find_package_builds_a_planner(self):
        (self.folder / "CMakeLists.txt").write_text(PROJECT)
        self.call("cmake", "-B", "outside", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.call("cmake", "--build", "outside")
        self.assert_works_without_a_daemon(self.folder / "outside/planner")
        self.assert_works_without_a_daemon(self.folder / "outside/incremental", "3", "0")
        self.assertIn("vdispd", self.call(self.folder / "outside/client_c").stdout)

    def test_pkg_config_builds_a_planner_and_gcc_a_c_client(self):
        self.call("g++", "-std=c++20", PLANNER, "-o", "planner_pc", *self.flags())
        self.assert_works_without_a_daemon(self.folder / "planner_pc")
        self.call("g++", "-std=c++20", *INCREMENTAL, "-o", "incremental_pc", *self.flags())
        self.assert_works_without_a_daemon(self.folder / "incremental_pc", "3", "0")
        self.call("gcc", C_CLIENT, "-o", "client_pc", *self.flags())
        self.assertIn("vdispd", self.call(self.folder / "client_pc").stdout)

    def test_the_library_exports_only_what_its_headers_declare(self):
        names = self.call("nm", "-DC", "--defined-only", self.pc.parent.parent / "libvdisp.so").stdout.splitlines()
        names = [name.split(maxsplit=2)[2] for name in names]
        self.assertIn("vdisp_open", names)
        allowed = ("vdisp_", "vdisp::Client::", "vdisp::Image::", "vdisp::Control::", "vdisp::exit_code(", "vdisp::name(", "vdisp::describe(", "vdisp::pixel_bytes(")
        self.assertEqual([name for name in names if not name.startswith(allowed)], [])

    def test_the_installed_planner_refuses_wrong_words_and_outlives_a_missing_daemon(self):
        planner = self.prefix / "bin/vdisp-planner"
        self.assertIn("usage: vdisp-planner", self.call(planner, "--nonsense", code=64).stderr)
        self.assert_works_without_a_daemon(planner)
        incremental = self.prefix / "bin/vdisp-incremental-planner"
        self.assertIn("usage: vdisp-incremental-planner", self.call(incremental, code=64).stderr)
        self.assert_works_without_a_daemon(incremental, "3", "0")

    def test_the_installed_daemon_finds_its_simulator(self):
        daemon = self.prefix / "bin/vdispd"
        self.assertFalse((daemon.parent / "vdisp_sim.so").exists())
        self.call(daemon, "--sim", "--frames", "2", "--set", "main.middleware=none", "--dump", "out")
        self.assertTrue((self.folder / "out/000001/map.png").is_file())


if __name__ == "__main__":
    isolated_main()
