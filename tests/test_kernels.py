"""Every kernel against its reference, in both precisions, on lengths around the chunk; and proof of vector code."""

import os
import re
import subprocess
import sys
import threading

import numpy as np
import pytest
import warp as wp
from linecontact.kernels import CHUNK, KERNELS, Call, layout, padded_length, recompile, record

PRECISIONS = ["float32", "float64"]
LENGTHS = [1, CHUNK, 2 * CHUNK + 17]

ELEMENTWISE = {
    "spectral_multiply": ("coefficient", "spectrum"),
    "net_force": ("load", "elastic", "v", "force", "sums"),
    "plain_sums": ("elastic", "v", "sums"),
    "restrict_to_free": ("force", "field", "sum"),
    "fire_step": ("acceleration", "h", "state", "u", "v"),
    "plain_step": ("elastic", "h", "state", "u", "v"),
    "advance_response": ("change", "gap state", "response"),
}
NUM_OUTPUTS = {
    "spectral_multiply": 1,
    "plain_sums": 1,
    "restrict_to_free": 2,
    "advance_response": 1,
}
OF_COLUMNS = ("unpack_columns", "pack_columns")


def make_arrays(kernel, length, precision, seed):
    """Arguments as the solver has them: u <= h, many nodes and the padding on the wall, forces of both signs."""
    rng = np.random.default_rng(seed)
    padded = padded_length(length)
    h = np.zeros(padded, precision)
    h[:length] = rng.random(length)
    u = np.minimum(h, rng.standard_normal(padded)).astype(precision)
    u[length:] = 0
    arrays = []
    for name in ELEMENTWISE[kernel]:
        if name == "h":
            arrays.append(h)
        elif name == "u":
            arrays.append(u)
        elif name == "sum":
            arrays.append(np.full(padded // CHUNK, np.nan))
        elif name == "sums":
            arrays.append(np.full(layout.PARTS * padded // CHUNK, np.nan))
        elif name == "state":
            state = np.zeros(layout.STATE_LENGTH)
            state[[layout.MIX, layout.GAIN, layout.DT]] = 0.9, 0.7, 0.3
            arrays.append(state)
        elif name == "gap state":
            arrays.append(np.array([0.7]))
        else:
            values = rng.standard_normal(padded).astype(precision) * (rng.random(padded) < 0.7)
            values[length:] = 1 if name == "load" else 0
            if name == "v":
                values[u >= h] = layout.TOUCHING
            arrays.append(values.astype(precision))
    return arrays


def run(backend, kernel, arrays, outputs=None):
    copies = [array.copy() for array in arrays]
    outputs = outputs or NUM_OUTPUTS.get(kernel, 2)
    call = Call(kernel, tuple(copies[:-outputs]), tuple(copies[-outputs:]))
    record(backend, [call])()
    return copies


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("kernel", ELEMENTWISE)
def test_kernel_against_reference(kernel, length, precision):
    arrays = make_arrays(kernel, length, precision, seed=length)
    warp, reference = run("warp", kernel, arrays), run("numpy", kernel, arrays)
    eps = np.finfo(precision).eps
    for name, a, b, before in zip(ELEMENTWISE[kernel], warp, reference, arrays, strict=True):
        if name in ("sum", "sums"):
            # reassociated sums of CHUNK terms of size ~1: error <= CHUNK eps of the sum of magnitudes (<= 20 CHUNK)
            np.testing.assert_allclose(a, b, rtol=0, atol=20 * CHUNK * eps)
        else:
            # at most two roundings apart (fused multiply-add); terms are below 10
            np.testing.assert_allclose(a, b, rtol=4 * eps, atol=20 * eps)
        assert a.dtype == before.dtype


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("num_rows", [2, 15, 64])
@pytest.mark.parametrize("kernel", OF_COLUMNS)
def test_columns_against_reference(kernel, num_rows, precision):
    """What is not theirs, padding of the columns and spectra beyond the last, stays as it is."""
    rng, count = np.random.default_rng(num_rows), num_rows // 2 + 1
    turns = padded_length(2 * layout.COLUMNS * count), padded_length(2 * count)
    near, far = (rng.standard_normal(size).astype(precision) for size in turns)
    columns = rng.standard_normal(num_rows * layout.STRIDE).astype(precision)
    spectra = rng.standard_normal(near.size).astype(precision)
    arrays = [near, far, columns, spectra] if kernel == "unpack_columns" else [near, far, spectra, columns]
    *_, before = arrays
    *same, warp = run("warp", kernel, arrays, outputs=1)
    *_, reference = run("numpy", kernel, arrays, outputs=1)
    # products of three factors below 5, and a few roundings
    np.testing.assert_allclose(warp, reference, rtol=0, atol=100 * np.finfo(precision).eps)
    for array, given in zip(same, arrays, strict=False):
        np.testing.assert_array_equal(array, given)
    kept = warp == before
    if kernel == "unpack_columns":
        assert kept[2 * layout.COLUMNS * count :].all()
        assert not kept[: 2 * layout.COLUMNS * count].any()
    else:
        np.testing.assert_array_equal(kept.reshape(-1, layout.STRIDE)[0], np.arange(layout.STRIDE) >= layout.COLUMNS)
        assert kept.sum() == num_rows * (layout.STRIDE - layout.COLUMNS)


def test_chunks_shorter_than_a_row_of_columns_are_refused():
    with pytest.raises(ValueError, match="chunk is 64; allowed for unpack_columns: at least 128, a row of it"):
        recompile({"unpack_columns"}, 64, None)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_step_leaves_nothing_beyond_the_wall(precision):
    arrays = make_arrays("fire_step", 3 * CHUNK, precision, seed=1)
    _, h, _, u, v = run("warp", "fire_step", arrays)
    assert (u <= h).all()
    hit = u == h
    assert hit.any()
    assert not hit.all()
    assert (v[hit] == layout.TOUCHING).all()
    assert (v[~hit] != layout.TOUCHING).all()


@pytest.mark.parametrize("precision", PRECISIONS)
def test_force_is_zero_exactly_where_the_wall_carries(precision):
    arrays = make_arrays("net_force", 3 * CHUNK, precision, seed=2)
    load, elastic, v, force, sums = run("warp", "net_force", arrays)
    carried = (v == layout.TOUCHING) & (load - elastic > 0)
    assert carried.any()
    assert (force[carried] == 0).all()
    np.testing.assert_array_equal(force[~carried], (load - elastic)[~carried])
    assert sums.reshape(layout.PARTS, -1)[layout.HOLDING].sum() == carried.sum()


@pytest.mark.parametrize("length", LENGTHS)
def test_padding_is_held_and_still(length):
    arrays = make_arrays("net_force", length, "float64", seed=3)
    _, _, v, force, sums = run("warp", "net_force", arrays)
    totals = sums.reshape(layout.PARTS, -1).sum(axis=1)
    assert totals[layout.HOLDING] >= padded_length(length) - length
    assert (force[length:] == 0).all()
    assert totals[layout.FORCE] == pytest.approx((force[:length] ** 2).sum())
    assert (v[length:] == layout.TOUCHING).all()
    *_, u, v = run("warp", "fire_step", make_arrays("fire_step", length, "float64", seed=3))
    assert (u[length:] == 0).all()
    assert (v[length:] == layout.TOUCHING).all()


def control_state(**values):
    state = np.zeros(layout.STATE_LENGTH)
    defaults = {
        "DT_MAX": 1.0, "N_MIN": 2, "F_INC": 1.1, "F_DEC": 0.5, "ALPHA_START": 0.1, "F_ALPHA": 0.99, "STIFFEST": 2.0,
        "TOLERANCE": 1e-8, "NUM_POINTS": 4000, "DT": 0.4, "ALPHA": 0.05, "N_POSITIVE": 5, "ITERATION": 7,
    }  # fmt: skip
    for name, value in {**defaults, **values}.items():
        state[getattr(layout, name)] = value
    return state


@pytest.mark.parametrize(
    ("power", "force", "changes"),
    [
        (3.0, 2.0, {}),
        (3.0, 2.0, {"N_POSITIVE": 0}),
        (-3.0, 2.0, {}),
        (0.0, 2.0, {"ITERATION": 0}),
        (3.0, 0.0, {}),
        (3.0, np.nan, {}),
        (3.0, 1e300, {}),
        (3.0, 2.0, {"DT": 0.999}),
        (3.0, 2.0, {"STIFFEST": 1e4, "ALPHA": 0.9}),
    ],
)
def test_control_against_reference(power, force, changes):
    rng = np.random.default_rng(3)
    sums, of_accelerations = rng.random((layout.PARTS, 37)), rng.random(37)
    for part, total in ((layout.FORCE, force), (layout.HOLDING, 100.0), (layout.POWER, power)):
        sums[part] *= total / sums[part].sum()
    states = []
    for backend in ("warp", "numpy"):
        state = control_state(**changes)
        record(backend, [Call("fire_control", (sums.ravel(), of_accelerations), (state,))])()
        states.append(state)
    np.testing.assert_allclose(states[0], states[1], rtol=1e-12)
    if not 0 < force < 1e100:
        assert states[0][layout.STOPPED] == 1
        assert states[0][layout.GAIN] == 0
    elif power > 0:
        assert states[0][layout.MIX] > 0
    else:
        assert states[0][layout.MIX] == 0


def test_mixing_is_capped_by_the_stiffest_mode():
    sums = np.array([1.0, 0.0, 1.0, 1e12])  # |v|/|a| = 1e6
    state = control_state(STIFFEST=4.0, DT=0.5, N_POSITIVE=0)
    record("warp", [Call("fire_control", (sums, sums), (state,))])()
    assert state[layout.GAIN] - state[layout.DT] == pytest.approx(1 / (0.5 * 4.0))


def test_bad_arrays_and_backends_are_refused():
    good = np.zeros(CHUNK)
    with pytest.raises(ValueError, match="length is 5"):
        record("warp", [Call("spectral_multiply", (np.zeros(5),), (np.zeros(5),))])
    with pytest.raises(ValueError, match="contiguous"):
        record("warp", [Call("spectral_multiply", (np.zeros(2 * CHUNK)[::2],), (good,))])
    with pytest.raises(ValueError, match="backend is 'cuda'"):
        record("cuda", [Call("spectral_multiply", (good,), (good,))])


def test_a_recording_waits_while_another_thread_records_a_graph(monkeypatch):
    """Beside the recording its launches would crash."""
    doubling, mine, other = np.full(CHUNK, 2.0), np.ones(CHUNK), np.ones(CHUNK)

    def record_mine():
        record("warp", [Call("spectral_multiply", (doubling,), (mine,))])()

    launch, thread, waits = wp.launch, threading.Thread(target=record_mine), []

    def launch_beside(*given, **options):
        if not waits:
            thread.start()
            thread.join(0.1)
            waits.append(thread.is_alive())
        return launch(*given, **options)

    monkeypatch.setattr(wp, "launch", launch_beside)
    record("warp", [Call("spectral_multiply", (doubling,), (other,))] * 2)()
    thread.join()
    assert waits == [True]
    assert mine[0] == mine[-1] == 2.0
    assert other[0] == other[-1] == 4.0


@pytest.fixture(scope="module")
def compiled_afresh(tmp_path_factory):
    """What two processes say that load the kernels, the first with an empty cache; and the C++ that it compiled.

    With LLVM's remarks.
    """
    folder = tmp_path_factory.mktemp("cache")
    program = (
        "import warp as wp\n"
        "wp.config.cpu_compiler_flags = (wp.config.cpu_compiler_flags or '') + ' -Rpass=loop-vectorize'\n"
        "import linecontact.kernels as k\n"
        "k.load()\n"
    )
    environment = {**os.environ, "WARP_CACHE_PATH": str(folder)}
    said = []
    for _ in range(2):
        result = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=300
        )
        assert result.returncode == 0, result.stderr
        said.append(result.stderr)
    return said, {path.name: path.read_text().splitlines() for path in folder.rglob("*.cpp")}


def test_a_cold_compile_announces_itself(compiled_afresh):
    (cold, warm), _ = compiled_afresh
    assert "compiling kernels for this processor, once" in cold
    assert warm == ""


def test_every_element_wise_loop_is_vectorised(compiled_afresh):
    """LLVM's own remark for every kernel, each in both precisions."""
    (cold, _), sources = compiled_afresh
    found = {}
    for name, line, width in re.findall(
        r"([^/\s]+\.cpp):(\d+):\d+: remark: vectorized loop \(vectorization width: (\d+)", cold
    ):
        functions = [
            re.match(r"static void (\w+)_[0-9a-f]{8}_cpu_kernel_forward\(", text) for text in sources[name][: int(line)]
        ]
        names = [match for match in functions if match]
        if names:
            found.setdefault(names[-1].group(0), set()).add(int(width))
    exact = {
        name: [w for f, w in found.items() if re.match(rf"static void {name}_[0-9a-f]{{8}}_cpu", f)]
        for name in (*ELEMENTWISE, *OF_COLUMNS)
    }
    assert all(len(widths) == 2 for widths in exact.values()), exact  # float32 and float64
    assert all(max(w) >= 2 for widths in exact.values() for w in widths)
    assert {*ELEMENTWISE, *OF_COLUMNS, "fire_control"} == set(KERNELS)


INTERRUPTED_IMPORT = """
import os, signal, sys
from linecontact import kernels

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name.startswith("warp.") and len([known for known in sys.modules if known.startswith("warp.")]) > 5:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell has its background programs ignore it
sys.meta_path.insert(0, Interrupt())
try:
    kernels.start_warp()
except KeyboardInterrupt:
    print("interrupted")
kernels.start_warp()
print("started")
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_after_ctrl_c_during_its_import_warp_still_starts():
    """As where a solve goes on to the finest grid with what it has."""
    done = subprocess.run([sys.executable, "-c", INTERRUPTED_IMPORT], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["interrupted", "started"], done.stderr
