"""Random roughness and measured heights: statistics, grids, bad input."""

import dataclasses
import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve

ROUGH = RoughIndenter(0.8, 7, 1 / 8, 1 / 32)  # k_s = 256


def test_same_seed_same_surface_on_every_grid():
    fine = ROUGH.profile(4096, 1.0)
    for points in (520, 1024, 2048):  # all resolve k_s
        coarse = ROUGH.profile(points, 1.0)
        x = np.arange(points) / points
        # band-limited: the fine grid's Fourier series at the coarse grid's points
        modes = np.fft.rfft(fine)[:257] / 4096
        series = modes[0].real + 2 * (np.exp(2j * np.pi * np.outer(x, np.arange(1, 257))) @ modes[1:]).real
        np.testing.assert_allclose(coarse - coarse.mean(), series - series.mean(), atol=1e-12)
        assert coarse.min() == 0
    assert not np.allclose(fine, dataclasses.replace(ROUGH, seed=8).profile(4096, 1.0))
    longer = dataclasses.replace(ROUGH, cut_off_ratio=1 / 64)  # more waves, the long ones in place
    phases = [np.angle(np.fft.rfft(r.profile(4096, 1.0))[1:257]) for r in (ROUGH, longer)]
    np.testing.assert_allclose(np.exp(1j * phases[0]), np.exp(1j * phases[1]), atol=1e-6)


def test_coarse_grids_hold_the_lower_modes():
    coarse, fine = ROUGH.profile(128, 1.0), ROUGH.profile(1024, 1.0)
    modes = np.fft.rfft(fine)[:64] / 1024
    np.testing.assert_allclose(np.fft.rfft(coarse)[1:64] / 128, modes[1:], atol=1e-14)


@pytest.mark.parametrize("gradient", [1.0, 0.03])
def test_rms_gradient_is_exact(gradient):
    rough = dataclasses.replace(ROUGH, rms_gradient=gradient)
    slope = rough.slope(2048, 1.0)
    assert math.sqrt(np.mean(slope**2)) == pytest.approx(gradient, rel=1e-12)
    modes = 2 * np.pi * np.arange(1025) * 1j * np.fft.rfft(rough.profile(2048, 1.0))
    np.testing.assert_allclose(np.fft.irfft(modes, 2048), slope, atol=1e-9 * gradient)
    assert abs(slope.mean()) < 1e-12


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_spectrum(hurst):
    power = np.abs(np.fft.rfft(dataclasses.replace(ROUGH, hurst=hurst).profile(2048, 1.0))) ** 2
    k = np.array([1, 8, 64, 256])
    expected = (1 + (k / 8) ** 2) ** -(0.5 + hurst)
    np.testing.assert_allclose(power[k] / power[1], expected / expected[0], rtol=1e-9)
    assert (power[257:] < 1e-20 * power[1]).all()


def test_the_defaults_are_the_published_surface():
    default = RoughIndenter()
    assert (default.roll_off_ratio, default.cut_off_ratio, default.rms_gradient) == (1 / 8, 1 / 512, 1.0)
    assert default.shortest_wave(2**18) == 4096  # dx/lambda_s = 1/64 at 2^18 points
    Scene(indenter=default)


