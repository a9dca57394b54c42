"""Result files from anywhere: each is read or refused in one line, never a traceback, a hang or a crash.

The cases are what longer runs have found; a short run, with fixed seeds, goes on looking.
"""

import hashlib
import io
import json
import os
from pathlib import Path

import h5py
import numpy as np
import pytest
from linecontact import studies
from linecontact.solver import Scene, solve
from linecontact.studies import hertz
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import confined, hdf5, solution_files, study_files, writing
from linecontact.studies.kernel_benchmark import compare
from linecontact.studies.power_profiles import tasks as power_profiles
from linecontact.studies.runner import tasks
from linecontact.studies.scans import reading

RESULTS = Path(studies.__file__).parent / "results"


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_what_is_no_file_is_refused_at_once(tmp_path):
    pipe = tmp_path / "x.json"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero"), tmp_path, tmp_path / ("a" * 300)):
        with pytest.raises(ValueError, match="not a file"):
            reading.read(reading.Options(path))
        with pytest.raises(writing.StoreError, match="allowed: an HDF5 file"):
            study_files.load_study(path)
        with pytest.raises(ValueError, match=r"no regular file|holds no kernels\.h5"):
            compare.read(path)
    folder = tasks.TaskFolder(tmp_path / "tasks")
    task = ensemble_task()
    os.mkfifo(folder.folder / f"{tasks.identity(task)}.json")
    with pytest.raises(writing.StoreError, match="no regular file"):
        folder.load(task)
    with pytest.raises(writing.StoreError, match="longer than 200 bytes"):
        writing.check_target(tmp_path / ("a" * 201), overwrite=True)


def ensemble_task():
    return power_profiles.plan("hertz", hertz.CONFIGURATION).tasks[0]


def virtual(file):
    layout = h5py.VirtualLayout((40,), "f8")
    layout[:] = h5py.VirtualSource("/other.h5", "line", (40,))
    file.create_virtual_dataset("line", layout)


def plugin(file):
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((40,))
    properties.set_filter(31999, h5py.h5z.FLAG_OPTIONAL)
    h5py.h5d.create(file.id, b"line", h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple((40,)), properties)


DATASETS = {
    "external": lambda file: file.create_dataset("line", (40,), "f8", external=[("/etc/passwd", 0, 320)]),
    "virtual": virtual,
    "unfilled": lambda file: file.create_dataset("line", (2**20, 2**20), "f8"),
    "a bomb": lambda file: file.create_dataset("line", (40,), "f8", maxshape=(None,), chunks=(2**28,)),
    "a plugin": plugin,
    "objects": lambda file: file.create_dataset("line", (40,), h5py.ref_dtype),
    "of variable length": lambda file: file.create_dataset("line", (40,), h5py.vlen_dtype("f8")),
}


@pytest.mark.parametrize("name", DATASETS)
def test_datasets_that_ask_for_more_are_refused(tmp_path, name):
    """In this process, which none of these harms."""
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        DATASETS[name](file)
    with pytest.raises(confined.RefusedError, match="line"):
        confined._dataset(str(path), str(2**26))


def sealed(path, image):
    """A result with a right checksum, whatever it holds."""
    path.write_bytes(hdf5.head(hashlib.sha256(image).hexdigest()) + image)
    return path


def test_what_hdf5_does_not_survive_is_one_line(tmp_path, monkeypatch):
    """Text of variable length that is neither text nor a sequence, in a file of somebody else's: HDF5 crashes."""
    path = tmp_path / "scan.h5"
    monkeypatch.setattr(confined, "SECONDS", 1)
    with h5py.File(path, "w") as file:
        file["line"] = np.zeros(40)
        file["line"].attrs["kind"] = "solution"
    image = bytearray(path.read_bytes())
    kind = image.index(b"kind\0\0\0\0\x19\x01")
    image[kind + 9] = 0x9E
    path.write_bytes(image)
    with pytest.raises(confined.BrokenError, match="its library crashed"):
        confined.read_dataset(path, 100, "line")


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    path = tmp_path_factory.mktemp("images") / "run.h5"
    solution_files.save_solution(path, solve(Scene(num_points=64)))
    files = {"solution": path, **{kind: RESULTS / f"{kind}.h5" for kind in ("hertz", "iterations", "kernels")}}
    return {kind: file.read_bytes()[512:] for kind, file in files.items()}


