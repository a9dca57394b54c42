"""FIRE against collocation, convergence order, certificates, bad input, extremes."""

import itertools
import math
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.solver import (
    METHODS,
    Layer,
    PowerIndenter,
    RoughIndenter,
    Scene,
    Status,
    certify,
    solve,
)
from linecontact.solver.grid.layer_on_grid import half_spectrum
from linecontact.solver.grid.problem import Problem
from linecontact.solver.reference import closed_forms, collocation


def hertz(thickness=math.inf, poisson_ratio=0.25, num_points=2**10, **changes):
    return Scene(Layer(thickness, poisson_ratio), num_points=num_points, **changes)


def independent_residuals(solution):
    """Equilibrium residual, wall force and gap from the stored fields alone, by a dense-free direct sum over modes."""
    scene = solution.scene
    n, layer = scene.num_points, scene.layer
    k = half_spectrum(layer, n, scene.period) * layer.contact_modulus / scene.period
    modes = np.fft.fft(solution.displacement)
    symbol = k[np.minimum(np.arange(n), n - np.arange(n))]
    net = scene.pressure - np.fft.ifft(symbol * modes).real
    return net, scene.profile - solution.displacement


SCENES = [
    (math.inf, 0.25, 2.0),
    (0.1, 0.25, 2.0),
    (0.01, 0.25, 2.0),
    (0.02, 0.5, 2.0),
    (0.005, -0.9, 2.0),
    (0.01, 0.49, 4.0),
    (0.05, 0.0, 4.0),
    (1e-3, 0.5, 1.5),
    (1e-3, 0.5, 4.0),
]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("d", "nu", "n"), SCENES)
def test_against_collocation(method, d, nu, n):
    points = 2**11 if method == "fire" else 2**12
    scene = Scene(Layer(d, nu), PowerIndenter(n), pressure=1e-3, num_points=points)
    exact = collocation.solve_layer(Layer(d, nu), 1e-3, n, 1.0)
    found = solve(scene, method=method)
    assert found.status is Status.CONVERGED
    # counting misses each of the two edges by less than one node
    assert abs(found.observables.contact_area - exact.contact_area) < 2 / points
    # second order in dx/a (test_order_of_convergence); the constants measured there are below 0.1, for n = 4 below 1
    bound = (0.2 if n == 2 else 2.0) * (1 / points / exact.half_width) ** 2 + 1e-7
    assert found.observables.peak_pressure == pytest.approx(exact.peak_pressure, rel=bound)
    assert found.observables.approach == pytest.approx(exact.approach, rel=bound)


@pytest.mark.parametrize(("d", "nu"), [(math.inf, 0.25), (0.02, 0.25), (0.02, 0.5)])
def test_order_of_convergence(d, nu):
    """rms over loads (the edge's place between nodes averages out): second order in dx/a, measured."""
    loads = np.geomspace(1.6e-3, 2.4e-3, 8)
    exact = [collocation.solve_layer(Layer(d, nu), p, 2.0, 1.0) for p in loads]
    errors = []
    for points in (2**8, 2**12):
        found = [solve(hertz(d, nu, points, pressure=p), tolerance=1e-9) for p in loads]
        relative = [f.observables.approach / e.approach - 1 for f, e in zip(found, exact, strict=True)]
        errors.append(math.sqrt(np.mean(np.square(relative))))
    order = math.log2(errors[0] / errors[1]) / 4
    assert 1.75 < order < 2.35
    assert errors[0] < 0.1 / (2**8 * exact[0].half_width) ** 2


@pytest.mark.parametrize("method", METHODS)
def test_backends_agree(method):
    scene = hertz(0.03, 0.4, 2**9)
    warp, reference = (solve(scene, method=method, backend=backend) for backend in ("warp", "numpy"))
    np.testing.assert_array_equal(warp.contact, reference.contact)
    # both meet 1e-8; the softest mode, K_1 = 3 E*/L at least, turns that into displacement
    np.testing.assert_allclose(warp.displacement, reference.displacement, atol=1e-8 * scene.pressure)


def test_warm_start_saves_work():
    cold = solve(hertz(0.1, 0.25), method="mass-weighted-fire")
    warm = solve(hertz(0.1, 0.25), method="mass-weighted-fire", initial=cold.displacement)
    assert warm.iterations <= 2
    assert solve(hertz(0.09, 0.25), method="mass-weighted-fire", initial=cold.displacement).status is Status.CONVERGED


def test_iteration_limit_keeps_the_partial_result():
    solution = solve(hertz(0.1, 0.25), method="mass-weighted-fire", max_iterations=7)
    assert solution.status is Status.ITERATION_LIMIT
    assert solution.iterations == 7
    assert solution.certificate.equilibrium_residual > 1e-8
    assert (solution.displacement <= solution.scene.profile).all()
    thin = solve(Scene(Layer(1e-3, 0.5), num_points=2**10), method="mass-weighted-fire", max_iterations=5)
    assert thin.status is Status.ITERATION_LIMIT
    assert thin.iterations == 5


