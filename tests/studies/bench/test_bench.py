"""The whole benchmark, with next to nothing measured, and the page that is made from it."""

import json
import sys
from pathlib import Path

import pytest

from drake_linefoot.mpc.models.registry import MODELS
from studies.bench import __main__ as bench
from studies.bench import page, processes
from studies.bench.dispatch import dispatch_over_workers
from studies.bench.measures import THRESHOLDS
from studies.bench.tick_parts import REST
from studies.common.command import run
from tests.helpers.tiny_sweeps import write_sweep
from tests.helpers.walked import LEAST


def main(arguments):
    return run(bench.bench, "bench", arguments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What `python -m studies.bench --quick` writes, without PlaCo."""
    out = tmp_path_factory.mktemp("bench") / "new" / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "QUICK", LEAST)
        missing = "no/such/python"
        assert main(["--quick", "--out", str(out), "--placo", missing, "--against", missing]) == 0
    return out


@pytest.fixture
def data(folder):
    """What `bench.json` holds."""
    return json.loads((folder / bench.JSON).read_text(encoding="utf-8"))


@pytest.mark.slow
def test_only_the_json_is_written(folder):
    assert [path.name for path in folder.iterdir()] == [bench.JSON]


@pytest.mark.slow
def test_every_key_is_there_and_null_has_a_reason(data):
    assert set(THRESHOLDS) <= set(data)
    null = {name for name in THRESHOLDS if data[name] is None}
    assert null <= set(data["notes"])
    assert {"wbc_tick_over_placo", "memory_growth_mb"} <= null
    assert data["bars"]["closed_loop_over_plant_step"]["value"] > 0.0
    assert data["closed_loop_over_plant_step_busy"] > 0.0
    assert (
        data["notes"]["sweep_runs_per_core_minute"] == "no/such/python: No such file or directory"
    )
    kinds = [times["n"] for name, times in data["times"].items() if name.startswith("wbc_tick: ")]
    assert sum(kinds) == data["times"]["wbc_tick"]["n"]
    for name in (
        "dynamics",
        "dynamics_drake",
        "wbc_tick",
        "mpc_update",
        "mpc_update_active_set",
        "mpc_references",
        "mpc_solve",
        "gait_update",
    ):
        assert data["times"][name]["n"] > 0


@pytest.mark.slow
def test_the_parts_of_a_tick_make_up_the_loop(data):
    parts = {part["name"]: part for part in data["scaling"]["where_a_tick_goes"]}
    assert parts["StateDynamics._calc_dynamics"]["calls"] == 1.0
    assert parts["EcdMpc._update"]["calls"] == pytest.approx(0.1)  # every other one plans
    assert {REST, "Recorder._sample", "GaitPlanner._update"} <= set(parts)
    assert all(part["us"] > 0.0 for part in parts.values())


@pytest.mark.slow
def test_every_model_of_the_mpc_is_measured(data):
    found = data["scaling"]["mpc_over_models"]
    assert found["models"] == list(MODELS)
    assert found["over_ecd"][found["models"].index("ecd")] == 1.0
    assert min(found["over_ecd"]) > 0.0 and len(found["median_ms"]["solve"]) == len(MODELS)


@pytest.mark.slow
def test_runs_are_handed_out_to_workers_on_loopback(data, tmp_path):
    found = dispatch_over_workers(write_sweep(tmp_path), (1, 3), 8)
    assert found["run_s"] > 0.0
    assert found["finished_per_s"][1] == pytest.approx(3.0 * found["finished_per_s"][0])
    assert min(found["handed_out_per_s"]) > 0.0 and min(found["hours_for_many"]) > 0.0
    assert 100 < min(found["job_bytes"], found["row_bytes"], found["journal_bytes"])
    data["scaling"]["dispatch_over_workers"] = found
    assert "hours for 100000 runs" in page.page(data, "bench.json")


@pytest.mark.slow
def test_machine_versions_and_command_are_told(data):
    assert data["command"] == "python -m studies.bench --quick"
    assert data["machine"]["cores"] > 0
    assert data["versions"]["drake"]
    assert len(data["date"]) == len("2000-01-01")


@pytest.mark.slow
def test_page_says_what_was_measured(folder, tmp_path):
    target = tmp_path / "benchmarks.md"
    assert run(page.write, "bench.page", [str(folder / bench.JSON), str(target)]) == 0
    text = target.read_text(encoding="utf-8")
    assert all(asked.what in text for asked in THRESHOLDS.values())
    assert "python -m studies.bench --quick" in text
    assert "wbc_tick_over_placo: " in text  # the note
    assert all(f"| `{model}` |" in text for model in MODELS)
    assert str(Path.cwd()) not in text


def test_page_needs_two_names_and_a_complete_file(tmp_path, capsys):
    assert run(page.write, "bench.page", []) == 2
    assert "Missing argument" in capsys.readouterr().err
    words = [str(tmp_path / "none.json"), str(tmp_path / "page.md")]
    assert run(page.write, "bench.page", words) == 2
    (tmp_path / "some.json").write_text("{}", encoding="utf-8")
    words[0] = str(tmp_path / "some.json")
    assert run(page.write, "bench.page", words) == 2
    assert "lacks wbc_tick_over_placo" in capsys.readouterr().err
    assert not (tmp_path / "page.md").exists()


def test_folder_that_cannot_be_written_is_said_before_anything_is_measured(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main(["--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_the_first_walk_counts_the_cpu_of_its_process_alone(monkeypatch):
    burn = "import time\nwhile time.process_time() < 0.3: pass\nprint('first', 'last', sep='\\n')"
    run, said = processes._run, []
    monkeypatch.setattr(
        processes, "_run", lambda _, **env: said.append((run([sys.executable, "-c", burn]), env))
    )
    took = processes.first_walk()
    assert took["first_walk_cpu_s"] > 0.25  # the clock of the system ticks every 10 ms
    assert took["first_walk_wall_s"] >= took["first_walk_cpu_s"] - 0.02  # it burns on one core
    ((last, env),) = said
    assert last == "last"
    assert set(env) == {"NUMBA_CACHE_DIR"}
    assert not Path(env["NUMBA_CACHE_DIR"]).exists()


@pytest.mark.slow
def test_memory_has_nothing_of_the_log():
    found = processes.memory_growth(2.0, 6.0)
    assert found["fell"] == ""
    assert found["last"]["log_mb"] > 0.0
    assert found["last"]["resident_mb"] > found["last"]["log_mb"]
    log = found["last"]["log_mb"] - found["first"]["log_mb"]
    assert log > 7.0
    assert found["growth_mb"] < 0.5 * log
