#!/usr/bin/python3
"""410: units, udev rules, users and packaging files: what systemd's own tools find in them, and that they say what the programs do.

SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from programs import BIN, ROOT, run

UNITS = ROOT / "systemd"
PACKAGING = ROOT / "scripts/packaging"
WORST = 2.5


def directives(text):
    return [line.split("=", 1) for line in text.splitlines() if re.match(r"[A-Z]\w*=", line)]


@unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed (package systemd)")
class Units(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.units = {}
        for source in sorted(UNITS.glob("*.service.in")):
            unit = self.folder / source.stem
            # As installed: the programs are there.
            text = re.sub(r"@CMAKE_INSTALL_FULL_BINDIR@/(\S+)", lambda m: str(BIN / m[1]) if (BIN / m[1]).exists() else "/bin/true", source.read_text())
            self.assertNotIn("@", re.sub(r"~?@[a-z-]+", "", "\n".join(v for k, v in directives(text))))
            unit.write_text(text)
            self.units[unit] = text

    def test_there_are_two(self):
        self.assertEqual([unit.name for unit in self.units], ["vdisp-drive.service", "vdispd.service"])

    def test_verify_is_silent(self):
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", *self.units], capture_output=True, text=True, timeout=30)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_security_is_at_most_2_5_and_every_remaining_point_is_explained(self):
        for unit, text in self.units.items():
            done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", f"--threshold={int(WORST * 10)}", unit],
                                  capture_output=True, text=True, timeout=30)
            self.assertEqual(done.returncode, 0, done.stdout[-200:] + done.stderr)
            level = float(re.search(r"Overall exposure level for \S+: ([\d.]+)", done.stdout)[1])
            self.assertLessEqual(level, WORST)
            print(f"{unit.name}: {level}")
            comments = "\n".join(line for line in text.splitlines() if line.startswith("#"))
            for line in done.stdout.splitlines():
                if not line.startswith("✗"):
                    continue
                what, points = line.split()[1], line.split()[-1]
                directive, _, value = what.partition("=")
                names = [directive] + re.findall(r"AF_[A-Z]+|@\w+", value.replace("(INET|INET6)", "INET"))
                for name in names:
                    self.assertIn(name, comments, f"{unit.name}: {what} costs {points}, and no comment says why")

    def test_the_service_is_as_the_daemon_needs_it(self):
        said = dict(directives(self.units[self.folder / "vdispd.service"]))
        self.assertEqual((said["Type"], said["Restart"], said["User"], said["Group"]), ("notify", "always", "vdisp", "vdisp"))
        self.assertGreaterEqual(int(re.fullmatch(r"(\d+)ms", said["RestartSec"])[1]), 100)
        self.assertGreater(int(said["WatchdogSec"]), 2)  # silence of iceoryx is known after 2 s
        self.assertNotIn("PrivateTmp", said)
        self.assertTrue({"/tmp", "/dev/shm"} <= set(said["ReadWritePaths"].split()))
        # With wrong options and a wrong configuration it does not try again: the codes are the daemon's.
        self.assertEqual(said["RestartPreventExitStatus"].split(),
                         [str(run("vdispd", *words).returncode) for words in (["--nonsense"], ["--set", "main.threads=none"])])

    def test_what_the_docs_have_the_service_write_is_open_in_its_sandbox_or_by_the_drop_in_that_stands_there(self):
        said = dict(directives(self.units[self.folder / "vdispd.service"]))
        own = [f"/var/lib/{said['StateDirectory']}", *said["ReadWritePaths"].replace("-/", "/").split()]
        for page, key in (("health.md", "metrics"), ("recording.md", "folder")):
            text = (ROOT / "docs" / page).read_text()
            dropped_in = re.findall(r"ReadWritePaths=([\w/.-]+)", text)
            self.assertTrue(dropped_in, page)
            for place in re.findall(rf"`(?:\[\w+\] )?{key} = (/[\w/.-]+)`", text):
                self.assertTrue(any(place.startswith(folder + "/") for folder in own + dropped_in), f"{page}: {place} is closed by {own}")
        # As systemd understands it beside the unit.
        folder = self.folder / "vdispd.service.d"
        folder.mkdir()
        for block in re.findall(r"(?s)```ini\n(\[Service\]\n.*?)```", (ROOT / "docs/health.md").read_text()):
            (folder / "override.conf").write_text(block)
            done = subprocess.run(["systemd-analyze", "verify", "--man=no", self.folder / "vdispd.service"], capture_output=True, text=True, timeout=30)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_the_motor_link_gets_serial_ports_and_no_network(self):
        text = self.units[self.folder / "vdisp-drive.service"]
        said = dict(directives(text))
        self.assertEqual((said["PrivateNetwork"], said["DevicePolicy"], said["RestrictAddressFamilies"]), ("yes", "closed", "AF_UNIX"))
        devices = [value for key, value in directives(text) if key == "DeviceAllow"]
        self.assertTrue(devices and all(device.startswith("char-tty") for device in devices), devices)
        self.assertNotEqual(said["User"], "vdisp")  # RemoveIPC would take the daemon's memory when this one ends

    def test_users_are_made_in_the_groups_that_the_units_name(self):
        root = self.folder / "root"
        (root / "etc").mkdir(parents=True)
        (root / "etc/group").write_text("root:x:0:\nvideo:x:44:\ndialout:x:20:\n")
        (root / "etc/passwd").write_text("root:x:0:0::/root:/bin/sh\n")
        subprocess.run(["systemd-sysusers", f"--root={root}", UNITS / "vdisp.sysusers"], check=True, capture_output=True)
        groups = {line.split(":")[0]: line.split(":")[3].split(",") for line in (root / "etc/group").read_text().splitlines()}
        for unit in self.units.values():
            said = dict(directives(unit))
            self.assertIn(f"\n{said['User']}:x:", (root / "etc/passwd").read_text())
            self.assertIn(said["Group"], groups)
            for group in said["SupplementaryGroups"].split():
                self.assertIn(said["User"], groups[group])

    def test_tmpfiles_are_understood_and_keep_what_iceoryx_has_in_tmp(self):
        root = self.folder / "root"
        (root / "etc/vdisp").mkdir(parents=True)
        (root / "etc/vdisp/vdisp.cfg").touch()
        (root / "etc/vdisp/vdisp.cfg").chmod(0o664)
        (root / "etc/vdisp").chmod(0o775)
        (root / "etc/passwd").write_text("root:x:0:0::/root:/bin/sh\nvdisp:x:777:778::/:/bin/sh\n")
        (root / "etc/group").write_text("root:x:0:\nvdisp:x:778:\n")
        def create():
            done = subprocess.run(["systemd-tmpfiles", f"--root={root}", "--create", UNITS / "vdisp.tmpfiles"], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
        create()
        (root / "etc/vdisp/vdisp.cfg").unlink()  # as an editor of root's leaves it
        (root / "etc/vdisp/vdisp.cfg").touch()
        create()
        config, folder = (root / "etc/vdisp/vdisp.cfg").stat(), (root / "etc/vdisp").stat()
        # `vdisp-probe save` is the daemon's to do; members of its group, readers and vdisp-drive, may read alone.
        self.assertEqual((config.st_uid, config.st_gid, folder.st_uid, folder.st_gid), (777, 0, 777, 0))
        self.assertEqual((config.st_mode & 0o777, folder.st_mode & 0o777), (0o644, 0o755))
        kept = re.findall(r"^x (\S+)$", (UNITS / "vdisp.tmpfiles").read_text(), re.M)
        sources = (ROOT / "ipc/shm_check.cpp").read_text() + (ROOT / "ipc/endpoint.h").read_text()
        for name in set(re.findall(r'"(/tmp/[\w.-]+)"', sources)):
            self.assertIn(name, kept)

    def test_udev_rules_have_no_dead_ends(self):
        rules = (UNITS / "60-vdisp.rules").read_text()
        text = "\n".join(line for line in rules.splitlines() if line and not line.startswith("#"))
        self.assertEqual(set(re.findall(r'GOTO="(\w+)"', text)), set(re.findall(r'LABEL="(\w+)"', text)))
        for line in text.splitlines():
            for part in re.split(r", ", line):
                self.assertRegex(part, r'^[A-Z]+(\{[\w/]+\})?(==|!=|=|\+=)"[^"]*"$', line)
        self.assertEqual({"usb3vision", "v4l2", "iidc"}, set(re.findall(r'ENV\{VDISP_CAMERA\}="(\w+)"', text)))
        self.assertEqual(set(re.findall(r'GROUP="(\w+)"', text)), {"video"})


class Completion(unittest.TestCase):
    def words(self, *line):
        script = f"""PATH={BIN}:$PATH; source {PACKAGING}/completion.bash
            COMP_WORDS=("$@"); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
            _vdisp "$1" "${{COMP_WORDS[COMP_CWORD]}}" "${{COMP_WORDS[COMP_CWORD-1]}}" 2>/dev/null; printf '%s\\n' "${{COMPREPLY[@]}}" """
        done = subprocess.run(["bash", "-c", script, "bash", *line], capture_output=True, text=True, timeout=30)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split("\n")[:-1]

    def test_words_and_options_are_those_of_the_programs(self):
        self.assertIn("view", self.words("vdisp-probe", "vi"))
        self.assertEqual(self.words("vdisp-probe", "vie"), ["view"])
        self.assertIn("--stage", self.words("vdisp-probe", "view", "--st"))
        self.assertIn("--check-config", self.words("vdispd", "--c"))
        self.assertIn("plain", self.words("vdispd", "--cpu", ""))
        self.assertEqual(self.words("vdisp-train", "eval"), ["evaluate"])
        self.assertIn("--hold-out", self.words("vdisp-train", "train", "--ho"))
        self.assertIn("--allow-synthetic", self.words("vdisp-drive", "--al"))

    def test_every_program_is_completed_and_folders_for_options_that_write_one(self):
        script = (PACKAGING / "completion.bash").read_text()
        completed = re.search(r"^complete -F _vdisp (.+)$", script, re.M)[1].split()
        pages = {path.stem for path in (ROOT / "docs/man").glob("*.1")}
        self.assertEqual(pages - set(completed), {"vdisp-planner", "vdisp-incremental-planner"})  # examples
        with tempfile.TemporaryDirectory() as place:
            (pathlib.Path(place) / "folder").mkdir()
            (pathlib.Path(place) / "file").touch()
            for option in ("--dump", "--record"):
                self.assertEqual(self.words("vdispd", option, f"{place}/f"), [f"{place}/folder"])


class Scripts(unittest.TestCase):
    def test_maintainer_scripts_are_scripts_that_stop_at_faults(self):
        for name in ("postinst", "prerm", "postrm"):
            script = PACKAGING / "vdisp" / name
            self.assertEqual(subprocess.run(["sh", "-n", script]).returncode, 0)
            self.assertIn("\nset -e\n", script.read_text())
            self.assertTrue(script.stat().st_mode & 0o100)

    def test_the_changelog_begins_with_the_version_of_the_project(self):
        version = re.search(r"project\(vdisp VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertTrue((PACKAGING / "changelog").read_text().startswith(f"vdisp ({version}-1) "))


if __name__ == "__main__":
    unittest.main(verbosity=2)