def test_interrupted_in_the_first_iteration(monkeypatch):
    def interrupt(iteration, residual):
        raise KeyboardInterrupt

    monkeypatch.setattr(time, "monotonic", itertools.count().__next__)  # a report in every iteration
    solution = solve(Scene(Layer(1e-3, 0.5), num_points=2**10), method="mass-weighted-fire", progress=interrupt)
    assert solution.status is Status.INTERRUPTED
    assert solution.iterations == 1


def test_certificate_sees_a_spoilt_solution():
    scene = hertz(0.1, 0.25, 2**9)
    problem = Problem.from_scene(scene)
    u = solve(scene, tolerance=1e-12).displacement / problem.length_unit
    good, pressure, contact = certify(problem, u)
    assert good.equilibrium_residual < 2e-12
    with np.errstate(invalid="ignore"):
        assert math.isnan(certify(problem, np.full_like(u, np.nan))[0].largest_residual)
    rng = np.random.default_rng(0)
    for kind in (0, 0, 1, 1, 1):
        moved = rng.random(u.size) < (0.3 if kind else 1.0)  # all free nodes, or some of any kind, off the wall too
        noise = 1e-3 * rng.standard_normal(u.size)
        spoilt = np.minimum(problem.height, u + noise * (moved if kind else ~contact))
        bad, _, _ = certify(problem, spoilt)
        # the bound against the true energy error: Pi = V - mean displacement, minimum at u

        def energy(v):
            elastic = np.fft.irfft(problem.stiffness * np.fft.rfft(v), v.size)
            return float(v @ elastic) / 2 - float(v.sum())

        elastic_energy = energy(spoilt) + float(spoilt.sum())
        true = energy(spoilt) - energy(u)
        assert 0 < true <= bad.energy_error_bound * elastic_energy
        assert bad.equilibrium_residual > 1e-4
        force = problem.net_force(spoilt)
        assert bad.largest_residual == pytest.approx(np.abs(force[(spoilt < problem.height) | (force <= 0)]).max())
    deep, _, _ = certify(problem, u + 0.1)
    assert deep.penetration > 0
    assert certify(problem, u - 1.0)[0].energy_error_bound == math.inf
    assert pressure.mean() == pytest.approx(1, abs=1e-11)


@settings(max_examples=40, deadline=None)
@given(
    st.one_of(st.just(math.inf), st.floats(-3, 1).map(lambda x: 10.0**x)),
    st.one_of(st.just(0.5), st.floats(-0.95, 0.5)),
    st.floats(1.3, 6.0),
    st.floats(-5, -0.5).map(lambda x: 10.0**x),
    st.integers(8, 1100).map(lambda k: 2 * k),
)
def test_every_scene_is_certified_or_says_no(d, nu, n, p, points):
    scene = Scene(Layer(d, nu), PowerIndenter(n), pressure=p, num_points=points)
    solution = solve(scene, max_iterations=3000)
    net, gap = independent_residuals(solution)
    height = scene.profile.max()
    assert (gap >= -1e-15 * height).all()
    assert (solution.contact_pressure >= 0).all()
    free = ~solution.contact
    residual = math.sqrt(np.sum(net[free] ** 2) / max(1, free.sum())) / p
    # two transforms' rounding of K u apart
    assert residual == pytest.approx(solution.certificate.equilibrium_residual, rel=1e-3, abs=1e-9)
    if solution.status is Status.CONVERGED:
        assert residual <= 1.001e-8
        assert solution.contact_pressure.mean() == pytest.approx(p, rel=1e-6)
        assert solution.certificate.energy_error_bound < 1e-9
    else:  # only where the layer is nearly rigid may it say no
        assert nu > 0.49
        assert d < 0.01


