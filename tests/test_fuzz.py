"""Files and arguments from anywhere: each ends in a result or in one line, never in a traceback, a hang or a crash.

The cases are what longer runs have found; a short run of each kind, with fixed seeds, goes on looking.
"""

import contextlib
import hashlib
import io
import json
import os
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from linecontact import studies
from linecontact.solver import Scene, solve
from linecontact.studies import cli
from linecontact.studies.files import confined, hdf5, profile_columns, scans, solution_files, study_files, writing
from linecontact.studies.kernel_benchmark import compare
from linecontact.studies.power_profiles import tasks as power_profiles
from linecontact.studies.runner import drawing, run, tasks
from linecontact.studies.terminal import console

RESULTS = Path(studies.__file__).parent / "results"
HEIGHTS = np.sin(np.arange(40.0))
fuzz = settings(
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def read(path, content=None, **options):
    if content is not None:
        path.write_bytes(content)
    return scans.read(scans.Options(path, **options))


def scene(path, content):
    indenter, period, n = read(path, content)
    return Scene(indenter=indenter, period=period, num_points=n)


def header(text):
    text = text.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npz(array):
    file = io.BytesIO()
    np.savez(file, array)
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (16,)}"), "damaged"),
        (header("{'descr': '|V0', 'fortran_order': False, 'shape': (16,)}"), "real numbers"),
        (header("(" * 60), "damaged"),
        (npz(HEIGHTS), "damaged"),
        (npy(HEIGHTS.astype(complex)), "complex128"),
        (npy(np.zeros(40, [("x", "f8"), ("z", "f8")])), "real numbers"),
        (npy(np.array(1.0)), r"shape \(\)"),
        (npy(np.zeros((0, 2))), "damaged|0 values"),
        (npy(1e308 * np.sign(HEIGHTS)), "too large; allowed: finite numbers up to 1e\\+100"),
        (npy(5e-324 * np.arange(40.0) % 1e-322), "height ranges over"),
        (npy(np.stack([np.append(np.arange(39.0), np.inf), HEIGHTS], 1)), "x number"),
        (npy(np.stack([np.append(-1e308, np.linspace(1, 1e308, 39)), HEIGHTS], 1)), "x number 1 is too large"),
    ],
)
def test_arrays_that_are_none(tmp_path, content, named):
    with pytest.raises(ValueError, match=named):
        scene(tmp_path / "scan.npy", content)


def test_arrays_in_any_order_are_read(tmp_path):
    table = np.stack([np.arange(40.0), HEIGHTS], 1)
    expected, *_ = read(tmp_path / "scan.npy", npy(table))
    for array in (np.asfortranarray(table), table.astype(">f8"), table.astype(np.longdouble)):
        found, *_ = read(tmp_path / "scan.npy", npy(array))
        np.testing.assert_allclose(found.heights, expected.heights, atol=1e-14)


def test_what_is_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(profile_columns, "MAX_VALUES", 39)
    monkeypatch.setattr(profile_columns, "MAX_TEXT", 1000)
    with pytest.raises(ValueError, match="40 numbers; allowed: up to 39"):
        read(tmp_path / "scan.npy", npy(HEIGHTS))
    with pytest.raises(ValueError, match="allowed: 1000 bytes"):
        read(tmp_path / "scan.csv", b"1\n2\n" * 251)
    with h5py.File(tmp_path / "scan.h5", "w") as file:
        file["line"] = HEIGHTS
    with pytest.raises(ValueError, match=r"shape \(40,\); allowed: up to 39"):
        read(tmp_path / "scan.h5")


@pytest.mark.parametrize("content", [b"1 " * 10**6, b"\0" * 1000, b"\xff\xfe" + "1\n2\n".encode("utf-16le") * 40])
def test_text_that_is_none(tmp_path, content):
    with pytest.raises(ValueError, match="no table"):
        read(tmp_path / "scan.txt", content)


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_what_is_no_file_is_refused_at_once(tmp_path):
    pipe = tmp_path / "x.json"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero"), tmp_path, tmp_path / ("a" * 300)):
        with pytest.raises(ValueError, match="not a file"):
            read(path)
        with pytest.raises(writing.StoreError, match="allowed: an HDF5 file"):
            study_files.load_study(path)
        with pytest.raises(ValueError, match="no regular file"):
            compare.read(path)
    folder = tasks.TaskFolder(tmp_path / "tasks")
    task = ensemble_task()
    os.mkfifo(folder.folder / f"{tasks.identity(task)}.json")
    with pytest.raises(writing.StoreError, match="no regular file"):
        folder.load(task)
    with pytest.raises(writing.StoreError, match="longer than 200 bytes"):
        writing.check_target(tmp_path / ("a" * 201), overwrite=True)


