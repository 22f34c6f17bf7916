"""Small sweeps, and rows that nobody simulated."""

from drake_linefoot.lab.results.judge import OUTCOME

TINY = """
name: tiny
scenario: stand
runs: 4
seed: 1
groups:
  - {name: low, set: {gait.com_height: 0.62}}
  - {name: high}
set:
  segments: [{name: stand, duration: 0.05}]
sample:
  perturbation.joint_velocity: {uniform: [0.0, 0.5]}
  gait.first_swing: {choice: [left, right]}
"""


def write_sweep(folder, text=TINY, **changes):
    """Write a sweep; `changes` replace what follows a field of the file, `runs=3`."""
    lines = text.strip().splitlines()
    for field, value in changes.items():
        lines = [f"{field}: {value}" if line.startswith(f"{field}:") else line for line in lines]
    file = folder / "tiny.yaml"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def made_up_row(group="low", index=0, fell=False, **changes):
    """A row with plausible values."""
    row = {
        **{"group": group, "index": index, "seed": index, "sampled": {"x": 0.1 * index}},
        **dict.fromkeys(OUTCOME),
        **{"fell": fell, "fall_time": 1.5 if fell else None, "fall_reason": ""},
        **{"cause": "torso low" if fell else "upright", "roll_max": 0.1, "pitch_max": 0.05},
        **{"state_hash": f"{index:016x}", "error": "", "attempts": 1, "wall_seconds": 1.0},
        **{"worker_mb": 200.0, "worker": "host:1"},
    }
    return {**row, **changes}
