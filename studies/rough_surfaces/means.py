"""Means over the realisations of rough surfaces, with standard errors, for the report and the figures."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import rounded_up
from linecontact.solver.layers.bonded import foundation_compliance

from ..files.study_files import StudyFile

PUBLISHED_KAPPA = 1.75
"""The published kappa_inf of roughness on the half-space (dimensionless)."""
PUBLISHED_ALPHA = 2 * math.pi / 3
"""The published factor of (1-2nu)/(1-nu)^2 d/a_r in kappa_d/kappa_inf on thin layers (dimensionless)."""


@dataclass(frozen=True)
class Mean:
    """Mean over realisations and its standard error."""

    value: float
    """The mean."""
    error: float
    """Its standard error; NaN for a single realisation."""

    @classmethod
    def of(cls, values: Array64) -> "Mean":
        """The mean of one value per realisation."""
        error = float(np.std(values, ddof=1)) / math.sqrt(values.size) if values.size > 1 else math.nan
        return cls(float(np.mean(values)) if values.size else math.nan, error)

    def __str__(self) -> str:
        if not 0 < self.error < math.inf:
            return f"{self.value:.4g} +- {self.error}"
        error = float(rounded_up(self.error))
        digits = max(0, 1 - math.floor(math.log10(error)))
        return f"{self.value:.{digits}f} +- {error:.{digits}f}"


@dataclass(frozen=True)
class Realisation:
    """One surface on one layer, beside itself on the half-space; sub-grid areas, all dimensionless."""

    reduced: float
    """d/a_r."""
    kappa_ratio: float
    """kappa_d over kappa_inf of the same surface."""
    patches: float
    """Number of contact patches, M."""
    bias: float
    """a_r counted over a_r between sub-grid edges."""
    kappa_inf: float
    """kappa of the same surface on the half-space."""

    @property
    def slope(self) -> float:
        """(kappa_d/kappa_inf)/(d/a_r)."""
        return self.kappa_ratio / self.reduced


@dataclass(frozen=True)
class Point:
    """Means over the realisations for one H, nu and d, all dimensionless."""

    hurst: float
    """H."""
    poisson_ratio: float
    """nu."""
    thickness: float
    """d/L."""
    reduced_thickness: Mean
    """d/a_r."""
    per_width: Mean
    """d over the mean width of a patch, M d/a_r."""
    kappa_ratio: Mean
    """kappa_d/kappa_inf."""
    slope: Mean
    """(kappa_d/kappa_inf)/(d/a_r)."""
    patches: Mean
    """Number of contact patches, M."""
    per_patch: Mean
    """kappa_d/(d/a_r)/M over (1-2nu)/(1-nu)^2, which is 2 sqrt(3) for one parabolic patch."""
    bias: Mean
    """a_r counted over a_r between sub-grid edges."""


def half_space(file: StudyFile, hurst: float, name: str = "kappa_subgrid") -> dict[int, float]:
    """A quantity on the half-space for each surface of one Hurst exponent, by seed."""
    runs = [run for run in file.runs if run["scene.hurst"] == hurst and math.isinf(run["scene.thickness"])]
    return {run["scene.seed"]: run[name] for run in runs}


def realisations(file: StudyFile) -> dict[tuple[float, float, float], dict[int, Realisation]]:
    """Every surface that is done on a layer and on the half-space: by H, nu and thickness, and by seed."""
    references = {hurst: half_space(file, hurst) for hurst in {run["scene.hurst"] for run in file.runs}}
    found: dict[tuple[float, float, float], dict[int, Realisation]] = {}
    for run in file.runs:
        hurst, thickness, seed = run["scene.hurst"], run["scene.thickness"], run["scene.seed"]
        if math.isfinite(thickness) and seed in references[hurst]:
            area, kappa_inf = run["contact_area_subgrid"], references[hurst][seed]
            found.setdefault((hurst, run["scene.poisson_ratio"], thickness), {})[seed] = Realisation(
                reduced=thickness / area,
                kappa_ratio=run["kappa_subgrid"] / kappa_inf,
                patches=run["num_patches"],
                bias=run["contact_area"] / area,
                kappa_inf=kappa_inf,
            )
    return found


def points(file: StudyFile) -> Iterator[Point]:
    """Every point of which at least one realisation is done, from thick to thin."""
    for (hurst, nu, thickness), surfaces in realisations(file).items():
        own, foundation = list(surfaces.values()), foundation_compliance(nu)

        def mean(quantity: Callable[[Realisation], float], own: list[Realisation] = own) -> Mean:
            return Mean.of(np.array([quantity(r) for r in own]))

        yield Point(
            hurst,
            nu,
            thickness,
            reduced_thickness=mean(lambda r: r.reduced),
            per_width=mean(lambda r: r.reduced * r.patches),
            kappa_ratio=mean(lambda r: r.kappa_ratio),
            slope=mean(lambda r: r.slope),
            patches=mean(lambda r: r.patches),
            per_patch=mean(lambda r, f=foundation: r.slope * r.kappa_inf / r.patches / f),  # type: ignore[misc]
            bias=mean(lambda r: r.bias),
        )


def single_patch(poisson_ratio: float, kappa_inf: float) -> float:
    """(kappa_d/kappa_inf)/(d/a_r) of one parabolic patch on a thin layer: 2 sqrt(3) (1-2nu)/(1-nu)^2/kappa_inf."""
    return 2 * math.sqrt(3) * foundation_compliance(poisson_ratio) / kappa_inf
