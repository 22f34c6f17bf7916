"""Files that take long or much memory to read: each ends in one line, and soon."""

import os
import subprocess
import sys

import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario.load import load_scenario, parse_scenario
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.robot.description import load_description
from drake_linefoot.robot.model_file import read_model_file
from tests.helpers import made_up_robots as made_up

SECONDS = 20  # 5 on a machine that does nothing else
MEGABYTES = 400
LOADERS = {"scenario": load_scenario, "sweep": load_sweep, "robot": load_description}


def nested(form, depth=12, first="x"):
    """Return YAML in which each line stands for nine of the line before."""
    lines = [f"_0: &a0 {{{first}: 1}}"]
    for i in range(1, depth):
        inner = ", ".join([f"*a{i - 1}"] * 9)
        lines.append(f"_{i}: &a{i} {form.format(inner)}")
    return "\n".join(lines) + f"\nname: *a{depth - 1}\n"


BOMBS = {
    "aliases": nested("[{}]"),
    "merges": nested("{{<<: [{}]}}"),
    "a list of itself": "segments: &a [*a]\n",
    "deep lists": "name: " + "[" * 100_000,
    "deep mappings": "\n".join(" " * i + "a:" for i in range(500)),
    "a long name": "name: " + "x" * 10_000_000,
    "a name of 400 kB": "name: " + "x" * 400_000,
    "a key of 400 kB": "? " + "x" * 400_000 + "\n: 1\n",
    "the same key of 200 kB": ("? " + "x" * 200_000 + "\n: 1\n") * 2,
    "an alias of 400 kB": "name: *" + "x" * 400_000,
    "a tag of 400 kB": "name: !" + "x" * 400_000 + " 1",
    "digits": "seed: " + "9" * 400_000,
    "base 60": "seed: 1" + ":59" * 130_000,
    "many keys": "".join(f"k{i}: {i}\n" for i in range(30_000)),
    "other text": b"name: \xff\xfe\xfa",
    "no text": bytes(range(256)) * 40,
}

# What loaders say, in a process of its own; with the seconds each took, and the memory of all.
LOAD = """
import resource, sys, time
from tests.lab.test_bombs import LOADERS
from drake_linefoot.errors import InputError
used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for kind, file in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
    before = time.process_time()
    try:
        LOADERS[kind](file)
    except InputError as error:
        print(error)
    print(time.process_time() - before)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - used) / 1024)
"""


def refused(loads):
    """Let loaders read files, one after the other; return the messages."""
    done = subprocess.run(
        [sys.executable, "-c", LOAD, *(str(word) for load in loads for word in load)],
        capture_output=True,
        text=True,
        check=True,
        timeout=SECONDS * len(loads) + 60,
        cwd=os.getcwd(),
    )
    *lines, megabytes = done.stdout.splitlines()
    messages = lines[::2]
    for message, seconds, (_, file) in zip(messages, lines[1::2], loads, strict=True):
        assert len(message) < 700 + len(str(file))  # with the names of all fields
        assert float(seconds) < SECONDS
    assert float(megabytes) < MEGABYTES
    return messages


@pytest.mark.parametrize("name", BOMBS)
@pytest.mark.parametrize("kind", LOADERS)
def test_a_bomb_ends_in_one_line(tmp_path, kind, name):
    file, text = tmp_path / "a.yaml", BOMBS[name]
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    try:
        LOADERS[kind](file)
    except InputError as error:
        assert str(error).startswith(str(file))
        assert "\n" not in str(error)
        assert len(str(error)) < 700 + len(str(file))  # with the names of all fields
    else:
        pytest.fail("was taken")


def test_a_bomb_takes_neither_time_nor_memory(tmp_path):
    loads = []
    for name in ("merges", "a long name", "base 60"):
        file = tmp_path / f"{name}.yaml"
        file.write_text(BOMBS[name])
        loads += [(kind, file) for kind in LOADERS]
    for message, (_, file) in zip(refused(loads), loads, strict=True):
        assert message.startswith(str(file))


def test_what_is_no_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "fifo.yaml")
    (tmp_path / "zero.yaml").symlink_to("/dev/zero")
    (tmp_path / "folder.yaml").mkdir()
    loads = [(kind, tmp_path / f"{name}.yaml") for kind in LOADERS for name in ("fifo", "zero")]
    for message in refused(loads):
        assert "is no regular file" in message
    for load in LOADERS.values():
        with pytest.raises(InputError, match=r"is a folder|Is a directory"):
            load(tmp_path / "folder.yaml")


def test_the_scenario_of_a_recording_is_read_as_carefully():
    with pytest.raises(InputError, match="stands for too much"):
        parse_scenario(BOMBS["merges"])


def model(tmp_path, content):
    (tmp_path / "model.urdf").write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_model_file(tmp_path / "model.urdf", tmp_path / "robot.yaml")
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_models_that_are_bombs_are_refused(tmp_path):
    entities = "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(12))
    laughs = f'<!DOCTYPE r [<!ENTITY a0 "x">{entities}]><robot name="&a12;"/>'
    assert "is no XML" in model(tmp_path, laughs.encode())
    assert "nested too deeply" in model(tmp_path, b"<a>" * 20_000 + b"</a>" * 20_000)
    assert "larger than" in model(tmp_path, b"<a>" + b" " * 2**26)
    assert "UTF-8" in model(tmp_path, b"<a>\xff</a>")


def test_a_model_that_is_no_file_is_not_waited_for(tmp_path):
    for name, target in (("zero", "/dev/zero"), ("folder", str(tmp_path))):
        (tmp_path / f"{name}.urdf").symlink_to(target)
        with pytest.raises(InputError, match=r"cannot be read: [iI]s "):
            read_model_file(tmp_path / f"{name}.urdf", tmp_path / "robot.yaml")


def test_long_names_of_a_model_are_cut(tmp_path):
    tree = made_up.mit()
    joint = tree.getroot().find("joint")
    joint.set("name", "x" * 100_000)
    joint.find("limit").set("lower", "nan" * 10_000)
    message = model(tmp_path, made_up.write(tree, tmp_path).read_bytes())
    assert len(message) < 500 + 2 * len(str(tmp_path))
