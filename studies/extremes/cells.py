"""Cells of the map: one random scene each, drawn from everything that the package accepts, and beyond common sense.

A cell is drawn from a seed, its number and its place: layer thicknesses from 1e-12 to 1e12 periods and the half-space,
by column; pressures from 1e-15 E* to ten times that of full contact, by row. Everything else is drawn at random.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from linecontact.solver import METHODS, Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene
from linecontact.solver.grid.layer_on_grid import half_spectrum
from linecontact.solver.methods import DEFAULT
from linecontact.solver.scene import PRECISIONS
from linecontact.solver.transforms.plain import irfft, rfft
from numpy.typing import NDArray

Array64 = NDArray[np.float64]
Generator = np.random.Generator

COLUMNS, ROWS = 25, 12
"""Of thickness, one decade each and the half-space last; of pressure, from the lowest to the highest."""

LEAST_LOAD = 1e-15
"""Lowest p/E* (dimensionless)."""

SIZES = {"small": (4, 2**13), "middle": (2**13, 2**18), "large": (2**18, 2**24)}
"""Numbers of grid points by size."""

_RATIOS = (-0.999, -0.9, -0.5, 0.0, 0.1, 0.25, 0.3, 0.4, 0.45, 0.5, *(0.5 - 10.0**-k for k in (2, 3, 4, 6, 9, 12, 15)))
_MOST_ITERATIONS = 20_000
_PROFILES = ("power", "rough", "measured")
_PRIMES = (5, 7, 11, 13, 61, 127, 521, 1021, 2053, 4099, 8191, 16381, 65537, 131071, 262147, 1048583, 4194319)


@dataclass(frozen=True)
class Cell:
    """One random scene, and how it is to be solved."""

    scene: Scene
    """In units L = E* = 1."""
    shape: str
    """Name of the kind of profile."""
    full_load: float
    """About the p/E* of full contact (dimensionless)."""
    length: float
    """Unit of length that the scene is solved in."""
    stress: float
    """Unit of pressure that the scene is solved in."""
    options: dict[str, Any]
    """Options of `solve`."""
    initial: int | None
    """Seed of a displacement from elsewhere to start with; None for a cold start."""

    def in_units(self, length: float, stress: float) -> Scene:
        """The same scene with these units of length and pressure."""
        scene = self.scene
        layer, indenter = scene.layer.in_units(length, stress), scene.indenter.in_units(length)
        return replace(scene, layer=layer, indenter=indenter, pressure=scene.pressure * stress, period=length)


def draw(seed: int, number: int, column: int, row: int, size: str) -> Cell:
    """Draw a cell at a place on the map.

    number: of the stream of random numbers. column, row: the place, below `COLUMNS` and `ROWS`. size: one of `SIZES`.
    """
    rng = np.random.default_rng([seed, number])
    thickness = math.inf if column == COLUMNS - 1 else float(10 ** (column - 12 + rng.random()))
    layer = Layer(thickness, float(rng.choice(_RATIOS)) if rng.random() < 0.8 else float(rng.uniform(-0.999, 0.5)))
    num_points = _draw_points(rng, *SIZES[size])
    shape, indenter = _draw_indenter(rng, num_points)
    full = _full_load(indenter, layer, num_points)
    highest = math.log10(10 * full / LEAST_LOAD)
    load = LEAST_LOAD * 10 ** (max(highest, 1.0) * (row + rng.random()) / ROWS)
    options, precision = _draw_options(rng, num_points)
    scene = Scene(layer, indenter, float(load), num_points=num_points, precision=precision)
    units = 10.0 ** rng.integers(-30, 31, 2) if rng.random() < 0.5 else np.ones(2)
    initial = int(rng.integers(2**31)) if "accuracy" not in options and rng.random() < 0.1 else None
    return Cell(scene, shape, full, float(units[0]), float(units[1]), options, initial)


def _draw_points(rng: Generator, low: int, high: int) -> int:
    """A number of grid points: any number, a prime, a power of two, or a power of three."""
    powers = [b**k for b in (2, 3) for k in range(1, 25) if low <= b**k <= high]
    primes = [p for p in _PRIMES if low <= p <= high]
    kind = rng.integers(4)
    if kind == 0 or (kind == 1 and not primes):
        return round(low * float((high / low) ** rng.random()))
    return int(rng.choice(primes if kind == 1 else powers))


def _draw_indenter(rng: Generator, num_points: int) -> tuple[str, PowerIndenter | RoughIndenter | MeasuredIndenter]:
    shape = str(rng.choice(_PROFILES))
    if shape == "power":
        chosen, other = rng.choice([1.01, 1.5, 2, 4, 64]), 1.01 * (64 / 1.01) ** rng.random()
        exponent = float(chosen if rng.random() < 0.5 else other)
        # of radii far from L, slopes at the period's end are 1e-8 to 1e4
        slope = 10 ** rng.uniform(-8, 4)
        radius = 1.0 if rng.random() < 0.5 else 0.5 * slope ** (-1 / max(exponent - 1, 0.2))
        return shape, PowerIndenter(exponent, float(radius))
    gradient = 1.0 if rng.random() < 0.5 else float(10 ** rng.uniform(-8, 4))
    most = min((num_points - 1) // 2, 2**20)  # waves in the period, down to 2 dx
    if shape == "rough":
        waves = max(1, round(most ** rng.random()))
        roll_off = waves ** -rng.random()
        ratios = roll_off, min(1.0, 1 / (waves * roll_off))
        return shape, RoughIndenter(float(rng.uniform(0.01, 0.99)), int(rng.integers(2**31)), *ratios, gradient)
    shape = str(rng.choice(list(_HEIGHTS)))
    heights = _HEIGHTS[shape](num_points, rng)
    if not np.ptp(heights):
        heights[0] += 1
    return shape, MeasuredIndenter(gradient * heights, convention="gap")


def _flat_punch(n: int, rng: Generator) -> Array64:
    return np.where(np.arange(n) < max(1, round(n * rng.uniform(0, 0.9))), 0.0, 1.0)


def _steps(n: int, rng: Generator) -> Array64:
    return rng.integers(0, 5, 8)[np.arange(n) * 8 // n].astype(np.float64)


def _spike(n: int, rng: Generator, low: float) -> Array64:
    heights = np.full(n, 1 - low)
    heights[rng.integers(n)] = low
    return heights


def _two_nodes(n: int, rng: Generator) -> Array64:
    heights = np.ones(n)
    heights[rng.integers(0, n, 2)] = 0
    return heights


def _around_the_end(n: int, rng: Generator) -> Array64:
    return np.minimum(np.arange(n), n - np.arange(n)) ** rng.uniform(1.1, 4) / n


def _plateau(n: int, rng: Generator) -> Array64:
    heights = np.maximum(0, np.abs(np.arange(n) - n // 2) / n - rng.uniform(0, 0.5))
    return heights + 1e-15 * rng.random(n)


_HEIGHTS = {
    "flat punch": _flat_punch,
    "steps": _steps,
    "needle": lambda n, rng: _spike(n, rng, 0.0),
    "pit": lambda n, rng: _spike(n, rng, 1.0),
    "two nodes": _two_nodes,
    "noise": lambda n, rng: rng.random(n),
    "teeth": lambda n, rng: (np.arange(n) % 2).astype(np.float64),
    "saw": lambda n, rng: (np.arange(n) * int(rng.integers(1, 9)) % n) / n,
    "around the end": _around_the_end,
    "plateau": _plateau,
}


def _full_load(indenter: PowerIndenter | RoughIndenter | MeasuredIndenter, layer: Layer, num_points: int) -> float:
    """p/E* at which the last node touches, 1e-12 to 1e12 (dimensionless)."""
    heights = np.minimum(indenter.profile(num_points, 1.0), 1e100)
    stiffness = half_spectrum(layer, num_points, 1.0)
    with np.errstate(over="ignore", invalid="ignore"):
        highest = float(irfft(stiffness * rfft(heights), num_points).max())
    return min(max(highest, 1e-12), 1e12) if math.isfinite(highest) else 1e12


def _draw_options(rng: Generator, num_points: int) -> tuple[dict[str, Any], str]:
    """Options of `solve`, and the precision: mostly the default ones, now and then more than can be had."""
    if rng.random() < 0.15:
        return {"accuracy": float(10 ** rng.uniform(-8.9, -1))}, "float64"
    slow = num_points > 2**15
    shares = np.array([kind.share for kind in METHODS.values()])
    method = DEFAULT.name if slow else str(rng.choice(list(METHODS), p=shares / shares.sum()))
    options: dict[str, Any] = {"method": method}
    if METHODS[method].max_iterations > _MOST_ITERATIONS:
        options["max_iterations"] = _MOST_ITERATIONS
    if rng.random() < 0.1:
        options["tolerance"] = float(10 ** rng.uniform(-13.9, -1))
    elif rng.random() < 0.1:
        options["nested"] = bool(rng.integers(2))
    precision = str(rng.choice(PRECISIONS, p=(0.6, 0.2, 0.2)))
    return options, precision if precision in METHODS[method].precisions else METHODS[method].precisions[0]
