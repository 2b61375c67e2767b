"""A ``~`` that the shell left in an option is the home folder."""

import pytest
from passafe_services.cli.home_folder import with_home


@pytest.mark.parametrize(
    ("argument", "expected"),
    [
        ("--out=~/runs", "--out=/home/ada/runs"),
        ("--robot=~/car.py:car", "--robot=/home/ada/car.py:car"),
        ("--out=~", "--out=/home/ada"),
        ("--out=~nobody-has-this-name/x", "--out=~nobody-has-this-name/x"),
        ("--set=a=~/b", "--set=a=~/b"),
        ("~/runs", "~/runs"),
        ("--out=runs~", "--out=runs~"),
    ],
)
def test_tilde_after_an_equals_sign(argument: str, expected: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/ada")

    assert with_home(argument) == expected