def test_unresolved_waves_name_the_three_ratios():
    with pytest.raises(ValueError, match=r"num_points is 4096.*lambda_r/L is.*lambda_s/lambda_r is.*dx/lambda_s is 1;"):
        Scene(indenter=RoughIndenter(), num_points=4096)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: RoughIndenter(hurst=0.0), "hurst is 0.0"),
        (lambda: RoughIndenter(hurst=1.5), "hurst is 1.5"),
        (lambda: RoughIndenter(seed=-1), "seed is -1"),
        (lambda: RoughIndenter(seed=0.5), "seed is 0.5"),
        (lambda: RoughIndenter(roll_off_ratio=2.0), "roll_off_ratio is 2.0"),
        (lambda: RoughIndenter(cut_off_ratio=0.0), "cut_off_ratio is 0.0"),
        (lambda: RoughIndenter(rms_gradient=math.inf), "rms_gradient is inf"),
        (lambda: MeasuredIndenter(np.zeros(64), convention="gap"), "constant"),
        (lambda: MeasuredIndenter(np.arange(3.0), convention="gap"), r"shape \(3,\)"),
        (lambda: MeasuredIndenter(np.ones((16, 2)), convention="gap"), "shape"),
        (lambda: MeasuredIndenter(np.append(np.arange(30.0), np.nan), convention="gap"), r"heights\[30\] is nan"),
        (lambda: MeasuredIndenter(["high"] * 32, convention="gap"), "allowed: at least 4 finite real numbers"),
        (lambda: MeasuredIndenter(["1", "2", "3", "4"], convention="gap"), "allowed: at least 4 finite real numbers"),
        (lambda: MeasuredIndenter(1j * np.arange(16), convention="gap"), "allowed: at least 4 finite real numbers"),
        (lambda: MeasuredIndenter(np.arange(4) > 1, convention="gap"), "allowed: at least 4 finite real numbers"),
        (
            lambda: MeasuredIndenter(np.array(["1", "2", "3", "4"], dtype=object), convention="gap"),
            "allowed: at least 4 finite real numbers",
        ),
        (
            lambda: MeasuredIndenter(np.array([1, 2, 3, 4j], dtype=object), convention="gap"),
            "allowed: at least 4 finite real numbers",
        ),
        (lambda: MeasuredIndenter([10**400, 1, 2, 3], convention="gap"), "allowed: at least 4 finite real numbers"),
        (lambda: MeasuredIndenter(np.ma.masked_equal(np.arange(16.0), 3), convention="gap"), "heights is masked"),
        (lambda: MeasuredIndenter(np.arange(8.0), description=3, convention="gap"), "description is 3; allowed"),
        (
            lambda: Scene(indenter=MeasuredIndenter(np.arange(64.0), convention="gap"), num_points=128),
            "num_points is 128; allowed: 64",
        ),
    ],
)
def test_bad_input_is_named(make, named):
    with pytest.raises(ValueError, match=named):
        make()


def test_heights_may_be_any_real_numbers():
    expected = MeasuredIndenter([0.0, 1.0, 0.5, 2.0], convention="gap").heights
    for kind in (Fraction, Decimal, np.float32):
        np.testing.assert_array_equal(
            MeasuredIndenter([kind(h) for h in ("0", "1", "0.5", "2")], convention="gap").heights, expected
        )


def test_measured_heights_are_taken_as_they_are():
    heights = np.random.default_rng(0).standard_normal(256).cumsum() + 5
    indenter = MeasuredIndenter(heights, convention="gap")
    np.testing.assert_allclose(indenter.profile(256, 2.0), (heights - heights.min()) / 2)
    heights[:] = 0  # a copy was taken
    assert indenter.heights.max() > 0
    with pytest.raises(ValueError, match="read-only"):
        indenter.heights[0] = 1


def test_a_power_profile_given_as_heights_gives_the_same_answer():
    scene = Scene(Layer(0.1), num_points=1024)
    measured = Scene(Layer(0.1), MeasuredIndenter(scene.profile, convention="gap"), num_points=1024)
    one, other = solve(scene), solve(measured)
    np.testing.assert_array_equal(one.contact, other.contact)
    np.testing.assert_allclose(one.contact_pressure, other.contact_pressure, atol=1e-6 * scene.pressure)
    # slopes of heights are differences, and summed; those of the profile are integrated
    assert other.observables.kappa_subgrid == pytest.approx(one.observables.kappa_subgrid, rel=1e-6)
    assert other.observables.kappa_ratio is None
    assert "kappa_ratio" not in other.to_dict()


def test_heights_of_a_rough_surface_have_its_slopes():
    """With eight points to the shortest wave, where simple differences are a tenth too small."""
    rough = RoughIndenter(0.3, 0, 1 / 8, 1 / 8)
    exact = rough.slope(512, 1.0)
    found = MeasuredIndenter(rough.profile(512, 1.0), convention="gap").slope(512, 1.0)
    assert np.std(found) == pytest.approx(np.std(exact), rel=2e-3)
    np.testing.assert_allclose(found, exact, atol=0.01)


def test_power_slope_is_the_derivative():
    indenter = PowerIndenter(2.5, 0.7)
    h, slope = indenter.profile(4096, 1.0), indenter.slope(4096, 1.0)
    inside = slice(1, -1)
    np.testing.assert_allclose((h[2:] - h[:-2]) * 2048, slope[inside], atol=1e-4)
