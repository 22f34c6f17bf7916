"""The search for weights: on a known cost, and what is stored of it."""

import numpy as np
import pytest

from drake_linefoot.mpc.parameters import MpcWeights
from studies import tuning
from studies.tuning import GROUPS, cost_of, scaled, search


def test_weights_are_scaled_by_group():
    found = scaled(MpcWeights(), np.array([1.0, 0.0, 0.0, -1.0, 0.0]))
    assert found.position == [0.0, 0.0, 20000.0]
    assert found.orientation == pytest.approx([30.0] * 3)
    assert found.velocity == MpcWeights().velocity


def test_falling_costs_more_the_earlier():
    upright = {"fell": False, "roll_rms": 0.03, "pitch_rms": 0.04, "speed_error": 0.1}
    assert cost_of(upright, 4.0) == pytest.approx(2.5 + 1.0)
    early, late = ({"fell": True, "fall_time": t} for t in (1.0, 3.0))
    assert cost_of(early, 4.0) > cost_of(late, 4.0) > cost_of(upright, 4.0)


def test_the_search_finds_a_known_minimum_and_repeats_itself():
    best = np.array([0.5, -0.5, 0.3, 0.0, -0.8])

    def cost(candidates):
        def decades(w):
            d = MpcWeights()
            pairs = [
                (w.position[2], d.position[2]),
                (w.velocity[0], d.velocity[0]),
                (w.angular_momentum[0], d.angular_momentum[0]),
                (w.orientation[0], d.orientation[0]),
                (w.force, d.force),
            ]
            return np.array([np.log10(a / b) for a, b in pairs])

        return [float(np.sum((decades(w) - best) ** 2)) for w in candidates]

    found = search(cost, rounds=75, candidates=4, seed=1)
    assert found.first == pytest.approx(np.sum(best**2))
    assert found.cost < 1e-3
    assert search(cost, rounds=5, candidates=4, seed=0) == search(cost, 5, 4, 0)
    assert search(cost, rounds=5, candidates=4, seed=0) != search(cost, 5, 4, 1)
    assert len(best) == len(GROUPS)
    scanned = search(cost, rounds=0, candidates=2, seed=1, scan=True)
    assert scanned.cost == pytest.approx(np.sum((best - [0, 0, 0, 0, -1]) ** 2))
    assert scanned.weights.force == pytest.approx(0.1 * MpcWeights().force)


def test_what_is_found_is_stored_beside_the_rest(tmp_path, monkeypatch):
    file = tmp_path / "weights.yaml"
    monkeypatch.setattr(tuning, "FILE", file)
    for model, force in (("ecd", 2e-5), ("srbm", 3e-5)):
        weights = MpcWeights(force=force)
        tuning.store(model, tuning.Found(weights, 1.0, 2.0), f"tune {model}", file)
    assert tuning.tuned("ecd").force == 2e-5
    assert tuning.tuned("srbm").force == 3e-5
    assert "command: tune srbm" in file.read_text()


def test_the_shipped_weights_say_how_they_were_found():
    assert tuning.tuned("srbm").force > 0.0
    assert "studies.tuning --model srbm" in tuning.FILE.read_text()
