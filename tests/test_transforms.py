"""Transforms over shared buffers, short ones, and plain ones."""

import concurrent.futures
import signal
import time

import numpy as np
import pytest
from linecontact.solver.transforms import four_step, plain, planned
from linecontact.solver.transforms.plain import Pair
from linecontact.solver.transforms.planned import WAYS, plan_transforms


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("n", [16, 1000, 2**12])
def test_round_trip_against_numpy(precision, n):
    plan = plan_transforms(n, precision)
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
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("n", [3072, 2**15])
@pytest.mark.parametrize("threads", [1, 3])
def test_a_symbol_applied_in_every_way(threads, n, way, precision, backend):
    plan = plan_transforms(n, precision, threads, backend=backend, way=way)
    rng = np.random.default_rng(0)
    values, symbol = rng.standard_normal(n).astype(precision), rng.standard_normal(n // 2 + 1)
    source, target = plan.buffer(), plan.buffer()
    parts = plan.forward(source), plan.multiplication(symbol), plan.inverse(target)
    source[:] = values
    modes = np.fft.rfft(values.astype(np.float64))
    # rounding of values of size 1 in log2(n) passes, and of coefficients of size 1
    bound = 3 * np.finfo(precision).eps * np.log2(n)
    for _ in range(2):  # nothing is left of the first time
        for part in parts:
            part()
        np.testing.assert_allclose(target, np.fft.irfft(modes * symbol, n), rtol=0, atol=bound)
        np.testing.assert_array_equal(source, values)


@pytest.mark.parametrize("n", [1024, 3072])
def test_real_transforms_in_place(n, monkeypatch):
    """Of other arrays, and of the spectrum's own memory."""
    monkeypatch.setattr(planned, "IN_PLACE", 1024)
    plan, rng = plan_transforms(n, "float64"), np.random.default_rng(0)
    values, symbol = rng.standard_normal(n), rng.standard_normal(n // 2 + 1)
    exact, own, other = np.fft.irfft(np.fft.rfft(values) * symbol, n), plan.field(), plan.buffer()
    for source, target in ((own, own), (other, own), (own, other), (other, plan.buffer())):
        parts = plan.forward(source), plan.multiplication(symbol), plan.inverse(target)
        for _ in range(2):
            source[:] = values
            for part in parts:
                part()
            np.testing.assert_allclose(target, exact, rtol=0, atol=1e-14)
    assert np.shares_memory(own, plan.spectrum)
    np.testing.assert_array_equal(source, values)


def test_shared_work_is_done_once_and_what_fails_is_raised():
    done = []
    four_step.do_all("abc", range(20), lambda worker, part: done.append((part, worker)))
    assert sorted(done) == [(part, "abc"[part % 3]) for part in range(20)]

    def fail(worker, part):
        done.append(part)
        if part == 4:
            raise MemoryError("part 4")

    done.clear()
    with pytest.raises(MemoryError, match="part 4"):
        four_step.do_all("abc", range(9), fail)
    assert sorted(done) == [0, 1, 2, 3, 4, 5, 6, 8]  # the others went on


def test_shared_work_is_ended_before_ctrl_c_is_taken():
    done = []

    def work(worker, part):
        if part == 0:
            signal.raise_signal(signal.SIGINT)
        time.sleep(0.01)
        done.append(part)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell has its background programs ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            four_step.do_all("abc", range(12), work)
    finally:
        signal.signal(signal.SIGINT, before)
    assert sorted(done) == list(range(12))


def test_shared_work_without_another_thread(monkeypatch):
    def no_thread(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(four_step.threading.Thread, "start", no_thread)
    done = []
    four_step.do_all("abc", range(9), lambda worker, part: done.append((part, worker)))
    assert sorted(done) == [(part, "abc"[part % 3]) for part in range(9)]


@pytest.mark.parametrize("n", [1, 1000, 2**10 + 64, 3 * 2**6, 2**16 + 128])
def test_lengths_that_four_steps_do_not_suit(n):
    allowed = "R C with C a power of two from 64 to 4096 and R even, at most 16 C"
    with pytest.raises(ValueError, match=f"num_points is {n}; allowed for four steps: {allowed}"):
        plan_transforms(n, "float64", way="four-step")


@pytest.mark.parametrize(
    ("n", "settings", "expected"),
    [
        (2**19, {}, "real"),
        (2**20, {}, "four-step"),
        (2**20 + 2, {}, "real"),
        (2**20 + 128, {}, "real"),
        (2**20, {"precision": "float32", "threads": 2, "planning": "measure"}, "four-step"),
        (2**20, {"way": "real"}, "real"),
    ],
)
def test_the_way_that_is_fastest(wisdom_cache, n, settings, expected):
    assert plan_transforms(n, **{"precision": "float64"} | settings).way == expected


@pytest.fixture(params=[False, True])
def long(request, monkeypatch):
    """All pairs are long ones, which are in place and are made anew."""
    if request.param:
        monkeypatch.setattr(plain, "IN_PLACE", 0)
        monkeypatch.setattr(plain, "_TOO_LONG", 0)
    return request.param


@pytest.mark.parametrize("n", [1, 2, 7, 60, 128])
def test_a_pair_against_numpy(n, long):
    pair = Pair(n)
    values = np.random.default_rng(0).standard_normal(n)
    pair.real[:] = values
    pair.forward()
    np.testing.assert_allclose(pair.modes, np.fft.rfft(values), atol=1e-13 * n)
    assert np.shares_memory(pair.real, pair.modes) == long
    pair.inverse()
    np.testing.assert_allclose(pair.real / n, values, atol=1e-13)


@pytest.mark.parametrize("n", [5, 128, 3 * 2**9])
def test_a_pair_with_a_symbol_in_between(n, long):
    pair, rng = Pair(n), np.random.default_rng(0)
    values, symbol = rng.standard_normal(n), rng.random(n // 2 + 1)
    for _ in range(2):
        pair.multiply(values, symbol)
        np.testing.assert_allclose(pair.real, np.fft.irfft(np.fft.rfft(values) * symbol, n), atol=1e-13)
        pair.real[:] = values
        every = np.concatenate([symbol, symbol[(n - 1) // 2 : 0 : -1]])
        assert pair.power(symbol) == pytest.approx(float(every @ np.abs(np.fft.fft(values)) ** 2) / n, rel=1e-12)


@pytest.mark.parametrize("n", [128, 1024, 3 * 2**9])
def test_an_inverse_transform_by_a_pair(n, long):
    values, pair = np.random.default_rng(0).standard_normal(n), Pair(n)
    modes = np.fft.rfft(values)
    modes[[0, -1]] += 3j  # has no meaning and is taken as 0, as NumPy does
    for given in (modes, modes.real, modes[:9]):
        pair.invert(given)
        np.testing.assert_allclose(pair.real, np.fft.irfft(given, n), atol=1e-13)


@pytest.mark.parametrize("n", [4096, 5**6, 65521, 2**18])
def test_long_plain_transforms_against_numpy(n, long):
    """With plans and buffers that are kept, and with new ones. Also of arrays that are strided, not aligned, read-only
    or too short, which they leave as they are.
    """
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
        np.testing.assert_allclose(plain.irfft(modes[:100], n), np.fft.irfft(exact[:100], n), rtol=0, atol=1e-15)
        np.testing.assert_allclose(plain.irfft(modes.real, n), np.fft.irfft(exact.real, n), rtol=0, atol=1e-14)


def test_plain_transforms_on_several_threads():
    """They share plans and buffers, which are kept."""
    values = np.random.default_rng(0).standard_normal((8, 2**14))
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for _ in range(20):
            back = pool.map(lambda row: plain.irfft(plain.rfft(row), row.size), values)
            np.testing.assert_allclose(np.array(list(back)), values, rtol=0, atol=1e-14)
