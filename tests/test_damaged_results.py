"""Results that are damaged, disks that are full, folders in use or closed: each is noticed, and one line."""

import os
import random
import shutil
import subprocess
import sys

import dummy_tasks
import pytest
from dummy_tasks import Square
from linecontact.studies.runner import tasks
from running import PATIENCE, begin, begun, command, data, finish, program, task_files, wait_until

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX"),
    pytest.mark.usefixtures("dummies"),
]


# damage


def flipped(content, rng):
    position = rng.randrange(8 * len(content))
    damaged = bytearray(content)
    damaged[position // 8] ^= 1 << position % 8
    return bytes(damaged)


def test_damaged_records_are_set_aside_and_done_again(folder, capsys):
    """Three flipped bits, one file cut short, one of nothing; one is sound."""
    todo, rng, damaged = [Square(i) for i in range(6)], random.Random(2), {}
    assert command(todo, folder) == 0
    whole, before = data(folder / "dummy.h5"), task_files(folder)
    (folder / "dummy.h5").unlink()
    for task in todo[:5]:
        path = folder / "tasks" / f"{tasks.identity(task)}.json"
        content = path.read_bytes()
        damaged[path.name] = (b"", content[: len(content) // 2], *[flipped(content, rng)] * 3)[task.number]
        path.write_bytes(damaged[path.name])
    capsys.readouterr()
    assert command(todo, folder) == 0
    stderr = capsys.readouterr().err
    assert all(f"{name} is damaged; it is set aside as {name}.damaged" in stderr for name in damaged)
    aside = {path.name.removesuffix(".damaged"): path.read_bytes() for path in (folder / "tasks").glob("*.damaged")}
    assert aside == damaged
    assert begun() == dict.fromkeys(range(5), 2) | {5: 1}
    after = task_files(folder)
    assert after.keys() == before.keys()
    assert {after[name] == before[name] for name in before.keys() - damaged.keys()} == {True}
    assert data(folder / "dummy.h5") == whole


def test_a_damaged_study_is_collected_again_from_the_records(folder, capsys, monkeypatch):
    todo, rng = [Square(i) for i in range(4)], random.Random(3)
    assert command(todo, folder) == 0
    monkeypatch.setattr(Square, "run", None)
    path, aside = folder / "dummy.h5", folder / "dummy.h5.damaged"
    content, whole = path.read_bytes(), data(path)
    for damaged in (b"", content[:-1], content[: len(content) // 2], bytes(len(content)), flipped(content, rng)):
        path.write_bytes(damaged)
        capsys.readouterr()
        assert command(todo, folder) == 0
        assert aside.read_bytes() == damaged
        assert "dummy.h5 is damaged; it is set aside as dummy.h5.damaged" in capsys.readouterr().err
        aside.unlink()
        assert data(path) == whole


def test_any_flipped_bit_in_a_study_is_noticed(folder):
    """In a process of its own: without a checksum of the bytes, one of about 1000 flips ends or hangs it."""
    assert command([Square(i) for i in range(4)], folder) == 0
    check = """
import sys
from pathlib import Path
from linecontact.studies.files import study_files, writing
path = Path(sys.argv[1])
content = path.read_bytes()
for position in range(0, len(content), 19):
    damaged = bytearray(content)
    damaged[position] ^= 1 << position % 8
    path.write_bytes(damaged)
    try:
        study_files.load_study(path)
    except writing.DamagedError:
        continue
    sys.exit(f"byte {position}")
"""
    result = finish([sys.executable, "-c", check, str(folder / "dummy.h5")])
    assert result.returncode == 0, result.stderr


# disks, locks and permissions


@pytest.mark.parametrize(("limit", "kept"), [(100, 0), (4096, 6)], ids=["record", "study"])
def test_a_full_disk_is_one_line_and_status_2(folder, limit, kept):
    """No record fits under the first limit; all of them, but not the collected study, under the second."""
    import resource

    todo = [Square(i) for i in range(6)]
    limits = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))}
    no_bytecode = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}  # which the limit would cut short for all who follow
    result = finish(program(todo, folder), env=no_bytecode, **limits)
    assert result.returncode == 2, result.stderr
    assert result.stderr.startswith(f"linecontact: file {folder}")
    assert "could not be written" in result.stderr
    assert result.stderr.count("\n") == 1
    assert len(task_files(folder)) == kept
    assert not (folder / "dummy.h5").exists()
    assert not list(folder.rglob("*.part"))
    assert command(todo, folder) == 0
    assert data(folder / "dummy.h5")[2] == {"numbers": [0, 1, 2, 3, 4, 5]}
    assert sum(begun().values()) == (6 if kept else 7)


@pytest.mark.parametrize(
    "case",
    ["folder", "records", "damaged", "overwrite"],
)
def test_a_read_only_folder_is_one_line_and_status_2(folder, case):
    unprivileged = []
    if os.geteuid() == 0:  # whom permissions do not bind, unless this is taken away
        unprivileged = ["setpriv", "--bounding-set", "-dac_override"]
        if not shutil.which("setpriv") or subprocess.run([*unprivileged, "true"], check=False).returncode:
            pytest.skip("permissions do not bind root")
    todo = [Square(i) for i in range(2)]
    assert command(todo, folder) == 0
    whole = data(folder / "dummy.h5")
    files = task_files(folder)
    closed = folder if case == "folder" else folder / "tasks"
    if case == "records":
        todo.append(Square(2))
        (folder / "dummy.h5").unlink()
    elif case == "damaged":
        (folder / "dummy.h5").unlink()
        (folder / "tasks" / next(iter(files))).write_bytes(b"damaged")
    closed.chmod(0o555)
    try:
        result = finish([*unprivileged, *program(todo, folder, *(["--overwrite"] if case == "overwrite" else []))])
    finally:
        closed.chmod(0o755)
    assert result.returncode == 2, result.stderr
    lines = [line for line in result.stderr.splitlines() if not line.startswith("continuing")]
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("linecontact: ")
    assert str(folder) in lines[0]
    assert "ermission denied" in lines[0]
    assert command(todo, folder) == 0
    if case != "records":
        assert data(folder / "dummy.h5") == whole


def test_the_second_run_in_a_folder_is_refused_until_the_first_is_gone(folder, capsys):
    todo = [Square(0), Square(1, gate="gate")]
    first = begin(program(todo, folder))
    try:
        assert wait_until(lambda: len(begun()) == 2, first)
        assert command(todo, folder) == 2
        stderr = capsys.readouterr().err
        assert stderr.startswith(f"linecontact: folder {folder} is in use by another run")
        assert stderr.count("\n") == 1
    finally:
        first.kill()
        first.wait(PATIENCE)
    assert begun() == {0: 1, 1: 1}
    dummy_tasks.note("gate")
    assert command(todo, folder) == 0
    assert begun() == {0: 1, 1: 2}
