"""Ragged columns and texts, by values counted by hand."""

import numpy as np
from passafe_services.log.column import Ragged, Texts, joined, same_rows


def ragged(*rows: list[float]) -> Ragged:
    return Ragged(np.concatenate([np.array(row, dtype=float) for row in rows]), np.array([len(row) for row in rows]))


def test_rows_are_taken_and_joined() -> None:
    column = ragged([1, 2], [], [3], [4, 5, 6])

    taken = column.take(np.array([3, 0, 1]))
    both = joined([taken, ragged([7])])

    assert taken.values.tolist() == [4, 5, 6, 1, 2]
    assert taken.counts.tolist() == [3, 2, 0]
    assert both.values.tolist() == [4, 5, 6, 1, 2, 7]
    assert both.counts.tolist() == [3, 2, 0, 1]
    assert column.row_numbers.tolist() == [0, 0, 2, 3, 3, 3]


def test_a_matrix_cuts_long_rows_and_fills_short_ones() -> None:
    found = ragged([1, 2], [], [4, 5, 6]).matrix(2)

    np.testing.assert_array_equal(found, [[1, 2], [np.nan, np.nan], [4, 5]])


def test_rows_of_one_length_are_taken_alike() -> None:
    column = ragged([1, 2], [3, 4], [5, 6])

    assert column.take(np.array([2, 0])).values.tolist() == [5, 6, 1, 2]
    assert column.matrix(2).tolist() == [[1, 2], [3, 4], [5, 6]]


def test_texts_of_several_parts_get_common_codes() -> None:
    first = Texts(np.array([0, 1]), ("a", "b"))
    second = Texts(np.array([0, 1]), ("b", "c"))

    both = joined([first, second])

    assert [both.words[code] for code in both.codes] == ["a", "b", "b", "c"]
    assert both.are("b", "z").tolist() == [False, True, True, False]
    assert both.take(np.array([3])).are("c").tolist() == [True]


def test_texts_in_lists_get_common_codes() -> None:
    first = Texts(Ragged(np.array([0, 1]), np.array([2, 0])), ("a", "b"))
    second = Texts(Ragged(np.array([0]), np.array([1])), ("b",))

    both = joined([first, second]).take(np.array([2, 0]))

    assert both.are("b").tolist() == [True, False, True]
    assert len(both) == 2


def test_rows_are_the_same_only_to_the_last_bit() -> None:
    numbers, others = np.array([0.0, np.nan, 1.0]), np.array([-0.0, np.nan, 1.0])
    first, second = ragged([1, 2], [], [3], [4]), ragged([1, 2], [7], [3], [5])
    words, same_words = Texts(np.array([0, 1, 1]), ("a", "b")), Texts(np.array([1, 0, 2]), ("b", "a", "c"))

    assert same_rows(numbers, others).tolist() == [False, True, True]
    assert same_rows(first, second).tolist() == [True, False, True, False]
    assert same_rows(words, same_words).tolist() == [True, True, False]
    assert same_rows(np.array([3, 4]), np.array([3, 5])).tolist() == [True, False]
