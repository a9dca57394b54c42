"""Transforms over shared buffers, short ones, and plain ones."""

import concurrent.futures

import numpy as np
import pytest
from linecontact.kernels import record
from linecontact.solver.transforms import plain, planned
from linecontact.solver.transforms.planned import Pair, Transforms


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
def test_half_the_length_where_it_is_faster(wisdom_cache, n, settings, expected):
    assert Transforms(n, "float64", **settings).half_length == expected
    assert not Transforms(n, "float32", **settings).half_length
    assert not Transforms(n, "float64", planning="measure", **settings).half_length


def test_tables_of_long_transforms_are_kept_for_one_length(wisdom_cache, monkeypatch):
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