def ensemble_task():
    return power_profiles.plan("hertz", cli.hertz.CONFIGURATION).tasks[0]


def external(file):
    file.create_dataset("line", (40,), "f8", external=[("/etc/passwd", 0, 320)])


def virtual(file):
    layout = h5py.VirtualLayout((40,), "f8")
    layout[:] = h5py.VirtualSource("/other.h5", "line", (40,))
    file.create_virtual_dataset("line", layout)


def unfilled(file):
    file.create_dataset("line", (2**20, 2**20), "f8")


def bomb(file):
    file.create_dataset("line", (40,), "f8", maxshape=(None,), chunks=(2**28,))


def plugin(file):
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((40,))
    properties.set_filter(31999, h5py.h5z.FLAG_OPTIONAL)
    space = h5py.h5s.create_simple((40,))
    h5py.h5d.create(file.id, b"line", h5py.h5t.IEEE_F64LE, space, properties)


def objects(file):
    file.create_dataset("line", (40,), h5py.ref_dtype)


def variable(file):
    file.create_dataset("line", (40,), h5py.vlen_dtype("f8"))


def cycle(file):
    file["runs/again"] = file.create_group("runs")


def linked(file):
    file["runs"] = h5py.ExternalLink("/other.h5", "/runs")


def soft(file):
    file["runs"] = h5py.SoftLink("/runs")


def attribute(file):
    file.attrs["kind"] = np.zeros(1000)


def long_text(file):
    file.attrs["kind"] = "x" * (2**20 + 1)


@pytest.mark.parametrize("make", [external, virtual, unfilled, bomb, plugin, objects, variable])
def test_datasets_that_ask_for_more_are_refused(tmp_path, make):
    """As a profile and in a result; in this process, which none of these harms."""
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        make(file)
    with pytest.raises(confined.RefusedError, match="line"):
        confined._dataset(str(path), str(2**26))
    with pytest.raises(confined.RefusedError, match="line"):
        confined._result(str(path))


@pytest.mark.parametrize("make", [cycle, linked, soft, attribute, long_text])
def test_results_are_plain(tmp_path, make):
    path = tmp_path / "result.h5"
    with h5py.File(path, "w") as file:
        make(file)
    with pytest.raises(confined.RefusedError, match=r"allowed|neither"):
        confined._result(str(path))


def sealed(path, image):
    """A result with a right checksum, whatever it holds."""
    path.write_bytes(hdf5.head(hashlib.sha256(image).hexdigest()) + image)
    return path


def endless_heap(image):
    """The free space of the heap of texts, of no size: HDF5 looks for its end for ever."""
    heap = image.index(b"GCOL")
    image[heap + 48 : heap + 56] = bytes(8)


def odd_type(image):
    """Text of variable length that is neither text nor a sequence: HDF5 crashes."""
    kind = image.index(b"kind\0\0\0\0\x19\x01")
    image[kind + 9] = 0x9E