@settings(max_examples=15, deadline=None)
@given(
    st.integers(-20, 20),
    st.integers(-20, 20),
    st.sampled_from([math.inf, 0.05]),
    st.sampled_from(["float64", "float32"]),
)
def test_scaling_is_exact(length, pressure, d, precision):
    """Powers of two scale every float exactly, so the answer must scale to the last bit."""
    x, y = 2.0**length, 2.0**pressure
    one = solve(hertz(d, 0.25, 256, precision=precision))
    other = solve(
        Scene(Layer(d * x, 0.25, y), PowerIndenter(2.0, x), 2e-3 * y, period=x, num_points=256, precision=precision)
    )
    np.testing.assert_array_equal(other.displacement, x * one.displacement)
    np.testing.assert_array_equal(other.contact_pressure, y * one.contact_pressure)
    assert other.observables.kappa == one.observables.kappa
    assert other.certificate == one.certificate


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Layer(0.0), "thickness is 0.0"),
        (lambda: Scene(pressure="2"), "pressure is '2'; allowed: a finite pressure >= 0"),
        (lambda: Scene(num_points=True), "num_points is True"),
        (lambda: Layer(1.0, 0.51), "poisson_ratio is 0.51"),
        (lambda: PowerIndenter(1.0), "exponent is 1.0"),
        (lambda: Scene(pressure=-1.0), "pressure is -1.0"),
        (lambda: Scene(precision="half"), "precision is 'half'"),
        (lambda: Scene(indenter=PowerIndenter), "indenter is <class"),
        (lambda: Scene(precision=np.array(["float64", "mixed"])), "precision is array"),
        (lambda: solve(hertz(), nested="x"), "nested is 'x'"),
        (lambda: solve(hertz(), nested=True, initial=np.zeros(2**10)), "nested is True; allowed: False or None with"),
        (lambda: solve(hertz(), progress=5), "progress is 5"),
        (lambda: solve(hertz(), max_iterations=10**18), "allowed: an integer from 1 to 2\\^53"),
        (lambda: Scene(pressure=5e-324), "pressure/contact_modulus"),
        (lambda: Scene(indenter=PowerIndenter(2.0, 1e-61)), "radius/period is 1e-61; allowed: from 1e-60 to 1e\\+60"),
        (lambda: Scene(indenter=RoughIndenter(rms_gradient=1e-61)), "rms_gradient"),
        (lambda: solve(hertz(), method="cg"), "method is 'cg'.*active-set, mass-weighted-fire, fire"),
        (lambda: solve(hertz(), tolerance=1.0), "tolerance is 1.0"),
        (lambda: solve(hertz(num_points=2**21, precision="float32")), "num_points is 2097152"),
        (lambda: collocation.solve_layer(Layer(), 10.0, 2.0, 1.0), "load is 10"),  # beyond its reach
        (lambda: collocation.solve_layer(Layer(1e-7, 0.25), 0.03, 2.0, 1e5), "thickness is 1e-07"),  # or the memory
        (lambda: collocation.solve_layer(Layer(1.0, 0.3), 1e-3, 2.0, 1.0, 7), "num_nodes is 7"),
        (lambda: solve(hertz(), planning="hasty"), "planning"),
        (lambda: solve(hertz(), initial=np.full(2**10, 1j)), r"initial is array\(\[0\.\+1\.j"),
        (lambda: solve(hertz(), initial=[[1.0, 2.0], [3.0]]), r"initial is \[\[1\.0, 2\.0\], \[3\.0\]\]; allowed"),
    ],
)
def test_bad_input_is_named(make, named):
    with pytest.raises(ValueError, match=named):
        make()


def test_scalars_of_numpy_are_numbers():
    for kind in (np.float32, np.longdouble, np.uint8):
        scene = Scene(Layer(kind(2)), pressure=kind(1), num_points=kind(64))
        assert (scene.layer.thickness, scene.pressure, scene.num_points) == (2.0, 1.0, 64)
        assert (type(scene.layer.thickness), type(scene.num_points)) == (float, int)
    assert Layer("inf").thickness == math.inf  # as `Scene.to_dict` has it
    for wrong in (np.True_, np.str_("2"), "infinity", np.complex128(2)):
        with pytest.raises(ValueError, match="thickness is"):
            Layer(wrong)


def test_too_large_for_the_machine(monkeypatch):
    if not Path("/proc/meminfo").exists():
        pytest.skip("free memory is known on Linux only")
    free = METHODS["active-set"].bytes_per_point(0.05) * 4096
    monkeypatch.setattr(sys.modules["linecontact.solver.checks"], "available_memory", lambda: free)
    solve(hertz(num_points=4096, pressure=1e-5))
    with pytest.raises(ValueError, match=r"num_points is 4096, needing about .* GiB"):  # known from a coarser grid
        solve(hertz(num_points=4096, pressure=0.1))
    with pytest.raises(ValueError, match=r"num_points is 4096, needing about .* GiB"):
        solve(hertz(num_points=4096), method="fire")


@pytest.mark.slow
@pytest.mark.parametrize(("d", "nu"), [(math.inf, 0.25), (0.1, 0.25), (0.01, 0.25), (1e-3, 0.49), (1e-3, 0.5)])
def test_real_size(d, nu):
    exact = collocation.solve_layer(Layer(d, nu), 2e-3, 2.0, 1.0)
    found = solve(hertz(d, nu, 2**18)).observables
    assert abs(found.contact_area - exact.contact_area) < 1.5 / 2**18
    assert found.peak_pressure == pytest.approx(exact.peak_pressure, rel=1e-5)
    if math.isinf(d):
        assert exact.contact_area == pytest.approx(closed_forms.periodic_half_space_area(2.0, 1.0, 2e-3), abs=1e-12)
