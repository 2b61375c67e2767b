"""Mutations that look for code no input has reached yet (atheris): one target, for a number of seconds.

    python tests/fuzz/coverage_guided.py TARGET SECONDS [SEED]

An input that does harm ends it, and is kept as ``crash-…`` in the folder of the target's corpus; those that reached
something new are thrown away at the end.
"""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import atheris

with atheris.instrument_imports(include=["passafe", "passafe_protocol", "passafe_services"]):
    from fuzz_targets import CORPUS, TARGETS, survives, with_checksum

MOST_BYTES = 65_536
MOST_MB = 4096


def _read(name: str, data: bytes, folder: Path) -> None:
    survives(name, data, folder)
    if name == "codec":  # hardly any mutation has the right checksum
        survives(name, with_checksum(data[:-6]), folder)


def main() -> None:
    """Fuzz the target of the command line."""
    name, seconds, *seed = sys.argv[1:]
    if name not in TARGETS:
        raise SystemExit(f"target: got {name!r}, allowed {', '.join(TARGETS)}")
    with TemporaryDirectory() as kept:
        corpus, folder = Path(kept) / "corpus", Path(kept) / "files"
        shutil.copytree(CORPUS / name, corpus)
        folder.mkdir()
        options = {
            "max_total_time": seconds,
            "max_len": MOST_BYTES,
            "rss_limit_mb": MOST_MB,
            "seed": seed[0] if seed else 1,
            "artifact_prefix": f"{CORPUS / name}/",
            "verbosity": 0,
            "print_final_stats": 1,
        }
        atheris.Setup(
            [sys.argv[0], *(f"-{key}={value}" for key, value in options.items()), str(corpus)],
            lambda data: _read(name, data, folder),
        )
        atheris.Fuzz()


if __name__ == "__main__":
    main()
