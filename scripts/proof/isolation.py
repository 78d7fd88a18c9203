# isolation.py: /tmp, /dev/shm and /run of one's own: there is one daemon on a machine, and it may be in service.
# SPDX-License-Identifier: Apache-2.0
import ctypes
import os
import pathlib
import subprocess

PRIVATE = ("/tmp", "/dev/shm", "/run")
NEW_MOUNTS = 0x20000  # CLONE_NEWNS


class NotPermitted(Exception):
    """This user may not have namespaces of mounts."""


def private_folders(kept=()):
    """From here on this process and its children have PRIVATE for themselves, empty. `kept`: paths that would be gone with them; where
    there is one, ValueError names it. What was opened before stays open."""
    for path in kept:
        for folder in PRIVATE:
            if pathlib.Path(path).resolve().is_relative_to(folder):
                raise ValueError(f"{path} lies under {folder}, which is a private one here; name another place")
    system = ctypes.CDLL(None, use_errno=True)
    if system.unshare(NEW_MOUNTS) != 0:
        raise NotPermitted(f"a namespace of mounts: {os.strerror(ctypes.get_errno())}; run it as root")
    for words in [["--make-rprivate", "/"]] + [["-t", "tmpfs", "-o", "mode=1777", "none", folder] for folder in PRIVATE]:
        done = subprocess.run(["mount", *words], stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise NotPermitted(done.stderr.strip() + "; run it as root")
