"""FIRE on a GPU against the CPU, where there is one; and without one all that needs none."""

import importlib
import math
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linecontact.kernels import compiled, layout, on_gpu, reference
from linecontact.kernels.sequences import SEQUENCES, parse
from linecontact.solver import Layer, PowerIndenter, Scene, Status, solve
from linecontact.solver import solve as solve_function
from linecontact.solver.strategy import finish
from linecontact.solver.transforms import device
from linecontact.solver.transforms.planned import plan_transforms
from linecontact.studies.command_line import main
from linecontact.studies.gpu.scenes import random_scene

FIRES = ("fire", "mass-weighted-fire")
SCENE = Scene(Layer(0.1, 0.25), PowerIndenter(), pressure=5e-3, num_points=2**12)


def missing_gpu():
    """Why there is no GPU to test with; empty where there is one."""
    try:
        device.check_device("cuda")
    except ValueError as error:
        return str(error)
    return ""


MISSING = missing_gpu()
needs_gpu = pytest.mark.skipif(bool(MISSING), reason=f"needs a GPU: {MISSING}")


# without a GPU


@pytest.fixture(scope="module")
def gpu_form():
    """The kernels in the form that a GPU has, compiled for the CPU."""
    names = [name for name in compiled.MODULES if name not in compiled.ON_CPU_ONLY]
    copies = [compiled.copy_module(m, on_gpu.CHUNK, compiled.flags(), on_gpu.LANES) for m in names]
    return compiled.compile_modules([*copies, importlib.import_module("linecontact.kernels.warp_folds")])


ONE_PASS = sorted(
    {text for lines in SEQUENCES.values() for text in lines if parse(text).kernel != "fire_control"}
    | {"spectral_multiply: coefficient -> spectrum"}
)


def make_arrays(line, precision):
    """Arguments of a kernel by their names, and those for its reference kernel, whose sums are over longer chunks."""
    rng, length = np.random.default_rng(0), 2 * on_gpu.SPAN
    arrays, references = {}, {}
    for name in (*line.inputs, *line.outputs):
        if name.endswith("sums"):
            count = length * (layout.PARTS if name == "sums" else 1)
            arrays[name], references[name] = np.full(count // on_gpu.CHUNK, np.nan), np.full(count // 1024, np.nan)
            continue
        values = rng.standard_normal(length).astype(precision)
        if name == "v":
            values[rng.random(length) < 0.3] = layout.TOUCHING
        if name == "state":
            values = np.zeros(layout.STATE_LENGTH)
            values[[layout.MIX, layout.GAIN, layout.DT]] = 0.9, 0.7, 0.3
        arrays[name], references[name] = values, values.copy()
    return arrays, references


def check_against_references(line, arrays, references, precision):
    getattr(reference, line.kernel)(*(references[name] for name in (*line.inputs, *line.outputs)))
    scale = np.finfo(precision).eps
    for name in line.outputs:
        if name.endswith("sums"):
            parts = layout.PARTS if name == "sums" else 1
            exact, found = (each[name].reshape(parts, -1).sum(axis=1) for each in (references, arrays))
            np.testing.assert_allclose(found, exact, rtol=0, atol=4 * scale * arrays[line.inputs[0]].size)
        else:
            np.testing.assert_allclose(arrays[name], references[name], rtol=0, atol=8 * scale)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("text", ONE_PASS)
def test_the_form_for_a_gpu_does_what_the_reference_kernels_do(text, precision, gpu_form):
    import warp as wp

    line = parse(text)
    arrays, references = make_arrays(line, precision)
    given = [
        [wp.array(arrays[name], copy=False, device="cpu") for name in names] for names in (line.inputs, line.outputs)
    ]
    length = next(a.size for name, a in arrays.items() if name != "state")
    threads = arrays[line.inputs[0]].size // on_gpu.CHUNK
    assert length == arrays[line.inputs[0]].size
    wp.launch(gpu_form[line.kernel], dim=threads, inputs=given[0], outputs=given[1], device="cpu")
    check_against_references(line, arrays, references, precision)


@pytest.mark.parametrize("count", [1, 31, 1000])
def test_sums_are_folded_whole(count, gpu_form):
    import warp as wp

    sums = np.random.default_rng(0).random((layout.PARTS + 1, count))
    folded = np.full(len(sums) * on_gpu.FOLDED, np.nan)
    given = sums[: layout.PARTS].ravel(), sums[layout.PARTS]
    inputs = [wp.array(array, copy=False, device="cpu") for array in given]
    outputs = [wp.array(folded, copy=False, device="cpu")]
    wp.launch(gpu_form["fold_sums"], dim=folded.size, inputs=inputs, outputs=outputs, device="cpu", block_dim=1)
    np.testing.assert_allclose(folded.reshape(len(sums), -1).sum(axis=1), sums.sum(axis=1), rtol=1e-14)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"device": "tpu"}, r"device is 'tpu'; allowed: cpu, cuda"),
        ({}, r"device is 'cuda'; allowed: cpu for method active-set, or one of the methods mass-weighted-fire, fire"),
        ({"accuracy": 1e-3}, "device is 'cuda'; allowed with an accuracy: cpu alone"),
        ({"method": "fire", "backend": "numpy"}, "backend is 'numpy'; allowed: warp, on device cuda"),
    ],
)
def test_what_a_gpu_cannot_do_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        solve(SCENE, **({"device": "cuda"} | given))


