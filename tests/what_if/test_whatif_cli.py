"""``passafe whatif`` at the terminal."""

import json
from pathlib import Path

import pytest
from click.testing import Result
from passafe_services.cli import what_if_search
from passafe_services.cli.app import app
from passafe_services.cli.errors import OptionError
from passafe_services.cli.what_if_options import field_of, interval_of, overrides_of
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.search import Trial
from typer.testing import CliRunner

from passafe.errors import PassafeError

GOLDEN = Path(__file__).parents[1] / "golden"
LOG = str(GOLDEN / "reference.mcap")


def asked(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["whatif", *arguments], env={"COLUMNS": "120"})


def refused(*arguments: str) -> str:
    result = asked(*arguments)
    assert isinstance(result.exception, PassafeError), result.output
    return str(result.exception)


def test_nothing_changed_exits_with_0_and_says_so(tmp_path: Path) -> None:
    result = asked(str(GOLDEN / "reference-off.mcap"), "--out", str(tmp_path / "out.mcap"))
    assert result.exit_code == 0
    assert "states are those of the log to the last bit" in result.output
    assert "the person does not react to what happens here" in result.output


def test_change_is_explained_as_json_picture_and_page(tmp_path: Path) -> None:
    svg, html = tmp_path / "both.svg", tmp_path / "both.html"
    result = asked(
        LOG, "--mode", "off", "--out", str(tmp_path / "o.mcap"), "--svg", str(svg), "--html", str(html), "--json"
    )
    assert result.exit_code == 0
    data = json.loads(result.stdout)
    assert data["what_if"]["changes"] == ["filter.mode both -> off"]
    assert data["what_if"]["first_difference"]["cause"] == "filter.mode both -> off"
    assert len(data["comparison"]["runs"]) == 2
    for text in (svg.read_text("utf-8"), html.read_text("utf-8")):
        assert "the person does not react" in text
        assert "what if" in text
    assert "http://" not in html.read_text("utf-8").replace("http://www.w3.org", "")
    assert RunLog.read(tmp_path / "o.mcap").identity.scenario.filter.mode == "off"


def test_bad_options_are_one_clear_line(tmp_path: Path) -> None:
    out = ("--out", str(tmp_path / "out.mcap"))
    assert "--out: got nothing, allowed a file" in refused(LOG)
    assert f"allowed another file than {LOG}, which is read" in refused(LOG, "--out", LOG)
    assert "--set: got 'k_i', allowed KEY=VALUE" in refused(LOG, "--set", "k_i", *out)
    assert "filter.k_j: got an unknown key" in refused(LOG, "--set", "filter.k_j=3", *out)
    assert "did you mean human?" in refused(LOG, "--operator", "humn", *out)
    assert "--links: got 'lost', allowed recorded, drawn" in refused(LOG, "--links", "lost", *out)
    assert "--search: got 'filter.k_i=1', allowed KEY=LOW..HIGH" in refused(LOG, "--search", "filter.k_i=1")
    assert "a lower end below the upper one" in refused(LOG, "--search", "filter.k_i=5..1")
    assert "filter.k_j: got an unknown key" in refused(LOG, "--set", "filter.k_j=3")
    assert "both ends finite" in refused(LOG, "--search", "filter.k_i=1..1e400")
    assert "both ends finite" in refused(LOG, "--search", "filter.k_i=nan..1")
    assert "--tolerance: got 0, allowed" in refused(LOG, "--search", "filter.k_i=1..5", "--tolerance", "0")


def test_values_are_toml_or_text() -> None:
    found = overrides_of(
        ("filter.prediction=false", "barriers.disk.radius=1.5", "name=abc"),
        ("plant-to-filter:delay=0.1",),
        mode="off",
        law=None,
        operator="{kind='constant', value=[1, 0]}",
    )
    assert found == {
        "filter.prediction": False,
        "filter.barriers.disk.radius": 1.5,
        "name": "abc",
        "links.plant-to-filter.delay_s": 0.1,
        "filter.mode": "off",
        "operator.source": {"kind": "constant", "value": [1, 0]},
    }
    csv = overrides_of((), (), mode=None, law=None, operator="drive.csv")["operator.source"]
    assert csv == {"kind": "recorded", "path": str(Path("drive.csv").absolute())}


