"""FFTW's wisdom: its file, broken and shared ones, and plans that are made once."""

import collections
import json
import os
import subprocess
import sys
import warnings

import pyfftw
import pytest
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.grid import cached
from linecontact.solver.transforms import wisdom
from linecontact.solver.transforms.planned import plan_transforms


def begin_anew():
    """Know as little of wisdom as a new process."""
    wisdom._loaded = False
    pyfftw.forget_wisdom()
    cached.forget()


@pytest.fixture
def plans(monkeypatch):
    """Plans of a solve's transforms: those that wisdom held, and new ones."""
    made, fftw = collections.Counter(), pyfftw.FFTW

    def counted(*arrays, flags, **options):
        plan = fftw(*arrays, flags=flags, **options)
        made["known" if "FFTW_WISDOM_ONLY" in flags else "new" if "FFTW_ESTIMATE" not in flags else "estimated"] += 1
        return plan

    monkeypatch.setattr(pyfftw, "FFTW", counted)
    return made


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b"\xff\xfe", b'{"double": 3}', b'["x"]', b'{"double": "a", "single": "b", "long double": "c"}'],
)
def test_broken_wisdom_is_ignored_with_a_warning(wisdom_cache, content):
    path = wisdom.wisdom_file()
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.warns(RuntimeWarning, match="ignored"):
        plan_transforms(64, "float64")
    wisdom.save()
    assert set(json.loads(path.read_text())) == {"double", "single", "long double"}


def test_unwritable_cache_only_warns(wisdom_cache):
    (wisdom_cache / "linecontact").write_text("a file where the folder should be")
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        wisdom.save()


def test_a_user_without_a_home_only_gets_a_warning(wisdom_cache, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(wisdom.Path, "home", homeless)
    with pytest.warns(RuntimeWarning, match="ignored"):
        wisdom.load()
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        wisdom.save()


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_wisdom_that_is_no_file_is_ignored_once(wisdom_cache, make):
    """A pipe was waited for, and nothing could be kept."""
    path = wisdom.wisdom_file()
    path.parent.mkdir(parents=True)
    make(path)
    with pytest.warns(RuntimeWarning, match="was broken and is ignored"):
        plan_transforms(64, "float64")
    with warnings.catch_warnings(action="error"):
        wisdom.save()
    assert path.is_file()


def plan_both(plans, precision="float64", planning="measure", threads=1):
    """Plans that wisdom held, and new ones, of a forward and an inverse transform."""
    transforms = plan_transforms(64, precision, threads, planning)
    plans.clear()
    transforms.forward(transforms.buffer())
    transforms.inverse(transforms.buffer())
    return plans["known"], plans["new"]


@pytest.mark.parametrize(("precision", "threads"), [("float64", 1), ("float32", 2)])
def test_a_plan_is_made_once(wisdom_cache, plans, precision, threads):
    assert plan_both(plans, precision, "estimate", threads) == (0, 0)
    assert plans["estimated"] == 2
    assert not wisdom.wisdom_file().exists()
    assert plan_both(plans, precision, "measure", threads) == (0, 2)
    for planning in ("measure", "estimate"):
        begin_anew()
        before = wisdom.wisdom_file().stat()
        assert plan_both(plans, precision, planning, threads) == (2, 0)
        after = wisdom.wisdom_file().stat()
        assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
    assert plan_both(plans, precision, "patient", threads) == (0, 2)
    begin_anew()
    assert plan_both(plans, precision, "measure", threads) == (2, 0)


def test_what_others_have_stored_is_left_in_the_file(wisdom_cache, plans):
    assert plan_both(plans, "float32") == (0, 2)
    pyfftw.forget_wisdom()  # as a process that began before the file was there
    assert plan_both(plans, "float64") == (0, 2)
    begin_anew()
    assert plan_both(plans, "float32") == plan_both(plans, "float64") == (2, 0)
    assert [path.name for path in wisdom.cache_folder().iterdir()] == [wisdom.wisdom_file().name]


@pytest.fixture
def solve_counted(plans):
    """`solve` of a scene on nested grids; returns how many measured plans wisdom held, and how many are new."""

    def counted(precision="float64", **options):
        plans.clear()
        scene = Scene(Layer(0.1), RoughIndenter(0.8, 0, 1 / 4, 1 / 16), 1e-2, num_points=2**12, precision=precision)
        solve(scene, **options)
        return plans["known"], plans["new"]

    return counted


@pytest.mark.parametrize(
    "options",
    [
        {"precision": "mixed", "method": "mass-weighted-fire", "nested": True, "tolerance": 1e-3},
        {"precision": "float32", "threads": 2},
        {"accuracy": 1e-2},
    ],
    ids=lambda options: "-".join(map(str, options.values())),
)
def test_a_second_solve_plans_nothing(wisdom_cache, solve_counted, options):
    options = {"planning": "measure", **options}
    known, planned = solve_counted(**options)
    assert planned >= 4  # there and back on two grids at least
    begin_anew()
    before = wisdom.wisdom_file().stat()
    assert solve_counted(**options) == (known + planned, 0)
    assert wisdom.wisdom_file().stat().st_ino == before.st_ino


@pytest.mark.parametrize("finished", [2, 3])
def test_interrupted_planning_keeps_every_plan_that_was_finished(wisdom_cache, solve_counted, monkeypatch, finished):
    """Ctrl-C before the third plan, and while FFTW measures it, which cannot be stopped."""
    fftw, made = pyfftw.FFTW, []

    def interrupted(*arguments, flags, **options):
        if "FFTW_WISDOM_ONLY" in flags or "FFTW_MEASURE" not in flags:
            return fftw(*arguments, flags=flags, **options)
        if len(made) == finished:
            raise KeyboardInterrupt
        made.append(fftw(*arguments, flags=flags, **options))
        if len(made) == 3:
            raise KeyboardInterrupt
        return made[-1]

    monkeypatch.setattr(pyfftw, "FFTW", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solve_counted(planning="measure")
    monkeypatch.setattr(pyfftw, "FFTW", fftw)
    begin_anew()
    assert solve_counted(planning="measure") == (finished, 4 - finished)  # 4: there and back on two grids


def test_a_second_process_plans_nothing(wisdom_cache):
    program = (
        "from linecontact.solver.transforms.planned import plan_transforms\n"
        "import pyfftw\n"
        "for length in (64, 256):\n"
        "    t = plan_transforms(length, 'float64', planning='measure')\n"
        "    before = pyfftw.export_wisdom()\n"
        "    t.forward(t.buffer()), t.inverse(t.buffer())\n"
        "    print(pyfftw.export_wisdom() == before)\n"
    )
    printed = [subprocess.run([sys.executable, "-c", program], capture_output=True, text=True) for _ in range(2)]
    assert [(each.stdout.split(), each.stderr) for each in printed] == [(["False"] * 2, ""), (["True"] * 2, "")]
