"""The image of the Dockerfile, built on a base made from Debian packages, without a registry of images."""

import shutil
import subprocess
import sys
import tarfile
from pathlib import Path
from typing import Final

from podman_host import PodmanHost

ROOT: Final = Path(__file__).resolve().parents[2]
BASE: Final = "localhost/passafe-base:test"
IMAGE: Final = "localhost/passafe:test"
PIP: Final = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")


def import_debian_base(host: PodmanHost, folder: Path, suite: str) -> str:
    """Make the smallest Debian with Python, import it as ``BASE``, and return its version of Python."""
    tree = folder / "debian"
    command = ("debootstrap", "--variant=minbase", "--include=python3,python3-venv", suite, str(tree))
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr
    for left_over in ("var/cache/apt/archives", "var/lib/apt/lists", "usr/share/doc", "usr/share/locale"):
        shutil.rmtree(tree / left_over, ignore_errors=True)
    archive = folder / "debian.tar"
    with tarfile.open(archive, "w") as packed:
        packed.add(tree, ".")
    host.run("podman", "import", "--quiet", str(archive), BASE)
    [library] = tree.glob("usr/lib/python3.*")
    shutil.rmtree(tree)
    archive.unlink()
    return library.name.removeprefix("python")


def build_image(host: PodmanHost, folder: Path, python: str) -> None:
    """Build ``IMAGE`` without a network, from wheels that the package index of this machine provides."""
    wheels = folder / "wheels"
    own = folder / "own"
    subprocess.run([*PIP, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(own), str(ROOT)], check=True)
    [wheel] = own.glob("*.whl")
    pinned = ("--constraint", str(ROOT / "constraints.txt"))
    fetch = ("download", "--only-binary=:all:", "--python-version", python, *pinned, "--dest", str(wheels))
    subprocess.run([*PIP, *fetch, f"passafe[run] @ {wheel.as_uri()}", "hatchling"], check=True)
    arguments = {"BASE": BASE, "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "/wheels"}
    given = [word for name, value in arguments.items() for word in ("--build-arg", f"{name}={value}")]
    mounted = ("--network", "none", "--volume", f"{wheels}:/wheels:ro")
    host.run("podman", "build", "--tag", IMAGE, *given, *mounted, str(ROOT))
