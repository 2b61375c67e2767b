"""Search for the value at which a verdict changes."""

from math import isfinite

from passafe_services.tools.what_if.search import Search, SearchResult, Trial


def searched(limit: float, *, most_runs: int = 40, again: tuple[float, float] = (2.0, 3.0)) -> SearchResult:
    def attempt(value: float) -> Trial:
        holds = value < limit or again[0] <= value <= again[1]
        return Trial(value=value, verdict="holds" if holds else "fails", h_min=limit - value, words="")

    return Search(key="link.x.delay", low=0.0, high=1.0, tolerance=1e-3, most_runs=most_runs).run(attempt)


def test_boundary_is_bracketed_as_narrowly_as_asked() -> None:
    result = searched(0.3217)
    assert result.same_up_to is not None
    assert result.differs_from is not None
    assert result.same_up_to < 0.3217 <= result.differs_from
    assert result.differs_from - result.same_up_to <= 1e-3
    assert result.is_finished
    assert result.is_monotone
    assert result.text.startswith("link.x.delay: holds up to 0.321")


def test_no_change_is_not_called_impossible() -> None:
    result = searched(5.0)
    assert result.differs_from is None
    assert result.text == "link.x.delay: no change of the verdict found from 0 to 1: holds at all 5 values tried"


def test_verdict_that_comes_back_is_reported() -> None:
    result = searched(0.4, again=(0.7, 0.8))
    assert not result.is_monotone
    assert "not monotone: holds again at a value beyond" in result.text


def test_budget_of_runs_is_kept() -> None:
    result = searched(0.3217, most_runs=7)
    assert len(result.trials) == 7
    assert not result.is_finished
    assert result.text.endswith("not as narrow as asked")


def test_interrupt_leaves_what_was_found() -> None:
    tried: list[float] = []

    def attempt(value: float) -> Trial:
        if len(tried) == 3:
            raise KeyboardInterrupt
        tried.append(value)
        return Trial(value=value, verdict="holds", h_min=1.0, words="")

    result = Search(key="k", low=0.0, high=1.0, tolerance=0.1, most_runs=9).run(attempt)
    assert [trial.value for trial in result.trials] == tried
    assert result.was_interrupted
    assert not result.is_finished


def test_interrupt_before_anything() -> None:
    def attempt(_value: float) -> Trial:
        raise KeyboardInterrupt

    assert Search(key="k", low=0.0, high=1.0, tolerance=0.1, most_runs=9).run(attempt).text == "k: nothing was tried"


def test_ends_far_apart_are_divided_all_the_same() -> None:
    tried: list[float] = []

    def attempt(value: float) -> Trial:
        tried.append(value)
        return Trial(value=value, verdict="holds" if value < 1.6e308 else "fails", h_min=None, words="")

    Search(key="k", low=-1.7e308, high=1.7e308, tolerance=1e300, most_runs=12).run(attempt)
    assert len(tried) == 12
    assert all(map(isfinite, tried))
