"""Words for what becomes of the operator's command."""

import pytest
from closed_form import tick
from passafe_dashboard.live.command_words import command_words
from passafe_protocol.messages import CommandState


def test_every_state_has_words_of_its_own() -> None:
    words = {command_words(tick(0, command_state=state)) for state in ("", *CommandState)}

    assert len(words) == 1 + len(CommandState)
    assert command_words(tick(0)) == "not reported"


@pytest.mark.parametrize(("share", "percent"), [(0.0, "0 %"), (0.4, "40 %"), (0.9999, "99 %")])
def test_ramp_is_shown_with_its_share(share: float, percent: str) -> None:
    text = command_words(tick(0, command_state="resumes", command_share=share))

    assert text == f"ramps in after a stale stretch: {percent} of it counts"