@pytest.mark.parametrize("words", ["solve --device cuda --method fire", "study gpu --folder new"])
def test_where_cupy_is_missing_one_line_says_how_to_get_it(words, monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "cupy", None)
    monkeypatch.setattr("warp.is_cuda_available", lambda: True)
    monkeypatch.chdir(tmp_path)
    assert main.main(words.split()) == 2
    assert not list(tmp_path.iterdir())
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "device is 'cuda', for which CuPy or a library of CUDA is missing" in said.err
    assert "pip install 'cupy-cuda13x[ctk]'" in said.err


def test_on_the_cpu_nothing_of_a_gpu_is_imported():
    code = (
        "import sys\n"
        "from linecontact import Scene, solve\n"
        "for method in ('fire', 'mass-weighted-fire', 'active-set'):\n"
        "    solve(Scene(num_points=2**10), method=method)\n"
        "names = ('cupy', 'linecontact.kernels.on_gpu', 'linecontact.solver.transforms.on_gpu')\n"
        "print([name for name in (*names, 'linecontact.solver.methods.fire_on_gpu') if name in sys.modules])\n"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_where_there_is_no_gpu_one_line_says_so(monkeypatch):
    runtime = SimpleNamespace(getDeviceCount=lambda: 0, CUDARuntimeError=RuntimeError)
    cuda = SimpleNamespace(runtime=runtime, cufft=SimpleNamespace())
    for name, module in {"cupy": SimpleNamespace(cuda=cuda), "cupy.cuda": cuda, "cupy.cuda.cufft": cuda.cufft}.items():
        monkeypatch.setitem(sys.modules, name, module)
    with pytest.raises(ValueError, match="device is 'cuda', but there is no GPU with a driver for it; allowed: cpu"):
        solve(SCENE, device="cuda", method="fire")


@pytest.fixture
def pretended(monkeypatch):
    """A GPU that is none: the CPU's arrays and transforms in place of it, iterations repeated as there."""
    repeated = []

    def capture(functions):
        def replay():
            repeated.append(1)
            for function in functions:
                function()

        return replay

    class OutOfMemoryError(Exception):
        pass

    fake = SimpleNamespace(
        Transforms=plan_transforms,
        capture=capture,
        free_memory=lambda: 2**40,
        OutOfMemory=OutOfMemoryError,
        repeated=repeated,
    )
    import linecontact.solver.transforms as package

    monkeypatch.setitem(sys.modules, "linecontact.solver.transforms.on_gpu", fake)
    monkeypatch.setattr(package, "on_gpu", fake, raising=False)
    monkeypatch.delitem(sys.modules, "linecontact.solver.methods.fire_on_gpu", raising=False)
    monkeypatch.setattr(sys.modules[solve_function.__module__], "check_device", lambda device: None)
    monkeypatch.setattr(finish, "device_name", lambda device: "pretended" if device == "cuda" else device)
    monkeypatch.setattr(finish, "gpu_libraries", lambda: "no libraries")
    yield fake
    sys.modules.pop("linecontact.solver.methods.fire_on_gpu", None)


@pytest.mark.parametrize("precision", ["float64", "mixed"])
@pytest.mark.parametrize("method", FIRES)
def test_repeated_iterations_find_what_single_ones_find(method, precision, pretended):
    scene = Scene(SCENE.layer, SCENE.indenter, SCENE.pressure, num_points=2**11, precision=precision)
    one, many = solve(scene, method=method), solve(scene, method=method, device="cuda")
    assert pretended.repeated
    assert one.status is many.status is Status.CONVERGED
    assert (one.contact == many.contact).all()
    assert abs(one.displacement - many.displacement).max() < 1e-6 * abs(one.displacement).max()
    assert many.device == "pretended"
    assert many.to_dict()["device"] == "pretended"
    assert "device" not in one.to_dict()
    assert [choice.chosen for choice in many.choices if choice.what == "device"] == ["pretended"]


@pytest.mark.parametrize("limit", [1, 2, 7, 40])
@pytest.mark.parametrize("method", FIRES)
def test_the_limit_of_iterations_holds_for_repeated_ones(method, limit, pretended):
    solution = solve(SCENE, method=method, device="cuda", max_iterations=limit)
    assert solution.status is Status.ITERATION_LIMIT
    assert solution.iterations == limit


def test_a_solve_on_the_gpu_starts_where_it_is_told_to(pretended):
    found = solve(SCENE, method="fire")
    again = solve(SCENE, method="fire", device="cuda", initial=found.displacement)
    assert again.iterations < found.iterations / 2
    assert (again.contact == found.contact).all()


def test_a_grid_too_large_for_the_gpu_is_refused(pretended):
    """Before it is tried; and where its memory ends nevertheless."""

    def fail(*_):
        raise pretended.OutOfMemory("out of memory allocating 8 bytes")

    pretended.Transforms = fail
    memory = r"too many for the GPU's memory \(out of memory"
    for free, said in ((2**40, memory), (2**18, "needing about .* GiB of the GPU's memory; allowed: what")):
        pretended.free_memory = lambda free=free: free
        with pytest.raises(ValueError, match=f"num_points is 4096, {said}"):
            solve(SCENE, method="fire", device="cuda")


# on a GPU


@needs_gpu
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("text", ONE_PASS)
def test_kernels_on_the_gpu_do_what_the_reference_kernels_do(text, precision):
    import cupy
    from linecontact.kernels import Call

    line = parse(text)
    arrays, references = make_arrays(line, precision)
    there = {name: cupy.asarray(array) for name, array in arrays.items()}
    launch = on_gpu.prepare(
        [Call(line.kernel, *(tuple(there[n] for n in names) for names in (line.inputs, line.outputs)))]
    )
    launch()
    arrays = {name: cupy.asnumpy(array) for name, array in there.items()}
    check_against_references(line, arrays, references, precision)


@needs_gpu
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("n", [16, 729, 1009, 2**12])
def test_transforms_on_the_gpu_against_numpy(n, precision):
    from linecontact.solver.transforms import on_gpu as transforms

    plan, rng = transforms.Transforms(n, precision), np.random.default_rng(0)
    values, symbol = rng.standard_normal(n), rng.standard_normal(n // 2 + 1)
    source, target = plan.buffer(), plan.buffer()
    plan.put(source, values)
    multiply = plan.multiplication(symbol)
    for part in (plan.forward(source), multiply, plan.inverse(target)):
        part()
    tolerance = 4 * np.finfo(precision).eps * math.log2(n)
    np.testing.assert_allclose(plan.fetch(target)[:n], np.fft.irfft(np.fft.rfft(values) * symbol, n), atol=tolerance)
    np.testing.assert_array_equal(plan.fetch(source)[:n], values.astype(precision))
    assert not plan.fetch(target)[n:].any()


@needs_gpu
@pytest.mark.parametrize("precision", ["float64", "float32", "mixed"])
@pytest.mark.parametrize("method", FIRES)
def test_a_solve_on_the_gpu_is_certified_like_one_on_the_cpu(method, precision):
    scene = replace(SCENE, precision=precision)
    here, there = solve(scene, method=method), solve(scene, method=method, device="cuda")
    assert here.status is there.status is Status.CONVERGED
    assert there.certificate.equilibrium_residual <= there.tolerance
    assert there.tolerance == pytest.approx(here.tolerance, rel=0.01)  # where rounding limits it, it is measured
    if precision != "float32":  # whose rounding moves a node at an edge
        assert (here.contact == there.contact).all()


@needs_gpu
@pytest.mark.parametrize("seed", range(20))
def test_the_gpu_finds_the_contact_nodes_of_the_cpu(seed):
    scene = random_scene(seed)
    here, there = (solve(scene, method="mass-weighted-fire", device=where) for where in ("cpu", "cuda"))
    assert here.status is there.status
    if here.status is Status.CONVERGED:
        assert (here.contact == there.contact).all()
        assert there.certificate.equilibrium_residual <= there.tolerance


@needs_gpu
@pytest.mark.parametrize(
    ("scene", "given"),
    [
        (SCENE, {"nested": True}),
        (Scene(SCENE.layer, SCENE.indenter, approach=1e-3, num_points=2**12), {}),
        (replace(SCENE, num_points=4), {}),
        (replace(SCENE, layer=Layer(1e-3, 0.5)), {}),
        (replace(SCENE, layer=Layer(0.03, 0.4999)), {}),
        (replace(SCENE, layer=Layer(0.03, 0.4999), precision="mixed"), {}),
    ],
)
@pytest.mark.parametrize("method", FIRES)
def test_every_way_through_a_solve_leads_over_the_gpu(method, scene, given):
    here, there = (solve(scene, method=method, device=where, **given) for where in ("cpu", "cuda"))
    assert here.status is there.status
    assert there.device == device.device_name("cuda")
    if here.status is Status.CONVERGED:
        assert (here.contact == there.contact).all()


@needs_gpu
@pytest.mark.parametrize("method", FIRES)
def test_a_solve_on_the_gpu_repeats_bit_for_bit(method):
    one, two = (solve(SCENE, method=method, device="cuda") for _ in range(2))
    np.testing.assert_array_equal(one.displacement, two.displacement)
    assert one.iterations == two.iterations


@needs_gpu
def test_the_gpu_is_shown(capsys):
    assert main.main(["info"]) == 0
    assert "cuFFT" in capsys.readouterr().out


@needs_gpu
def test_the_gpu_gets_its_memory_back():
    import cupy

    for precision in ("float64", "mixed"):
        scene = Scene(SCENE.layer, SCENE.indenter, SCENE.pressure, num_points=2**16, precision=precision)
        solve(scene, method="mass-weighted-fire", device="cuda")
        assert cupy.get_default_memory_pool().used_bytes() == 0
        assert cupy.get_default_memory_pool().total_bytes() == 0


@needs_gpu
@pytest.mark.parametrize("precision", ["float64", "float32", "mixed"])
@pytest.mark.parametrize("method", FIRES)
def test_the_memory_that_a_solve_takes_is_foreseen(method, precision, monkeypatch):
    import cupy
    from linecontact.solver.methods import fire, fire_on_gpu, fire_state, mass_weighted_fire
    from linecontact.solver.transforms import on_gpu as transforms

    pool, taken, n = cupy.get_default_memory_pool(), [], 2**20
    monkeypatch.setattr(transforms, "free_memory", lambda: taken.append(pool.total_bytes()) or 2**40)
    pool.free_all_blocks()
    scene = replace(SCENE, num_points=n, precision=precision)
    solve(scene, method=method, device="cuda", max_iterations=120, tolerance=0.49)
    kinds = {fire.KIND.name: fire_state.Fire, mass_weighted_fire.KIND.name: mass_weighted_fire.MassWeightedFire}
    needed = fire_on_gpu.needed_memory(kinds[method], n, precision)
    assert 0.6 < taken[1] / needed <= 1  # by the first state; another one may follow
