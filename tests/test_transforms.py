"""Transforms over shared buffers, short ones, plain ones, the wisdom file; and that there are no others."""

import ast
import concurrent.futures
import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pyfftw
import pytest
from linecontact.kernels import record
from linecontact.solver import Layer, RoughIndenter, Scene, solve
from linecontact.solver.transforms import plain, planned, wisdom
from linecontact.solver.transforms.planned import Pair, Transforms, fast_length


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache folder, and a process that has not looked for wisdom yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(wisdom, "_loaded", False)
    pyfftw.forget_wisdom()
    yield tmp_path
    pyfftw.forget_wisdom()


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


@pytest.mark.parametrize("backend", ["warp", "numpy"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("half_length", [False, True])
@pytest.mark.parametrize("n", [1024, 3072, 2**15])
def test_a_symbol_applied_by_real_transforms_and_by_complex_ones_of_half_the_length(n, half_length, precision, backend):
    plan = Transforms(n, precision, half_length=half_length)
    rng = np.random.default_rng(0)
    values, symbol = rng.standard_normal(n).astype(precision), rng.standard_normal(n // 2 + 1)
    source, target = plan.buffer(), plan.buffer()
    parts = plan.forward(source), record(backend, [plan.multiply(symbol, target)]), plan.inverse(target)
    source[:] = values
    for part in parts:
        part()
    exact = np.fft.irfft(np.fft.rfft(values.astype(np.float64)) * symbol, n)
    # rounding of values of size 1 in log2(n) passes, and of coefficients of size 1
    np.testing.assert_allclose(target, exact, rtol=0, atol=3 * np.finfo(precision).eps * np.log2(n))
    np.testing.assert_array_equal(source, values)


@pytest.mark.parametrize("n", [1000, 3072])
def test_long_fields_share_the_spectrums_memory(n, monkeypatch):
    monkeypatch.setattr(planned, "_IN_PLACE", n - 1)
    plan = Transforms(n, "float64", half_length=False)
    field, symbol = plan.field(), np.random.default_rng(0).standard_normal(n // 2 + 1)
    assert np.shares_memory(field, plan.spectrum)
    assert field.shape == plan.buffer().shape
    parts = plan.forward(field), record("warp", [plan.multiply(symbol, field)]), plan.inverse(field)
    field[:n] = values = np.random.default_rng(1).standard_normal(n)
    for part in parts:
        part()
    exact = np.fft.irfft(np.fft.rfft(values) * symbol, n)
    np.testing.assert_allclose(field[:n], exact, rtol=0, atol=3 * np.finfo(float).eps * np.log2(n))
    of_half_length = Transforms(2048, "float64", half_length=True)  # whose kernel reads one while it writes the other
    assert not np.shares_memory(of_half_length.field(), of_half_length.spectrum)
    monkeypatch.setattr(planned, "_IN_PLACE", n)
    assert not np.shares_memory(plan.field(), plan.spectrum)


@pytest.mark.parametrize(
    ("n", "settings", "expected"),
    [
        (2**16, {}, False),
        (2**17, {}, True),
        (2**19, {}, True),
        (2**20, {}, False),
        (2**18 + 2, {}, False),
        (2**18, {"threads": 2}, False),
        (2**18, {"half_length": False}, False),
    ],
)
def test_half_the_length_where_it_is_faster(cache, n, settings, expected):
    assert Transforms(n, "float64", **settings).half_length == expected
    assert not Transforms(n, "float32", **settings).half_length
    assert not Transforms(n, "float64", planning="measure", **settings).half_length


def test_a_measured_plan_is_used_ever_after(cache, monkeypatch):
    monkeypatch.setattr(planned, "_HALF_LENGTH", (1024, 1024))
    assert Transforms(1024, "float64").half_length
    measured = Transforms(1024, "float64", planning="measure")
    measured.forward(measured.buffer())
    begin_anew()
    again = Transforms(1024, "float64")
    again.forward(again.buffer())
    assert (again.half_length, again.known, again.planned) == (False, 1, 0)


def test_tables_of_long_transforms_are_kept_for_one_length(cache, monkeypatch):
    monkeypatch.setattr(planned, "_TABLES", (1024, 4096))
    planned._keep_tables.cache_clear()
    found = []
    for n in (1024, 2048, 2048, 8192):
        transforms = Transforms(n, "float64", half_length=False)
        transforms.forward(transforms.buffer())
        found.append(planned._keep_tables.cache_info())
    assert (found[2].misses, found[2].hits, found[2].currsize) == (2, 1, 1)
    assert found[3].currsize == 0  # longer ones need the memory


@pytest.mark.parametrize("n", [1, 2, 7, 60, 128])
def test_a_short_pair_against_numpy(n):
    pair = Pair(n)
    values = np.random.default_rng(0).standard_normal(n)
    pair.real[:] = values
    pair.forward()
    np.testing.assert_allclose(pair.modes, np.fft.rfft(values), atol=1e-13 * n)
    pair.inverse()
    np.testing.assert_allclose(pair.real / n, values, atol=1e-13)


@pytest.mark.parametrize("n", [7, 60])
def test_plain_transforms_against_their_sums(n):
    values, i, k = np.random.default_rng(0).standard_normal(n), np.arange(n), np.arange(n // 2 + 1)
    modes = plain.rfft(values)
    np.testing.assert_allclose(modes, np.exp(-2j * np.pi * np.outer(k, i) / n) @ values, atol=1e-12)
    np.testing.assert_allclose(plain.irfft(modes, n), values, atol=1e-13)
    np.testing.assert_allclose(plain.hfft(modes.conj(), n) / n, values, atol=1e-13)


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize("n", [4096, 5**6, 65521, 2**18])
def test_long_plain_transforms_against_numpy(monkeypatch, n, kept):
    """With plans and buffers that are kept, and with new ones. Also of arrays that are strided, not aligned, read-only
    or too short, which they leave as they are.
    """
    if not kept:
        monkeypatch.setattr(plain, "_KEPT_UP_TO", 0)
    room = np.random.default_rng(0).standard_normal(2 * n + 1)
    for values in (room[:n], room[1 : n + 1], room[: 2 * n : 2]):
        values = values.view()
        values.flags.writeable = False
        before, modes = values.copy(), plain.rfft(values)
        exact, scale = np.fft.rfft(before), np.sqrt(n * np.log2(n))
        np.testing.assert_allclose(modes, exact, rtol=0, atol=1e-15 * scale)
        np.testing.assert_array_equal(values, before)
        kept = modes.copy()
        np.testing.assert_allclose(plain.irfft(modes, n), before, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(modes, kept)
        np.testing.assert_allclose(plain.irfft(kept, n, overwrite=True), before, rtol=0, atol=1e-14)
        np.testing.assert_allclose(plain.irfft(modes[:100], n), np.fft.irfft(exact[:100], n), rtol=0, atol=1e-15)
        np.testing.assert_allclose(plain.irfft(modes.real, n), np.fft.irfft(exact.real, n), rtol=0, atol=1e-14)
        np.testing.assert_allclose(plain.hfft(modes, n), np.fft.hfft(exact, n), rtol=0, atol=1e-14 * scale**2)


@pytest.mark.parametrize(("n", "count"), [(2**18, 2048), (3 * 2**17, 1000), (2**16, 1), (5**3 * 2**10, 7)])
def test_few_modes_of_a_long_grid_go_by_short_transforms(monkeypatch, n, count):
    random = np.random.default_rng(0)
    modes = random.standard_normal(count) + 1j * random.standard_normal(count)
    exact = np.fft.irfft(modes, n)  # it takes the mean mode as real, too
    transformed = []
    monkeypatch.setattr(plain, "_kept", lambda length: transformed.append(length))
    np.testing.assert_allclose(plain.irfft(modes, n), exact, rtol=0, atol=1e-14 * np.abs(exact).max())
    assert not transformed


def test_plain_transforms_on_several_threads():
    """They share plans and buffers, which are kept."""
    values = np.random.default_rng(0).standard_normal((8, 2**14))
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for _ in range(20):
            back = pool.map(lambda row: plain.irfft(plain.rfft(row), row.size), values)
            np.testing.assert_allclose(np.array(list(back)), values, rtol=0, atol=1e-14)


def test_fast_lengths_are_the_least_with_small_factors():
    assert [fast_length(n) for n in (1, 7, 17, 97, 1009)] == [1, 7, 18, 98, 1024]  # 1014 = 2 x 3 x 13^2 is not


ROOT = Path(__file__).parent.parent
ON_THEIR_OWN = (
    "studies/peers/areas.py",
    "studies/peers/solvers.py",
    "studies/kernel_benchmark/shipped.py",
    "studies/kernel_benchmark/transforms.py",
)
"""Checks, which share no code with what they check, surfaces of areas, and libraries beside each other."""


def transforms_by_hand(source):
    """Lines on which a module uses a library's Fourier transforms."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            base = "." + (getattr(node, "module", None) or "")
            names = [f"{base}.{alias.name}." for alias in node.names]
        elif isinstance(node, ast.Attribute):
            names = [f".{ast.unparse(node)}."]
        else:
            continue
        if any(part in name for name in names for part in (".fft.", ".pyfftw.")):
            found.add(node.lineno)
    return sorted(found)


@pytest.mark.parametrize(
    "source",
    [
        "np.fft.rfft(x)",
        "import numpy.fft",
        "from numpy import fft",
        "from numpy.fft import rfft as transform",
        "import scipy.fft",
        "import pyfftw",
        "from ..transforms.fftw import pyfftw",
        "pyfftw.FFTW(a, b)",
        "def f():\n    from pyfftw.interfaces import numpy_fft",
    ],
)
def test_transforms_by_hand_are_found(source):
    assert transforms_by_hand(source)
    assert not transforms_by_hand("from ..transforms.plain import rfft\nversion('pyfftw')\nrfft(x)\nplain.irfft(x, n)")


def test_all_transforms_go_through_one_room():
    by_hand = {
        file.relative_to(ROOT).as_posix()
        for folder in ("solver", "studies")
        for file in (ROOT / folder).rglob("*.py")
        if transforms_by_hand(file.read_text())
    }
    room = {name for name in by_hand if name.startswith("solver/transforms/")}
    assert room
    assert by_hand - room == set(ON_THEIR_OWN)


def test_wisdom_is_kept_and_read(cache):
    assert not wisdom.wisdom_file().exists()
    planner = Transforms(64, "float64", planning="measure")
    planner.forward(planner.buffer())
    stored = json.loads(wisdom.wisdom_file().read_text())
    assert set(stored) == {"double", "single", "long double"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wisdom._loaded = False
        pyfftw.forget_wisdom()
        empty = len(pyfftw.export_wisdom()[0])
        wisdom.load()
    assert len(pyfftw.export_wisdom()[0]) > empty


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b"\xff\xfe", b'{"double": 3}', b'["x"]', b'{"double": "a", "single": "b", "long double": "c"}'],
)
def test_broken_wisdom_is_ignored_with_a_warning(cache, content):
    path = wisdom.wisdom_file()
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.warns(RuntimeWarning, match="ignored"):
        Transforms(64, "float64")
    wisdom.save()
    assert set(json.loads(path.read_text())) == {"double", "single", "long double"}


def test_unwritable_cache_only_warns(cache):
    (cache / "linecontact").write_text("a file where the folder should be")
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        wisdom.save()


def test_a_user_without_a_home_only_gets_a_warning(cache, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(wisdom.Path, "home", homeless)
    with pytest.warns(RuntimeWarning, match="ignored"):
        wisdom.load()
    with pytest.warns(RuntimeWarning, match="could not be kept"):
        wisdom.save()


def test_wisdom_that_is_no_file_is_ignored(cache):
    """A pipe was waited for, and anything read whole."""
    path = wisdom.wisdom_file()
    path.parent.mkdir(parents=True)
    os.mkfifo(path)
    with pytest.warns(RuntimeWarning, match="is not a file of up to 16 MiB"):
        Transforms(64, "float64")


def begin_anew():
    """Know as little of wisdom as a new process."""
    wisdom._loaded = False
    pyfftw.forget_wisdom()


def plan_both(precision="float64", planning="measure", threads=1):
    """Plans that wisdom held, and new ones, of a forward and an inverse transform."""
    transforms = Transforms(64, precision, threads, planning)
    transforms.forward(transforms.buffer())
    transforms.inverse(transforms.buffer())
    return transforms.known, transforms.planned


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_plan_is_made_once(cache, precision, threads):
    assert plan_both(precision, "estimate", threads) == (0, 2)
    assert not wisdom.wisdom_file().exists()
    assert plan_both(precision, "measure", threads) == (0, 2)
    for planning in ("measure", "estimate"):
        begin_anew()
        before = wisdom.wisdom_file().stat()
        assert plan_both(precision, planning, threads) == (2, 0)
        after = wisdom.wisdom_file().stat()
        assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
    assert plan_both(precision, "patient", threads) == (0, 2)
    begin_anew()
    assert plan_both(precision, "measure", threads) == (2, 0)


def test_what_others_have_stored_is_left_in_the_file(cache):
    assert plan_both("float32") == (0, 2)
    pyfftw.forget_wisdom()  # as a process that began before the file was there
    assert plan_both("float64") == (0, 2)
    begin_anew()
    assert plan_both("float32") == plan_both("float64") == (2, 0)
    assert [path.name for path in wisdom.cache_folder().iterdir()] == [wisdom.wisdom_file().name]


@pytest.fixture
def solve_counted(monkeypatch):
    """`solve` of a scene on nested grids; returns how many measured plans wisdom held, and how many are new."""
    made, begin = [], Transforms.__init__

    def noted(self, *arguments, **options):
        begin(self, *arguments, **options)
        made.append(self)

    def counted(precision="float64", **options):
        made.clear()
        scene = Scene(Layer(0.1), RoughIndenter(0.8, 0, 1 / 4, 1 / 16), 1e-2, num_points=2**12, precision=precision)
        solve(scene, **options)
        measured = [each for each in made if each.planning == "measure"]
        return sum(each.known for each in measured), sum(each.planned for each in measured)

    monkeypatch.setattr(Transforms, "__init__", noted)
    return counted


@pytest.mark.parametrize(
    "options",
    [{}, {"precision": "mixed"}, {"precision": "float32", "threads": 2}, {"accuracy": 1e-2}],
    ids=lambda options: "-".join(map(str, options.values())) or "default",
)
def test_a_second_solve_plans_nothing(cache, solve_counted, options):
    options = {"planning": "measure", **options}
    known, planned = solve_counted(**options)
    assert planned >= 4  # there and back on two grids at least
    begin_anew()
    before = wisdom.wisdom_file().stat()
    assert solve_counted(**options) == (known + planned, 0)
    assert wisdom.wisdom_file().stat().st_ino == before.st_ino


@pytest.mark.parametrize("finished", [2, 3])
def test_interrupted_planning_keeps_every_plan_that_was_finished(cache, solve_counted, monkeypatch, finished):
    """Ctrl-C before the third plan, and while FFTW measures it, which cannot be stopped."""
    fftw, plans = pyfftw.FFTW, []

    def interrupted(*arguments, flags, **options):
        if "FFTW_WISDOM_ONLY" in flags or "FFTW_MEASURE" not in flags:
            return fftw(*arguments, flags=flags, **options)
        if len(plans) == finished:
            raise KeyboardInterrupt
        plans.append(fftw(*arguments, flags=flags, **options))
        if len(plans) == 3:
            raise KeyboardInterrupt
        return plans[-1]

    monkeypatch.setattr(pyfftw, "FFTW", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solve_counted(planning="measure")
    monkeypatch.setattr(pyfftw, "FFTW", fftw)
    begin_anew()
    assert solve_counted(planning="measure") == (finished, 4 - finished)  # 4: there and back on two grids


def test_a_second_process_plans_nothing(cache):
    program = (
        "from linecontact.solver.transforms.planned import Transforms\n"
        "for length in (64, 256):\n"
        "    t = Transforms(length, 'float64', planning='measure')\n"
        "    t.forward(t.buffer()), t.inverse(t.buffer())\n"
        "    print(t.known, t.planned)\n"
    )
    printed = [subprocess.run([sys.executable, "-c", program], capture_output=True, text=True) for _ in range(2)]
    assert [(each.stdout.split(), each.stderr) for each in printed] == [(["0", "2"] * 2, ""), (["2", "0"] * 2, "")]