@pytest.mark.parametrize("harm", [endless_heap, odd_type])
def test_what_hdf5_does_not_survive_is_one_line(tmp_path, monkeypatch, capfd, harm):
    monkeypatch.setattr(confined, "SECONDS", 1)
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        file.attrs["kind"] = "solution"
        file.flush()
        image = bytearray(file.id.get_file_image())
    harm(image)
    assert cli.main(["plot", str(sealed(tmp_path / "run.h5", bytes(image)))]) == 2
    said = capfd.readouterr().err
    assert "is damaged" in said
    assert said.count("\n") == 1


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
    ("solution", replace("x", np.array([b"a"] * 64))),
    ("solution", replace("profile", np.full(64, np.nan))),
    ("solution", replace("profile", np.zeros((64, 2)))),
    ("solution", attributes(scene__thickness="thick")),
    ("solution", attributes(status="$\\frac{$")),
    ("solution", attributes(status="$" + "{" * 3000 + "$")),
    ("solution", attributes(kind="hertz")),
    ("solution", attributes(kind="[red]\x1b[31m")),
    ("hertz", replace("failures", np.bytes_("[" * 100_000))),
    ("hertz", replace("failures", np.bytes_("[1]"))),
    ("hertz", replace("runs/kappa", np.zeros(3))),
    ("hertz", replace("runs/kappa_subgrid", np.array([b"x"] * 79))),
    ("hertz", replace("runs/contact_area_subgrid", np.zeros(79))),
    ("hertz", replace("lines", np.zeros(3))),
    ("hertz", attributes(configuration="{}")),
    ("hertz", attributes(configuration='{"num_points": ' + "9" * 5000 + "}")),
    ("hertz", attributes(configuration="[]")),
    ("hertz", attributes(complete="no", results_version="new")),
    ("iterations", replace("runs/name", np.array([str(i).encode() for i in range(1000)]))),
    ("iterations", attributes(configuration='{"tolerance": "$"}')),
    ("kernels", replace("runs/flops", None)),
]


@pytest.mark.parametrize(("kind", "edit"), EDITS)
def test_results_that_hold_something_else_are_one_line(tmp_path, monkeypatch, capfd, images, kind, edit):
    monkeypatch.setattr(confined, "check_result", lambda path: confined._result(str(path)))
    content = io.BytesIO(images[kind])
    with h5py.File(content, "a") as file:
        edit(file)
    assert cli.main(["plot", str(sealed(tmp_path / "run.h5", content.getvalue()))]) == 2
    said = capfd.readouterr().err
    assert "run.h5" in said
    assert said.count("\n") == 1
    assert "\x1b" not in said
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_a_sound_result_is_checked_once(tmp_path, monkeypatch, images):
    asked = []
    monkeypatch.setattr(confined, "check_result", asked.append)
    path = sealed(tmp_path / "run.h5", images["iterations"])
    monkeypatch.setattr(hdf5, "_sound", set())
    for _ in range(2):
        assert len(study_files.load_study(path).runs) == 21
    assert asked == [path]
    study_files.save_study(path, study_files.load_study(path))
    study_files.load_study(path)
    assert asked == [path]


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
    plan = power_profiles.plan("hertz", power_profiles.quick(cli.hertz.CONFIGURATION))
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
    with pytest.raises(ValueError, match="compare: file"):
        compare.read(path)


def test_kernels_of_huge_size_are_no_hang(tmp_path, monkeypatch, images):
    monkeypatch.setattr(confined, "check_result", lambda path: confined._result(str(path)))
    content = io.BytesIO(images["kernels"])
    with h5py.File(content, "a") as file:
        file["runs/log2_points"][...] = 2**40
    path = sealed(tmp_path / "old.h5", content.getvalue())
    with pytest.raises(ValueError, match="compare: file"):
        compare.read(path)


def test_text_is_shown_as_it_is(capfd):
    console.Output().print("[red]a[/blue] :smile: \x1b[31m\udc80")
    assert capfd.readouterr().out == "[red]a[/blue] :smile: \\x1b[31m\\udc80\n"


@pytest.mark.skipif(sys.platform != "linux", reason="names of any bytes")
def test_names_that_are_no_text(tmp_path):
    path = tmp_path / "b\udc80.csv"
    indenter, period, n = read(path, "".join(f"{i} {z}\n" for i, z in enumerate(HEIGHTS)).encode(), num_points=40)
    solution = solve(Scene(indenter=indenter, period=period, num_points=n))
    solution_files.save_solution(tmp_path / "run\udc80.h5", solution)
    assert solution_files.load_solution(tmp_path / "run\udc80.h5")[1]["scene.profile_file"] == "b\\x80.csv"


def test_too_little_memory_is_one_line(capfd):
    def greedy():
        raise MemoryError("8 EiB")

    assert console.guard(greedy) == 2
    assert capfd.readouterr().err.count("\n") == 1


def test_a_refusal_is_all_there_is_to_say(capfd):
    assert cli.main(["study", "peers", "--workers", "0"]) == 2
    assert capfd.readouterr().err.count("\n") == 1


