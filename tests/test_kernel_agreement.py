"""The kernels' benchmark times nothing that does something else: one wrong node, or sum, is found."""

import numpy as np
import pytest
from linecontact.kernels import CHUNK, layout
from linecontact.studies.kernel_benchmark import agreement, shipped, transforms, variants
from linecontact.studies.kernel_benchmark.bench import Bench
from linecontact.studies.kernel_benchmark.benchmark import PRECISIONS
from linecontact.studies.kernel_benchmark.benchmarks import BENCHMARKS

SMALL = [name for name, one in BENCHMARKS.items() if one.group != "roofs"]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", SMALL)
def test_all_variants_agree(name, precision, monkeypatch):
    monkeypatch.setattr(transforms, "MOST_SECONDS", 0.1)
    benchmark = BENCHMARKS[name]
    bench = Bench(benchmark, precision, 2 * CHUNK)
    expected = {variant.name for variant in shipped.shipped(benchmark)}
    assert bench.variants.keys() == expected
    assert {"numpy"} <= expected
    bench.check()
    before = {name: array.copy() for name, array in bench.arrays.items()}
    next(iter(bench.variants.values()))(1)()
    assert any((bench.arrays[n] != before[n]).any() for n in before)
    bench.restore()
    for argument in benchmark.arrays:
        if argument.role == "inout" and argument.name != "spectrum":
            np.testing.assert_array_equal(bench.arrays[argument.name], before[argument.name])


# for each role an array of one of the benchmarks
WRONG = {a.role: (n, a.name) for n in SMALL if not BENCHMARKS[n].transforms for a in BENCHMARKS[n].arrays}


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("name", "array"), WRONG.values(), ids=list(WRONG))
def test_one_wrong_value_is_an_error(name, array, precision):
    """A single value in its last place, and a sum by less than any wrong node would change it; inputs among them."""
    bench = Bench(BENCHMARKS[name], precision, 4 * CHUNK, only={"warp"})
    good = bench.variants["warp"]
    role = next(a.role for a in bench.benchmark.arrays if a.name == array)

    def wrong():
        good(1)()
        values = bench.arrays[array]
        index = layout.MIX if role in ("state", "control") else values.size // 2
        values[index] = values[index] + 2**-12 if role == "sum" else np.nextafter(values[index], np.inf)

    bench.variants["warp"] = variants.repeated(wrong)
    with pytest.raises(RuntimeError, match=f"warp and numpy disagree in 1 of .* values of {array}: number"):
        bench.check()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    ("name", "array", "change"),
    [
        ("real_pair", "target", 1e-9),
        ("rows_pair", "rows", 1e-9),
        ("plain_iteration", "u", 1e-9),
        ("plain_iteration", "sums", 1e-3),
        ("plain_iteration", "sums of held nodes", 2),
        ("mass_weighted_iteration", "acceleration_sums", 1e-3),
        ("plain_iteration", "state", 1e-6),
    ],
)
def test_one_wrong_value_after_a_transform_is_an_error(name, array, change, precision):
    """Rounding of transforms in float32 is 5e8 times that in float64; a count of nodes is a count."""
    first = "estimate" if name.endswith("pair") else "warp"
    bench = Bench(BENCHMARKS[name], precision, 2**14, only={first})
    held, array = array == "sums of held nodes", array.split()[0]
    chunks = 2**14 // CHUNK
    index = layout.HOLDING * chunks + 7 if held else layout.RESIDUAL if array == "state" else 7
    good, loss = bench.variants[first], 2.0**29 if precision == "float32" and not held else 1.0

    def wrong(repeats):
        run = good(repeats)

        def once():
            run()
            values = bench.arrays[array]
            among = values[index // chunks * chunks :][:chunks] if array == "sums" else values
            largest = max(1.0, float(np.abs(among).max())) if array != "state" else values[index]
            few = array == "sums" and not held
            values[index] += min(change * loss, 0.5 * largest) if few else change * loss * largest

        return once

    bench.variants[first] = wrong
    with pytest.raises(RuntimeError, match=f"disagree in 1 of .* values of {array}: number {index}"):
        bench.check()


@pytest.mark.parametrize(
    ("name", "points", "change", "message"),
    [
        (
            "fire_step",
            2**12,
            lambda bench, good: lambda n: lambda: good(1)(),
            "something else when it is told to do it",
        ),
        (
            "net_force",
            2**12,
            lambda bench, good: lambda n: lambda: _leaves_out(bench, good(n)),
            "number 5 is nan",
        ),
        ("fire_step", 2**18, lambda bench, good: lambda n: lambda: _shifted(bench, good(n)), "disagree in"),
        ("fire_step", 2**12, lambda bench, good: lambda n: lambda: None, "disagree in"),
    ],
)
def test_what_a_variant_may_get_wrong(name, points, change, message):
    """It ignores how often; it leaves a node out; it takes the nodes of another chunk; it does nothing."""
    bench = Bench(BENCHMARKS[name], "float32", points, only={"warp"})
    bench.variants["warp"] = change(bench, bench.variants["warp"])
    with pytest.raises(RuntimeError, match=message):
        bench.check()


def _leaves_out(bench, run):
    run()
    bench.arrays["force"][5] = np.nan


def _shifted(bench, run):
    run()
    u, v = bench.arrays["u"], bench.arrays["v"]
    for values in (u, v):
        values[2**17 : 2**17 + 2**16] = values[: 2**16]


def test_a_node_within_rounding_of_the_wall_may_be_on_it_and_no_other():
    h, v = np.full(2048, 0.5), np.full(2048, 0.25)
    u = np.where(np.arange(2048) % 2, 0.5 - 1e-16, 0.25)
    wanted = {"u": u, "v": v, "h": h}
    argument = next(a for a in BENCHMARKS["plain_iteration"].arrays if a.name == "v")
    near, far = v.copy(), v.copy()
    near[1] = far[2] = layout.TOUCHING
    agreement.compare("mine", argument, {**wanted, "v": near}, wanted, transforms=True)
    with pytest.raises(RuntimeError, match="number 2 is"):
        agreement.compare("mine", argument, {**wanted, "v": far}, wanted, transforms=True)


@pytest.mark.parametrize("chunk", [64, 4096, 8192])
def test_sums_over_other_chunks_are_compared_too(chunk, own):
    variants.recompiled("plain_sums", "other", chunk=chunk)
    bench = Bench(BENCHMARKS["plain_sums"], "float32", 8192)
    bench.check()
    good = bench.variants["other"]
    sums = bench._views["other"].arrays["sums"]
    assert sums.size == layout.PARTS * 8192 // chunk

    def wrong():
        good(1)()
        sums[0] += 1 / 64

    bench.variants["other"] = variants.repeated(wrong)
    with pytest.raises(RuntimeError, match="other and numpy disagree in 1 of"):
        bench.check()
