"""``passafe scenarios``: list the shipped scenarios."""

from rich.console import Console
from rich.table import Table

from passafe_services.scenarios.load import load_scenario, shipped_scenarios


def scenarios() -> None:
    """List the scenarios that come with passafe; any command takes their names after `--scenario`."""
    table = Table("name", "title", "rate", "duration")
    for name in shipped_scenarios():
        scenario = load_scenario(name)
        table.add_row(name, scenario.title, f"{scenario.rate_hz:g} Hz", f"{scenario.duration_s:g} s")
    Console().print(table)