def mutants(content):
    """Valid content with a few bytes changed, cut out, put in or repeated."""

    def change(edits):
        data = bytearray(content)
        for place, length, new in edits:
            place = place % (len(data) + 1)
            data[place : place + length] = new
        return bytes(data)

    return st.lists(st.tuples(st.integers(0, 2**20), st.integers(0, 64), st.binary(max_size=16)), max_size=4).map(
        change
    )


def refused_or_read(path, content):
    """A few thousand of them were tried once; what is read must be a profile."""
    with contextlib.suppress(ValueError):
        assert scene(path, content).profile.min() == 0


TEXT = b"x;z\n" + "".join(f"{i};{z:.3f}\n" for i, z in enumerate(HEIGHTS)).encode()


@settings(fuzz, max_examples=150)
@given(st.one_of(mutants(TEXT), st.binary(max_size=300), st.text("0123456789.,;-+eE_naif \n\r\0", max_size=400)))
def test_any_text(tmp_path, content):
    refused_or_read(tmp_path / "scan.csv", content if isinstance(content, bytes) else content.encode())


@settings(fuzz, max_examples=150)
@given(st.one_of(mutants(npy(HEIGHTS)), mutants(npy(np.stack([np.arange(40.0), HEIGHTS], 1))), st.binary(max_size=200)))
@pytest.mark.filterwarnings("ignore::UserWarning", "ignore::SyntaxWarning", "ignore::DeprecationWarning")
def test_any_array(tmp_path, content):
    refused_or_read(tmp_path / "scan.npy", content)


def one_dataset():
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        file.create_dataset("line", data=HEIGHTS, chunks=(16,), compression="gzip", shuffle=True)
        file.flush()
        return file.id.get_file_image()


@settings(fuzz, max_examples=6)
@given(mutants(one_dataset()))
def test_any_hdf5(tmp_path, content):
    refused_or_read(tmp_path / "scan.h5", content)


@settings(fuzz, max_examples=6)
@given(st.data())
def test_any_result(tmp_path, images, data):
    path = sealed(tmp_path / "run.h5", data.draw(mutants(images["iterations"])))
    with contextlib.suppress(writing.StoreError):
        drawing.draw(path)


FLAGS = [f"--{name.replace('_', '-')}" for name in cli.Solve.__dataclass_fields__]
STUDY = ["--workers", "--memory", "--scheduler", "--folder", "--quick", "--overwrite"]
VALUES = st.one_of(
    st.sampled_from(
        [
            "nan",
            "-inf",
            "-0.0",
            "1e400",
            "5e-324",
            "1_0",
            "-1",
            "0",
            "16",
            "64",
            "0.5",
            "file",
            "rough",
            "mixed",
            "fire",
            "none",
            "/dev/zero",
            "tcp://[",
            "--",
            "=",
            "[/red]",
        ]
    ),
    st.sampled_from(["", "\n", "\x1b[31m", "\udc80", "9" * 400, "a" * 300]),
    st.floats().map(str),
    st.integers().map(str),
    st.text(st.characters(exclude_characters="\0"), max_size=8),
)


@settings(fuzz, max_examples=150)
@given(
    st.sampled_from(
        [["solve", "--num-points", "16"], ["study", "hertz"], ["study", "kernels"], ["plot"], ["info"], []]
    ),
    st.lists(st.tuples(st.sampled_from(FLAGS + STUDY + ["--compare", "--threshold"]), VALUES), max_size=3),
    st.lists(VALUES, max_size=1),
)
def test_any_arguments(tmp_path, monkeypatch, capfd, command, options, rest):
    """No solve is large, and no study is run."""
    real = cli.solve
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "solve", lambda scene, **more: real(scene, **more) if scene.num_points <= 64 else stop())
    monkeypatch.setattr(run, "_compute", lambda *_: stop())
    try:
        status = cli.main([*command, *(word for option in options for word in option), *rest])
    except SystemExit as stopped:
        status = stopped.code or 0
    said = capfd.readouterr().err
    assert status in (0, 2, 3)
    if status == 2:
        assert said.count("\n") == 1
        assert said.startswith("linecontact: ")
        assert "\x1b" not in said


def stop():
    raise ValueError("not here")
