"""Settings of links as a user types them."""

from dataclasses import replace

import pytest
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import LinkState
from passafe_services.cli.errors import OptionError
from passafe_services.cli.link_text import LINK_KEYS, changed_parameters, link_fields, require_ranges, settings_text
from passafe_services.cli.options import scenario_from_options
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.link_schema import ScenarioLink


def test_every_setting_has_a_key() -> None:
    assert sorted(LINK_KEYS.values()) == sorted(ScenarioLink.model_fields)


def test_all_keys_reach_the_scenario() -> None:
    text = (
        "plant-to-operator:delay=0.2,jitter=0.02,distribution=normal,correlation=0.5,reorder=false,loss=0.1,"
        "burst-enter=0.01,burst-leave=0.2,burst-loss-good=0.001,burst-loss-bad=0.9,duplicate=0.1,corrupt=0.05,"
        "rate=500,queue=10,outage=2:2.5+5:6,seed=3"
    )
    link = scenario_from_options("notomista-cai-2020", links=[text]).links["plant-to-operator"]

    assert link == ScenarioLink(
        delay_s=0.2,
        jitter_s=0.02,
        distribution="normal",
        correlation=0.5,
        reorder=False,
        loss=0.1,
        burst_enter=0.01,
        burst_leave=0.2,
        burst_loss_good=0.001,
        burst_loss_bad=0.9,
        duplicate=0.1,
        corrupt=0.05,
        rate_hz=500.0,
        queue=10,
        outages_s=((2.0, 2.5), (5.0, 6.0)),
        seed=3,
    )


def test_histogram_and_empty_lists_can_be_typed() -> None:
    assert link_fields(["distribution=histogram", "quantiles=0.01+0.02+0.1"], "--link") == {
        "distribution": "histogram",
        "quantiles_s": [0.01, 0.02, 0.1],
    }
    assert link_fields(["outage=", "quantiles="], "--link") == {"outages_s": [], "quantiles_s": []}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("nonsense", "NAME:KEY=VALUE"),
        ("plant-to-filter:delai=1", "burst-leave"),
        ("plant-to-filter:delay", "KEY=VALUE"),
        ("plant-to-filter:", "KEY=VALUE"),
    ],
)
def test_text_of_another_form_is_refused(text: str, named: str) -> None:
    with pytest.raises(OptionError) as caught:
        scenario_from_options("notomista-cai-2020", links=[text])

    assert named in str(caught.value)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("filter-to-moon:delay=1", "filter-to-moon"),
        ("plant-to-filter:delay=soon", "delay_s"),
        ("plant-to-filter:outage=3", "outages_s"),
        ("plant-to-filter:reorder=perhaps", "reorder"),
    ],
)
def test_value_out_of_range_is_refused_with_its_field(text: str, named: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        scenario_from_options("notomista-cai-2020", links=[text])

    assert named in str(caught.value)


FULL = LinkSettings(
    delay_s=0.2,
    jitter_s=0.02,
    distribution="pareto",
    correlation=0.5,
    reorder=False,
    loss=0.1,
    outages_s=((2.0, 2.5), (5.0, 6.0)),
    queue=10,
)


def state_of(settings: LinkSettings) -> LinkState:
    return MessageLink("plant-to-filter", settings).state("period", ())


def test_settings_are_printed_as_they_are_typed() -> None:
    text = settings_text(state_of(FULL))

    assert text == (
        "delay=0.2 jitter=0.02 distribution=pareto correlation=0.5 reorder=false loss=0.1 queue=10 outage=2:2.5+5:6"
    )
    assert changed_parameters(LinkSettings(), link_fields(text.split(), "x"), "x") == parameters_of(FULL)
    table = LinkSettings(distribution="histogram", quantiles_s=(0.0, 0.5))
    assert settings_text(state_of(table)) == "distribution=histogram quantiles=0+0.5"
    assert settings_text(state_of(LinkSettings())) == "unimpaired"
    assert settings_text(state_of(LinkSettings(trace_s=(0.1, 0.2)))) == "trace of 2 times"


def test_settings_that_are_not_named_stay() -> None:
    changed = changed_parameters(FULL, link_fields(["loss=0.3", "outage="], "x"), "x")

    assert settings_of(changed) == replace(FULL, loss=0.3, outages_s=())


@pytest.mark.parametrize("typed", ["delay=soon", "loss=2", "distribution=gamma", "outage=3", "queue=0"])
def test_range_is_checked_before_any_process_is_asked(typed: str) -> None:
    with pytest.raises(OptionError, match=r"link x: got .*, allowed"):
        require_ranges(link_fields([typed], "x"), "link x")


@pytest.mark.parametrize(
    ("typed", "named"),
    [
        ("delay=soon", "delay_s 'soon'"),
        ("loss=2", "loss 2"),
        ("distribution=histogram", "quantiles_s (), allowed 2 to 64 non-decreasing numbers"),
        ("outage=3:1", "outages_s"),
    ],
)
def test_invalid_settings_are_refused_in_one_line(typed: str, named: str) -> None:
    with pytest.raises(OptionError) as caught:
        changed_parameters(LinkSettings(), link_fields([typed], "x"), "link plant-to-filter")

    assert named in str(caught.value)
    assert "\n" not in str(caught.value)
