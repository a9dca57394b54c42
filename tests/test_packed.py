"""The packed operator against whole transforms, and the active set near the contact against that on all nodes."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from linecontact.solver import Layer, PowerIndenter, RoughIndenter, Scene, Status, solve
from linecontact.solver.grid.layer_on_grid import half_spectrum
from linecontact.solver.grid.patches import Patches
from linecontact.solver.grid.problem import Problem
from linecontact.solver.grid.split import Split
from linecontact.solver.methods import ExecutionConfig, active_set, relax
from linecontact.solver.methods.active_set import surface
from linecontact.solver.methods.active_set.fields import Nearby

LAYERS = [(math.inf, 0.25), (1, 0.45), (0.1, -0.9), (0.01, 0.25), (1e-3, 0.499), (1e-4, 0.5), (1e-5, 0.5), (1e-5, 0.25)]


def stiffness(num_points, thickness, nu):
    return half_spectrum(Layer(thickness, nu), num_points, 1.0)


def split_and_symbol(num_points, block, thickness=math.inf, nu=0.25):
    """The split of G, and G(q_k)."""
    modes = stiffness(num_points, thickness, nu)
    return Split(modes, num_points, block), np.append(0.0, 1 / modes[1:])


def islands(num_blocks, seed):
    """Block numbers: islands of one to four blocks at random places, one of them across the end of the period."""
    rng = np.random.default_rng(seed)
    starts, sizes = rng.integers(0, num_blocks, 12), rng.integers(1, 5, 12)
    blocks = [(start + np.arange(size)) % num_blocks for start, size in zip(starts, sizes, strict=True)]
    return np.unique(np.concatenate([*blocks, [num_blocks - 1, 0, 1]]))


@pytest.mark.parametrize(("thickness", "nu"), LAYERS)
@pytest.mark.parametrize(("num_points", "block"), [(2**14, 16), (48000, 15), (2**17, 32), (2**15, 8)])
def test_packed_against_whole_transforms(num_points, block, thickness, nu):
    """Errors are measured over what G does to that pressure, and are at most three times what the split says."""
    split, symbol = split_and_symbol(num_points, block, thickness, nu)
    blocks = islands(num_points // block, seed=num_points)
    packed = Nearby(split, blocks, *np.zeros((2, num_points))).apply
    rng = np.random.default_rng(1)
    pressure = rng.standard_normal((blocks.size, block))
    pressure -= pressure.mean()  # a constant in the image tells nothing, and a load makes one
    whole = np.zeros((num_points // block, block))
    whole[blocks] = pressure
    expected = np.fft.irfft(np.fft.rfft(whole.ravel()) * symbol, num_points).reshape(-1, block)[blocks]
    difference = packed(pressure) - expected
    assert np.abs(difference - difference.mean()).max() <= 3 * split.error * np.ptp(expected)
    assert split.error < 3e-3
    # symmetric to rounding
    other = rng.standard_normal(pressure.shape)
    forth, back = float(np.sum(other * packed(pressure))), float(np.sum(pressure * packed(other)))
    assert forth == pytest.approx(back, rel=0, abs=1e-12 * float(np.sum(np.abs(other * packed(pressure)))))


@pytest.mark.parametrize(("num_points", "run"), [(2**16, 30), (2**17, 100)])
def test_blocks_whose_transforms_are_as_long_as_those_of_one_point_for_each(num_points, run):
    """Both parts go through buffers of one length."""
    split, symbol = split_and_symbol(num_points, 32)
    some = (Nearby(split, np.arange(count), *np.zeros((2, num_points))) for count in range(1, run + 40))
    near = next(one for one in some if one._length == split.num_blocks)
    count = near.nodes.size // 32
    pressure = np.random.default_rng(1).standard_normal((count, 32))
    whole = np.append(pressure - pressure.mean(), np.zeros(num_points - 32 * count))
    expected = np.fft.irfft(np.fft.rfft(whole) * symbol, num_points)[: 32 * count]
    difference = near.apply(pressure - pressure.mean()).ravel() - expected
    assert np.abs(difference - difference.mean()).max() <= 3 * split.error * np.ptp(expected)


@pytest.mark.parametrize(("thickness", "nu"), LAYERS)
@pytest.mark.parametrize(("num_points", "block"), [(2**14, 16), (48000, 15), (2**17, 32)])
def test_response_in_real_space(num_points, block, thickness, nu):
    """G by its two parts, which neglect what the split says at most, and the second sum of that."""
    split, symbol = split_and_symbol(num_points, block, thickness, nu)
    exact, half = np.fft.irfft(symbol, num_points), num_points // 2 + 1
    found = split.response(half)
    assert np.abs(found - exact[:half]).max() <= split.error * split.largest
    np.testing.assert_array_equal(split.response(500), found[:500])
    second = split.second_sum()
    again = np.roll(second, 1) - 2 * second + np.roll(second, -1)
    whole = np.append(found, found[-2:0:-1])
    whole -= whole.mean()
    assert np.abs(again - whole).max() <= 1e-4 * np.ptp(whole) + 1e-15 * np.abs(second).max()


@pytest.mark.parametrize(("num_points", "block"), [(2**14, 32), (48000, 15)])
def test_shares_of_the_blocks_add_up_to_rounding(num_points, block):
    """On stiff coatings the smooth part is 1e5 times the response of the coating, and so would be what is missing."""
    split, _ = split_and_symbol(num_points, block)
    np.testing.assert_allclose(split.weights.sum(axis=1), 1, rtol=0, atol=4e-16)


@pytest.mark.parametrize("thickness", [math.inf, 0.1])
def test_smooth_displacements_stay_smooth(thickness):
    """The packed operator's error under a load, as force on the nodes over the largest pressure, here 1."""
    num_points, block = 2**16, 16
    split, symbol = split_and_symbol(num_points, block, thickness)
    blocks = np.arange(1000, 1100)
    packed = Nearby(split, blocks, *np.zeros((2, num_points))).apply
    x = np.linspace(-1, 1, 100 * block)
    pressure = (1 - x**2).reshape(-1, block)  # it ends at 0, so all its waves are long
    whole = np.zeros((num_points // block, block))
    whole[blocks] = pressure
    exact = np.fft.irfft(np.fft.rfft(whole.ravel()) * symbol, num_points).reshape(-1, block)[blocks]
    error = (packed(pressure) - exact).ravel()
    force = np.diff(error, 2) / symbol[1:].min() / 4  # of the shortest wave the second difference is -4 times the wave
    assert np.abs(force).max() < 1e-6


def rough(num_points, hurst=0.8, thickness=math.inf, nu=0.25, pressure=1e-2, seed=0):
    waves = {"roll_off_ratio": 1 / 8, "cut_off_ratio": 64 * 8 / num_points}
    indenter = RoughIndenter(hurst=hurst, seed=seed, **waves)
    return Scene(Layer(thickness, nu, 1.0), indenter, pressure=pressure, num_points=num_points)


SCENES = [
    rough(2**16),
    rough(2**16, hurst=0.3),
    rough(2**16, thickness=0.01, nu=0.45),
    rough(2**16, thickness=1e-3, nu=0.499),
    rough(2**16, thickness=1e-3, nu=0.5),
    rough(2**16, thickness=1e-4),
    rough(2**16, pressure=0.3),
    Scene(Layer(), PowerIndenter(2.0, 1.0), pressure=2e-3, num_points=2**16),
    Scene(Layer(0.01, 0.5), PowerIndenter(4.0, 1.0), pressure=1e-4, num_points=72000),
    Scene(Layer(0.1), PowerIndenter(1.5, 1.0), pressure=1e-3, num_points=2 * 32771),  # no block divides it
]


@pytest.mark.parametrize(
    ("scene", "nested"), [*((scene, True) for scene in SCENES), (SCENES[2], False), (SCENES[8], False)]
)
def test_same_contact_as_on_all_nodes(scene, nested, monkeypatch):
    near = solve(scene, nested=nested)
    response = surface.Surface
    monkeypatch.setattr(active_set.active_set, "Surface", lambda problem, split, *rest: response(problem, None, *rest))
    everywhere = solve(scene, nested=nested)
    assert near.status is everywhere.status is Status.CONVERGED
    np.testing.assert_array_equal(near.contact, everywhere.contact)
    scale = everywhere.contact_pressure.max()
    np.testing.assert_allclose(near.contact_pressure, everywhere.contact_pressure, rtol=0, atol=1e-6 * scale)
    if scene in SCENES[:4]:  # with little in contact, in more than a few iterations
        assert near.transform_pairs < 0.7 * everywhere.transform_pairs


@pytest.mark.parametrize("start", ["without a patch", "with part of a patch alone"])
def test_patches_beyond_the_neighbourhood_are_found(start):
    """By whole transforms; a coarser grid may lack them."""
    scene = SCENES[0]
    solution = solve(scene)
    patches, pressure = Patches.of(solution.contact), solution.contact_pressure / scene.pressure
    if start == "without a patch":
        apart = patches.gap.min(axis=0)
        lost = int(np.argmax(np.where(patches.size < 40, apart, 0)))
        assert apart[lost] > 2 * 32  # nodes of a block
        pressure[patches.nodes[patches.label == lost]] = 0.0
    else:
        pressure[patches.nodes[40:]] = 0.0
    state = active_set.begin(Problem.from_scene(scene), ExecutionConfig(1e-9))
    state.start_from_pressure(pressure)
    assert relax(state, 2000) is Status.CONVERGED
    np.testing.assert_array_equal(state.contact_pressure > 0, solution.contact)


@pytest.mark.parametrize(("error", "left"), [(1e-3, False), (0.03, False), (0.5, True), (-2.0, True)])
def test_an_operator_worse_than_it_says(error, left, monkeypatch):
    """Found out by whole transforms; where they become many, or there is no way down, all nodes are worked on."""
    plain, made = Nearby.apply, []
    begin = surface.Surface.__init__

    def keep(self, *arguments):
        made.append(self)
        begin(self, *arguments)

    def wrong(self, values):
        return (1 + error * np.cos(self._blocks))[:, None] * plain(self, values)

    monkeypatch.setattr(Nearby, "apply", wrong)
    monkeypatch.setattr(surface.Surface, "__init__", keep)
    solution = solve(SCENES[0])
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert (made[-1].split is None) is left
    monkeypatch.setattr(Nearby, "apply", plain)
    np.testing.assert_array_equal(solution.contact, solve(SCENES[0]).contact)


THIN = [(2**16, 1e-5, 8.0, 0.1), (2**18, 1e-6, 4.0, 10.0), (2**18, 1e-6, 8.0, 0.1), (2**16, 1e-5, 4.0, 10.0)]


@pytest.mark.parametrize(("num_points", "thickness", "exponent", "pressure"), THIN)
def test_thin_incompressible_layers(num_points, thickness, exponent, pressure):
    """What the split neglects is more than the smallest G(q) there."""
    scene = Scene(Layer(thickness, 0.5), PowerIndenter(exponent), pressure, num_points=num_points)
    solution = solve(scene)
    assert solution.status is Status.CONVERGED
    assert not solution.handed_over
    assert solution.transform_pairs < 30


@pytest.mark.parametrize("scene", [Scene(num_points=2**12), SCENES[0]])
def test_interrupted_at_any_line(scene):
    """Ctrl-C anywhere inside a step leaves a solution that says so."""
    room = Path(active_set.__file__ or "").parent
    left = 0

    def trace(frame, event, argument):
        nonlocal left
        if Path(frame.f_code.co_filename).parent != room:
            return None
        if event == "line":
            left -= 1
            if left == 0:
                raise KeyboardInterrupt
        return trace

    step = active_set.ActiveSet.step

    def traced(self):
        sys.settrace(trace)
        try:
            step(self)
        finally:
            sys.settrace(None)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(active_set.ActiveSet, "step", traced)
        for lines in [*range(1, 400, 13), *range(400, 3000, 131)]:
            left = lines
            solution = solve(scene, nested=False)
            assert solution.status in (Status.INTERRUPTED, Status.CONVERGED)
            assert np.isfinite(solution.displacement).all()
