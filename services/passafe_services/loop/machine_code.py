"""Machine code of CasADi's functions, by the C compiler of the machine: the same numbers to the last bit, and sooner.

What a gatekeeper rolls out takes a tenth of the time (``docs/decisions/0041-machine-code-of-rollouts.md``). The sources
are CasADi's own; products and sums are not fused, and nothing is reordered, so that a replay need not compile.
"""

import subprocess
from functools import lru_cache
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import Final

import casadi as ca

COMPILERS: Final = ("cc", "gcc", "clang")
"""Commands that are looked for, in this order."""

FLAGS: Final = ("-O1", "-ffp-contract=off", "-shared", "-fPIC")
"""A higher level takes longer to compile, and was faster in one of three designs only."""

LONGEST_S: Final = 60.0
"""Time after which a compiler is given up."""

KEPT: Final = 8
"""Functions of one process that are kept: designs that differ in a switch share them."""


def machine_code(function: ca.Function) -> ca.Function:
    """Return a function as machine code; itself where there is no C compiler, or where that one fails.

    Args:
        function: Of no external functions.
    """
    compiler = next(filter(None, map(which, COMPILERS)), None)
    return function if compiler is None else _compiled(function.name(), _source(function), compiler) or function


def _source(function: ca.Function) -> str:
    generator = ca.CodeGenerator(function.name())
    generator.add(function)
    return str(generator.dump())


@lru_cache(maxsize=KEPT)
def _compiled(name: str, source: str, compiler: str) -> ca.Function | None:
    with TemporaryDirectory(prefix="passafe-") as folder:
        library, written = Path(folder) / "function.so", Path(folder) / "function.c"
        written.write_text(source, encoding="utf-8")
        try:
            subprocess.run(  # noqa: S603 # the compiler by its full path, and files of our own
                [compiler, *FLAGS, "-o", str(library), str(written), "-lm"],
                check=True,
                capture_output=True,
                timeout=LONGEST_S,
            )
            return ca.external(name, str(library))
        except (OSError, subprocess.SubprocessError, RuntimeError):
            return None  # a folder that nothing may be run from, say: interpreted functions do as well
