"""A slice of the fault campaign: two faults of one run, judged as in the table."""

from pathlib import Path
from random import Random

import pytest
from fault_rows import ending, from_strangers, survived
from fault_runs import STRANGERS, run_through
from fault_table import table

SLICE = ("wall clock −1 h, then back, filter", "forged, epoch 2⁶⁴ − 1, input")


@pytest.mark.live
@pytest.mark.alone
def test_faults_of_a_run_break_no_promise(tmp_path: Path) -> None:
    faults = [fault for fault in (*survived(), *from_strangers()) if fault.key in SLICE]

    results = run_through(faults, Random(7), tmp_path, *STRANGERS)

    assert {result.fault for result in results} == set(SLICE)
    assert [result.broken for result in results] == [[], []], results
    assert all(result.h_min is not None and result.h_min >= 0 for result in results)
    assert "**0 broken promises**" in table([results])


def test_every_row_has_a_key_of_its_own() -> None:
    keys = [fault.key for fault in (*survived(), *from_strangers(), *ending())]

    assert len(set(keys)) == len(keys)
    assert all(fault.promise for fault in (*survived(), *from_strangers(), *ending()))