def replace(name, values):
    def edit(file):
        del file[name]
        if values is not None:
            file[name] = values

    return edit


def attributes(**values):
    return lambda file: file.attrs.update({name.replace("__", "."): value for name, value in values.items()})


EDITS = [
    ("solution", replace("x", None)),
    ("solution", replace("x", np.zeros(3))),
    ("solution", replace("profile", np.full(64, np.nan))),
    ("solution", attributes(scene__thickness="thick")),
    ("solution", attributes(status="$" + "{" * 3000 + "$")),
    ("solution", attributes(kind="hertz")),
    ("solution", attributes(kind="[red]\x1b[31m")),
    ("hertz", replace("failures", np.bytes_("[" * 100_000))),
    ("hertz", replace("runs/kappa_subgrid", np.array([b"x"] * 79))),
    ("hertz", replace("runs/contact_area_subgrid", np.zeros(79))),
    ("hertz", replace("lines", np.zeros(3))),
    ("hertz", attributes(configuration="{}")),
    ("hertz", attributes(configuration='{"num_points": ' + "9" * 5000 + "}")),
    ("hertz", attributes(complete="no", results_version="new")),
    ("iterations", replace("runs/name", np.array([str(i).encode() for i in range(1000)]))),
    ("iterations", attributes(configuration='{"tolerance": "$"}')),
    ("kernels", replace("runs/flops", None)),
]


@pytest.mark.parametrize(("kind", "edit"), EDITS)
def test_results_that_hold_something_else_are_one_line(tmp_path, capfd, images, kind, edit):
    content = io.BytesIO(images[kind])
    with h5py.File(content, "a") as file:
        edit(file)
    assert cli.main(["plot", str(sealed(tmp_path / "run.h5", content.getvalue()))]) == 2
    said = capfd.readouterr().err
    assert "run.h5" in said
    assert said.count("\n") == 1
    assert "\x1b" not in said
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize(
    "body",
    [
        *("[" * 100_000, "{}", '{"record": []}', '{"record": {"a": {"b": 1}}}', '{"record": {"a": null}}', "\xff"),
        '{"record": {"a": ' + "9" * 30 + "}}",
        '{"record": {"a": ' + "9" * 5000 + "}}",
    ],
)
def test_records_that_are_none_are_set_aside(tmp_path, body):
    folder, task = tasks.TaskFolder(tmp_path), ensemble_task()
    content = body.encode("latin-1")
    path = tmp_path / f"{tasks.identity(task)}.json"
    path.write_bytes(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
    assert folder.load(task) is None
    assert path.with_name(f"{path.name}.damaged").exists()


def test_records_of_something_else_are_one_line(tmp_path, capfd):
    """They have the tasks' names and right checksums."""
    plan = power_profiles.plan("hertz", power_profiles.quick(hertz.CONFIGURATION))
    folder = tasks.TaskFolder(tmp_path / "tasks")
    for task in plan.tasks:
        folder.save(task, {"a": [1.0], "status": "\x1b[31m[red]"})
    assert cli.main(["study", "hertz", "--quick", "--folder", str(tmp_path)]) == 2
    said = capfd.readouterr().err.splitlines()[-1]
    assert "does not hold what linecontact writes there" in said


ROW = {"kernel": "a", "precision": "b", "log2_points": 3, "variant": "c", "seconds_median": 1.0}


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, "[]", "null", '{"schema": 1}', '{"schema": 1, "results": 3}', '{"schema": 1, "results": [NaN]}']
    + [json.dumps({"schema": 1, "results": [ROW | {"log2_points": value}]}) for value in (1e400, None, "x", [])]
    + ['{"schema": 1, "results": [' + "9" * 5000 + "]}"],
)
def test_comparisons_with_something_else_are_refused(tmp_path, text):
    path = tmp_path / "old.json"
    path.write_text(text)
    with pytest.raises(ValueError, match="compare: "):
        compare.read(path)


def test_kernels_of_huge_size_are_refused(tmp_path, images):
    content = io.BytesIO(images["kernels"])
    with h5py.File(content, "a") as file:
        file["runs/num_points"][...] = 2**40
    with pytest.raises(ValueError, match="compare: "):
        compare.read(sealed(tmp_path / "old.h5", content.getvalue()))
