"""Draws that come to the same in two ways are simulated in one of them."""

import io

from rich.console import Console

from studies.common import paired

OTHERWISE = "wide_rough"  # a group that a map changes
RUNS = paired.ALIKE + 2
WAYS = paired.SIMULATORS[0], paired.KNOWN


def made_up(draw):
    """Its tilt is that without a map, but for the last bit of one draw, the last that counts."""
    differs = (draw.group, draw.index, draw.how) == (OTHERWISE, paired.ALIKE - 1, paired.KNOWN)
    return paired.row_of(draw, True, "") | {"tilt": 0.1 * (draw.index + 1) + 2e-16 * differs}


def test_a_group_is_not_walked_on_where_its_first_draws_are_the_same(tmp_path, monkeypatch):
    file = tmp_path / "trials.jsonl"
    without = [draw for draw in paired.draws(RUNS, WAYS) if draw.how == WAYS[0]]
    monkeypatch.setattr(paired, "drawn", made_up)
    monkeypatch.setattr(paired, "known", lambda _: {draw.key: made_up(draw) for draw in without})
    screen = Console(file=io.StringIO())
    trials = paired.trials_in(file, 1)
    found = paired.simulated(RUNS, WAYS, trials.begun([], False), trials, screen, alike=True)
    assert [row["key"] for row in found] == [draw.key for draw in paired.draws(RUNS, WAYS)]
    walked = {group: one["known_taken"] for group, one in paired.shares(found).items()}
    assert walked.pop(OTHERWISE) == 0
    assert set(walked.values()) == {RUNS - paired.ALIKE}
    for row in found:
        assert row["tilt"] == made_up(paired.Draw(row["group"], row["index"], row["how"]))["tilt"]
    kept = trials.begun([], False)
    assert len(kept) == len(walked) * paired.ALIKE + RUNS, "what is taken is not kept"
