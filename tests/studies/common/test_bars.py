"""Numbers held against what is asked: rates and losses by their intervals, others as they are."""

import io

import pytest
from rich.console import Console

from studies.common.bars import HEAD, Asked, bar_rows, bar_table, compared, judged, loss, rate

LEAST, MOST = Asked("speed", 0.5, "m/s"), Asked("drift", 0.03, "m", most=True)


@pytest.mark.parametrize(
    ("asked", "value", "met"),
    [
        (LEAST, 0.5, True),
        (LEAST, 0.49, False),
        (LEAST, None, None),
        (MOST, 0.03, True),
        (MOST, 0.031, False),
        (Asked("rate"), 2.0, None),
        (Asked("falls", 0, most=True), 0, True),
    ],
)
def test_a_number_is_held_against_its_bar(asked, value, met):
    found = judged(asked, value)
    assert (found["value"], found["bar"], found["met"]) == (value, asked.bar, met)
    assert found["interval"] is None


@pytest.mark.parametrize(
    ("most", "ends", "met"),
    [
        (False, (0.5, 0.9), True),
        (False, (0.4, 0.5), None),
        (False, (0.1, 0.49), False),
        (True, (0.1, 0.5), True),
        (True, (0.5, 0.9), None),
        (True, (0.51, 0.9), False),
    ],
)
def test_an_interval_decides_when_all_of_it_is_on_one_side(most, ends, met):
    assert judged(Asked("share", 0.5, most=most), 0.5, ends)["met"] is met


def test_a_rate_is_judged_by_wilsons_interval():
    """Of 150 of 160 it is 88.9 to 96.6 %, by hand."""
    met = {bar: rate(Asked("upright", bar, "%"), 150, 160)["met"] for bar in (85.0, 90.0, 97.0)}
    assert met == {85.0: True, 90.0: None, 97.0: False}
    found = rate(Asked("upright", 85.0, "%"), 150, 160)
    assert found["value"] == 93.75
    assert found["interval"] == pytest.approx([88.88, 96.57], abs=0.01)
    unknown = rate(Asked("upright", 85.0, "%"), 0, 0)
    assert (unknown["value"], unknown["interval"], unknown["met"]) == (None, None, None)


def test_a_loss_is_of_pairs():
    """Of 200 pairs 20 lost are 10 points, the interval by hand: (21 - 1) / 202 -+ 4.4 points."""
    asked = Asked("fewer upright", 5.0, "points", most=True)
    found = loss(asked, 20, 0, 200)
    assert (found["value"], found["met"]) == (10.0, False)
    assert found["interval"] == pytest.approx([5.54, 14.26], abs=0.02)
    assert [loss(asked, 0, 0, n)["met"] for n in (0, 20, 200)] == [None, None, True]


def test_trials_are_compared_draw_by_draw():
    ours, theirs = (
        [{"index": i, "upright": stays} for i, stays in enumerate(some)]
        for some in ((True, False, False, True), (True, True, True, False))
    )
    found = compared(ours[::-1], theirs)
    assert (found["won"], found["lost"]) == (1, 2)


def test_rows_say_what_is_known():
    bars = {
        "a": rate(Asked("|x|", 90.0, "%"), 9, 10),
        "b": judged(MOST, None),
        "c": judged(Asked("how fast"), 2.0),
        "d": judged(MOST, None) | {"met": False},
    }
    assert bar_rows(bars) == [
        ["`a`", "/x/", "90 %", "59.6 to 98.2", "at least 90 %", "undecided"],
        ["`b`", "drift", "-", "-", "at most 0.03 m", "-"],
        ["`c`", "how fast", "2", "-", "-", "-"],
        ["`d`", "drift", "-", "-", "at most 0.03 m", "**NO**"],
    ]
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(bar_table(bars, "Asked"))
    text = console.export_text()
    assert "Asked" in text and "NO" in text and "*" not in text and "`" not in text
    assert all(word in text for word in HEAD)
