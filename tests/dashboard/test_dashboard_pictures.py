import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from closed_form_series import run_series
from passafe_dashboard.pictures.__main__ import main, run_picture

SVG = "{http://www.w3.org/2000/svg}"


def test_the_picture_of_a_run_has_the_paper_s_plots() -> None:
    root = ET.fromstring(run_picture(run_series(), title="circle"))  # noqa: S314 - our own output
    words = [node.text for node in root.iter(f"{SVG}text")]
    for word in ("position p₂ (m)", "barrier h (m²)", "power margin (W)"):
        assert word in words
    description = root.findtext(f"{SVG}desc") or ""
    assert "disk lowest sample 0.44 at 7.854 s" in description
    assert "lowest sample 0.1 W at 9.425 s" in description


def test_a_run_without_barriers_has_a_taller_power_margin() -> None:
    series = run_series()
    text = run_picture(replace(series, h=series.h[:0], barriers=()), title="circle")
    words = [node.text for node in ET.fromstring(text).iter(f"{SVG}text")]  # noqa: S314 - our own output
    assert "power margin (W)" in words
    assert "barrier h (m)" not in words


def test_a_picture_is_small_enough_for_a_readme() -> None:
    assert len(run_picture(run_series(), title="circle")) < 150_000


def test_without_a_folder_the_usage_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "usage" in capsys.readouterr().err
