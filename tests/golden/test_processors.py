"""Decisions are the same to the last bit whatever processor BLAS and NumPy take this one for."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SCRIPT = Path(__file__).parent / "decision_digests.py"
KERNELS = {"Prescott": "X86_V2", "Haswell": "X86_V3", "SkylakeX": "X86_V4"}
"""Kernels of OpenBLAS, oldest first, and NumPy's name of the instructions that each needs."""


def simd_extensions() -> list[str]:
    """Return NumPy's names of the instructions that this processor has and NumPy can do without."""
    config: Any = np.show_config(mode="dicts")
    return list(config["SIMD Extensions"]["found"])


def environments() -> list[dict[str, str]]:
    extensions = simd_extensions()
    kernels = [kernel for kernel, needs in KERNELS.items() if needs == "X86_V2" or needs in extensions]
    plain = {"NPY_DISABLE_CPU_FEATURES": " ".join(extensions)} if extensions else {}
    return [{}, {"OPENBLAS_CORETYPE": "Prescott"} | plain, *({"OPENBLAS_CORETYPE": each} for each in kernels[1:])]


def test_kernel_of_blas_decides_nothing() -> None:
    if sys.platform != "linux" or os.uname().machine != "x86_64":
        pytest.skip("OPENBLAS_CORETYPE names kernels of x86-64")
    command = [sys.executable, str(SCRIPT)]
    answers = [
        subprocess.run(command, env=os.environ | environment, check=True, capture_output=True, text=True)
        for environment in environments()
    ]
    first, *others = (json.loads(answer.stdout) for answer in answers)
    assert len(others) >= 1
    for environment, digests in zip(environments()[1:], others, strict=True):
        assert digests == first, f"under {environment}"
