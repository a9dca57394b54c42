"""Transforms over shared buffers, and the wisdom file."""

import json
import os
import sys
import warnings

import numpy as np
import pyfftw
import pytest
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.grid import transforms
from linecontact.solver.grid.transforms import Transforms


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache folder, and a process that has not looked for wisdom yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(transforms, "_wisdom_loaded", False)
    return tmp_path


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("n", [16, 1000, 2**12])
def test_round_trip_against_numpy(precision, n):
    plan = Transforms(n, precision)
    source, target = plan.buffer(), plan.buffer()
    forward, inverse = plan.forward(source), plan.inverse(target)
    values = np.random.default_rng(0).standard_normal(n).astype(precision)
    source[:n] = values
    forward()
    modes = plan.spectrum[: n + 2].reshape(-1, 2)
    exact = np.fft.rfft(values.astype(np.float64))
    tolerance = 10 * np.finfo(precision).eps * np.sqrt(n) * np.log2(n)
    np.testing.assert_allclose(modes[:, 0] + 1j * modes[:, 1], exact, atol=tolerance)
    inverse()
    np.testing.assert_allclose(target[:n] / n, values, atol=tolerance)
    assert (target[n:] == 0).all()
    assert (source[:n] == values).all()
    assert source.size % 1024 == 0


def test_wisdom_is_kept_and_read(cache):
    assert not transforms.wisdom_file().exists()
    planner = transforms.Transforms(64, "float64", planning="measure")
    planner.forward(planner.buffer())
    transforms.save_wisdom()
    stored = json.loads(transforms.wisdom_file().read_text())
    assert set(stored) == {"double", "single", "long double"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        transforms._wisdom_loaded = False
        pyfftw.forget_wisdom()
        empty = len(pyfftw.export_wisdom()[0])
        transforms.load_wisdom()
    assert len(pyfftw.export_wisdom()[0]) > empty


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b"\xff\xfe", b'{"double": 3}', b'["x"]', b'{"double": "a", "single": "b", "long double": "c"}'],
)
def test_broken_wisdom_is_ignored_with_a_warning(cache, content):
    path = transforms.wisdom_file()
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.warns(RuntimeWarning, match="ignored"):
        Transforms(64, "float64")
    transforms.save_wisdom()
    assert set(json.loads(path.read_text())) == {"double", "single", "long double"}


def test_unwritable_cache_only_warns(cache):
    (cache / "linecontact").write_text("a file where the folder should be")
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        transforms.save_wisdom()


def test_a_user_without_a_home_only_gets_a_warning(cache, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(transforms.Path, "home", homeless)
    with pytest.warns(RuntimeWarning, match="ignored"):
        transforms.load_wisdom()
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        transforms.save_wisdom()


def test_wisdom_that_is_no_file_is_ignored(cache):
    """A pipe was waited for, and anything read whole."""
    path = transforms.wisdom_file()
    path.parent.mkdir(parents=True)
    os.mkfifo(path)
    with pytest.warns(RuntimeWarning, match="is not a file of up to 16 MiB"):
        Transforms(64, "float64")


@pytest.mark.parametrize("options", [{"accuracy": 1e-2}, {"tolerance": 1e-4}])
def test_plans_that_took_effort_are_kept_after_every_solve(monkeypatch, options):
    kept = []
    monkeypatch.setattr(sys.modules["linecontact.solver.solve"], "save_wisdom", lambda: kept.append(1))
    scene = Scene(Layer(0.1), RoughIndenter(0.8, 0, 1 / 4, 1 / 16), 1e-2, num_points=256)
    solve(scene, **options)
    assert not kept
    solve(scene, planning="measure", **options)
    assert kept == [1]
