"""Every setting has its range, and says so."""

from math import inf, nan

import pytest
from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link_settings import MAX_DELAY_S, RANGES, LinkSettings


@pytest.mark.parametrize(
    ("field", "got"),
    [
        ("delay_s", -1e-9),
        ("delay_s", MAX_DELAY_S * 1.001),
        ("delay_s", nan),
        ("delay_s", inf),
        ("delay_s", "0.1"),
        ("delay_s", True),
        ("jitter_s", -0.1),
        ("jitter_s", nan),
        ("jitter_s", None),
        ("correlation", 1.0),
        ("loss", -0.1),
        ("loss", 1.0001),
        ("loss", nan),
        ("burst_enter", 2.0),
        ("burst_leave", -0.5),
        ("duplicate", 1.5),
        ("corrupt", "no"),
        ("rate_hz", -1.0),
        ("rate_hz", 1e-6),
        ("rate_hz", 1e7),
        ("queue", 0),
        ("queue", 10.0),
        ("queue", 10**7),
        ("distribution", "gamma"),
        ("distribution", None),
        ("reorder", 1),
        ("seed", -1),
        ("seed", 2**64),
        ("seed", 1.0),
        ("seed", False),
        ("quantiles_s", (0.0, 1.0)),
        ("outages_s", ((1.0, 0.5),)),
        ("outages_s", ((1.0, 1.0),)),
        ("outages_s", ((1.0, 2.0), (1.5, 3.0))),
        ("outages_s", ((1.0,),)),
        ("outages_s", ((0.0, 1e9),)),
        ("outages_s", ((-1.0, 1.0),)),
        ("outages_s", ((0.0, nan),)),
        ("outages_s", tuple((float(i), i + 0.5) for i in range(65))),
        ("trace_s", (0.0,)),
        ("trace_s", (2.0, 1.0)),
        ("trace_s", (0.5, "1")),
        ("trace_s", (0.5, inf)),
    ],
)
def test_setting_outside_its_range_is_refused(field: str, got: object) -> None:
    with pytest.raises(LinkSettingsError, match="allowed ") as caught:
        LinkSettings(**{field: got})

    assert caught.value.field == field
    assert caught.value.got is got
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "field"),
    [
        ({"distribution": "histogram"}, "quantiles_s"),
        ({"distribution": "histogram", "quantiles_s": (0.1,)}, "quantiles_s"),
        ({"distribution": "histogram", "quantiles_s": (0.2, 0.1)}, "quantiles_s"),
        ({"distribution": "histogram", "quantiles_s": tuple([0.1] * 65)}, "quantiles_s"),
        ({"distribution": "histogram", "quantiles_s": (0.1, 0.2), "jitter_s": 0.1}, "jitter_s"),
        ({"trace_s": (0.1, 0.2), "rate_hz": 10.0}, "rate_hz"),
    ],
)
def test_settings_that_contradict_one_another_are_refused(settings: dict[str, object], field: str) -> None:
    with pytest.raises(LinkSettingsError) as caught:
        LinkSettings(**settings)

    assert caught.value.field == field


@pytest.mark.parametrize("field", RANGES)
def test_limits_are_allowed(field: str) -> None:
    for limit in RANGES[field]:
        assert getattr(LinkSettings(**{field: limit}), field) == limit


def test_the_defaults_do_nothing() -> None:
    assert LinkSettings() == LinkSettings(
        delay_s=0, jitter_s=0, loss=0, burst_enter=0, duplicate=0, corrupt=0, rate_hz=0, outages_s=(), trace_s=()
    )
    assert not LinkSettings().has_bursts
    assert LinkSettings(burst_loss_good=0.1).has_bursts
    assert not LinkSettings(burst_enter=0.1, burst_loss_bad=0.0).has_bursts
