"""Numbers read off the solves: kappa over the load for every shape and layer, and where it is constant."""

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.reference import closed_forms

from ..files.study_files import StudyFile
from ..power_profiles.tasks import RADIUS
from ..rough_surfaces.means import Mean
from ..runner.tasks import Record
from .tasks import line_name

CONSTANT = 0.05
"""Largest over smallest value, less 1, up to which a quantity counts as constant (dimensionless)."""

_WIDE = 2.0  # largest over smallest load, from which a run of loads tells anything
_LONE = 0.1  # a_r up to which a parabola does not feel its images


@dataclass(frozen=True)
class Point:
    """One load; of rough surfaces the means over the realisations. All dimensionless, p over E*."""

    pressure: float
    """p/E*."""
    area: Mean
    """a_r between sub-grid edges."""
    kappa: Mean
    """a_r/p* with the rms gradient over the contact."""
    ratio: Mean
    """kappa over that of the same surface at the same load on the half-space; of power profiles, over kappa_inf(n)."""
    reduced_thickness: Mean
    """d/(a_r L)."""
    patches: Mean
    """Number of contact patches, M."""
    per_width: Mean
    """d over the mean width of a patch, M d/(a_r L)."""
    persson: float
    """a_r by Persson's theory; NaN for power profiles."""
    exact_kappa: float
    """kappa by the closed form; NaN but for power profiles on the half-space."""

    @property
    def kappa_surface(self) -> Mean:
        """a_r/p* with the rms gradient of the whole surface, which is 1 for the rough ones."""
        return Mean(self.area.value / self.pressure, self.area.error / self.pressure)


@dataclass(frozen=True)
class Curve:
    """One shape on one layer, over the load."""

    rough: bool
    """Whether the shape is a rough surface."""
    shape: float
    """H of a rough surface, n of a power profile (dimensionless)."""
    poisson_ratio: float
    """nu of the layer."""
    thickness: float
    """d/L; inf for the half-space."""
    points: list[Point]
    """From the smallest load to the largest."""

    @property
    def name(self) -> str:
        """The shape, for a table."""
        return f"{'H' if self.rough else 'n'} = {self.shape:g}"

    @property
    def is_half_space(self) -> bool:
        """Whether the layer is one."""
        return math.isinf(self.thickness)

    @property
    def constant(self) -> list[Point]:
        """The longest run of loads within which kappa is constant, see `CONSTANT`: one, or loads that differ enough."""
        best: list[Point] = []
        for start in range(len(self.points)):
            for stop in range(start + 1, len(self.points) + 1):
                values = [point.kappa.value for point in self.points[start:stop]]
                span = self.points[stop - 1].pressure / self.points[start].pressure
                if 1 < span < _WIDE:
                    continue
                if min(values) > 0 and max(values) <= (1 + CONSTANT) * min(values) and stop - start > len(best):
                    best = self.points[start:stop]
        return best


def curves(file: StudyFile) -> list[Curve]:
    """Every curve of which a point is done: first the power profiles, then the rough surfaces; from thick to thin."""
    groups: dict[tuple[bool, float, float, float], dict[float, dict[int, Record]]] = defaultdict(dict)
    for run in file.runs:
        rough = run["scene.profile"] == "rough"
        shape = run["scene.hurst" if rough else "scene.exponent"]
        key = (rough, shape, run["scene.poisson_ratio"], run["scene.thickness"])
        seed = int(run["scene.seed"]) if rough else 0
        groups[key].setdefault(run["scene.pressure"], {})[seed] = run
    found = []
    for (rough, shape, nu, thickness), loads in groups.items():
        half_space = groups.get((rough, shape, 0.0, math.inf), {})
        line = file.lines.get(line_name(shape, nu, thickness)) if rough else None
        points = []
        for pressure, runs in sorted(loads.items()):
            if not rough:
                points.append(_profile_point(runs[0], shape))
                continue
            persson = float(np.interp(pressure, line["pressure"], line["contact_area"])) if line else math.nan
            points.append(_rough_point(runs, half_space.get(pressure, {}), persson))
        found.append(Curve(rough, shape, nu, thickness, points))
    return sorted(found, key=lambda c: (c.rough, c.shape, -2 if c.is_half_space else c.poisson_ratio, -c.thickness))


def bending_thickness(curve: Curve) -> float:
    """d/(a_r L) at which the layer has taken `CONSTANT` off kappa, between two loads; NaN where it does nowhere."""
    thick = 1 / (1 + CONSTANT)
    for before, after in itertools.pairwise(curve.points):
        if before.ratio.value >= thick > after.ratio.value:
            part = (before.ratio.value - thick) / (before.ratio.value - after.ratio.value)
            ends = [math.log(point.reduced_thickness.value) for point in (before, after)]
            return math.exp(ends[0] + part * (ends[1] - ends[0]))
    return math.nan


def parabola(every: Sequence[Curve]) -> tuple[Array64, Array64]:
    """d/(a_r L) and kappa_d/kappa_inf of a parabola that does not feel its images, in ascending order; shape (M,)."""
    layers = [curve for curve in every if not curve.rough and curve.shape == 2 and not curve.is_half_space]
    lone = [point for curve in layers for point in curve.points if point.area.value < _LONE]
    pairs = sorted((point.reduced_thickness.value, point.ratio.value) for point in lone)
    x, ratio = np.array(pairs).reshape(-1, 2).T
    return x, ratio


def _profile_point(run: Record, exponent: float) -> Point:
    lone, area = closed_forms.kappa_half_space(exponent), Mean(run["contact_area_subgrid"], run["contact_area_error"])
    kappa = Mean(run["kappa_subgrid"], run["kappa_error"])
    return Point(
        pressure=run["scene.pressure"],
        area=area,
        kappa=kappa,
        ratio=Mean(kappa.value / lone, kappa.error / lone),
        reduced_thickness=Mean(run["scene.thickness"] / area.value, math.nan),
        patches=Mean(run["num_patches"], 0.0),
        per_width=Mean(run["num_patches"] * run["scene.thickness"] / area.value, math.nan),
        persson=math.nan,
        exact_kappa=closed_forms.kappa_from_area(exponent, run["half_space_area"], RADIUS, run["scene.pressure"])
        if math.isinf(run["scene.thickness"])
        else math.nan,
    )


def _rough_point(runs: dict[int, Record], half_space: dict[int, Record], persson: float) -> Point:
    def mean(quantity: Callable[[Record], float], chosen: Sequence[Record] = tuple(runs.values())) -> Mean:
        return Mean.of(np.array([quantity(run) for run in chosen]))

    both = [run for seed, run in runs.items() if seed in half_space]
    first = next(iter(runs.values()))

    def thickness_over(length: Callable[[Record], float]) -> Mean:
        inverse = mean(lambda run: 1 / length(run))  # first, as the thickness may be infinite
        return Mean(first["scene.thickness"] * inverse.value, first["scene.thickness"] * inverse.error)

    return Point(
        pressure=first["scene.pressure"],
        area=mean(lambda run: run["contact_area_subgrid"]),
        kappa=mean(lambda run: run["kappa_subgrid"]),
        ratio=mean(lambda run: run["kappa_subgrid"] / half_space[int(run["scene.seed"])]["kappa_subgrid"], both),
        reduced_thickness=thickness_over(lambda run: run["contact_area_subgrid"]),
        patches=mean(lambda run: run["num_patches"]),
        per_width=thickness_over(lambda run: run["contact_area_subgrid"] / run["num_patches"]),
        persson=persson,
        exact_kappa=math.nan,
    )