def test_link_keys_of_a_search_are_those_of_links() -> None:
    assert interval_of("link.plant-to-filter.delay=0..0.5")[1:] == ("links.plant-to-filter.delay_s", 0.0, 0.5)
    with pytest.raises(OptionError, match="did you mean delay"):
        field_of("link.plant-to-filter.dellay", "--set")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ("--set filter.k_i=5 --set filter.k_i=6", "--set: got filter.k_i with filter.k_i given already, allowed each"),
        ("--set barriers.disk.radius=1 --set filter.barriers.disk.radius=2", "--set: got filter.barriers.disk.radius"),
        ("--set filter.mode=off --mode both", "--mode: got filter.mode"),
        ("--set filter.law=sampled --law continuous", "--law: got filter.law"),
        ("--set link.plant-to-filter.delay=1 --link plant-to-filter:delay=2", "--link: got links.plant-to-filter."),
        ("--link plant-to-filter:delay=1 --link plant-to-filter:delay=2", "--link: got links.plant-to-filter.delay_s"),
        ("--link plant-to-filter:delay=1,delay=2", "--link: got delay again: 'delay=2', allowed each setting once"),
        ("--set operator.source.gain=2 --operator {kind='constant',value=[1,0]}", "got operator.source with operator."),
        ("--set filter={} --set filter.k_i=5", "--set: got filter.k_i with filter given already"),
        ("--set filter.k_i=5 --search filter.k_i=1..5", "--search: got filter.k_i with filter.k_i given already"),
        ("--mode off --search filter.mode=1..5", "--search: got filter.mode with filter.mode given already"),
        ("--link plant-to-filter:delay=1 --search link.plant-to-filter.delay=0..1", "--search: got links.plant-to-"),
    ],
)
def test_key_is_set_by_one_option_only(arguments: str, problem: str) -> None:
    assert problem in refused(LOG, *arguments.split())


@pytest.mark.parametrize(
    ("setting", "problem"),
    [
        ("filter.k_i=", "filter.k_i: got '', allowed a number"),
        ("=3", "--set: got '=3', allowed KEY=VALUE"),
        ("link.plant-to-filter.dellay=3", "--set: got 'link.plant-to-filter.dellay', allowed link.NAME.SETTING"),
    ],
)
def test_setting_without_key_or_value_is_refused(setting: str, problem: str, tmp_path: Path) -> None:
    assert problem in refused(LOG, "--set", setting, "--out", str(tmp_path / "out.mcap"))


def test_search_of_which_all_is_refused_has_no_result() -> None:
    text = refused(LOG, "--search", "filter.k_j=1..5")
    assert text.startswith("--search: got 'filter.k_j' with 5 values, all refused, allowed values that a scenario may")
    assert "filter.k_j: got an unknown key" in text


@pytest.mark.campaign
def test_search_finds_where_the_verdict_changes() -> None:
    result = asked(
        str(GOLDEN / "unpredicted.mcap"), "--search", "link.plant-to-filter.delay=0..0.4", "--runs", "7", "--json"
    )
    data = json.loads(result.stdout)
    assert [trial["value"] for trial in data["trials"][:2]] == [0.0, 0.1]
    assert 5 <= len(data["trials"]) <= 7
    assert result.exit_code == (0 if data["is_finished"] else 1)


def test_value_that_the_scenario_refuses_is_an_outcome() -> None:
    result = asked(LOG, "--search", "filter.k_i=100..200", "--runs", "2", "--json")
    first, second = json.loads(result.stdout)["trials"]
    assert (first["verdict"], second["verdict"]) == ("holds", "refused")
    assert "allowed below rate_hz" in second["words"]


def test_interrupted_search_exits_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: object, value: float) -> Trial:
        if value > 0:
            raise KeyboardInterrupt
        return Trial(value=value, verdict="holds", h_min=1.0, words="")

    monkeypatch.setattr(what_if_search.SearchedRun, "__call__", interrupted)
    result = asked(LOG, "--search", "filter.k_i=0..1")
    assert result.exit_code == 130
    assert "no change of the verdict found" in result.output
