"""The published study's Figure 5: randomly rough surfaces on layers of any thickness, means over realisations.

    python -m linecontact.studies.rough [--quick] [--folder FOLDER]

Paired: the same surfaces (common seeds) for every Hurst exponent H, Poisson's ratio and thickness, so that kappa_d is
compared with kappa_inf of the same surface. Every solve starts cold, on nested grids: measured, that takes 0.4 to 1.1
of the time of a start from the solution for a neighbouring thickness, and leaves the tasks independent.
"""

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from linecontact.solver import Layer, RoughIndenter, Scene, closed_forms, solve
from linecontact.solver.problem import Problem
from linecontact.solver.relaxation import Progress
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table

from .files import records
from .files.study_files import StudyFile
from .runner import ensemble
from .runner.tasks import Record
from .terminal import console

Array64 = NDArray[np.float64]

KIND = "rough"
PUBLISHED_KAPPA = 1.75
PUBLISHED_ALPHA = 2 * math.pi / 3


@dataclass(frozen=True)
class Configuration:
    """What identifies the study; lengths in units of the period, pressures of E*.

    cut_off_ratio: lambda_s/lambda_r; 512/N keeps 64 grid points to the shortest wave, with lambda_r = L/8.
    """

    num_points: int = 2**18
    cut_off_ratio: float = 1 / 512
    pressure: float = 0.01
    hursts: tuple[float, ...] = (0.3, 0.5, 0.8)
    poisson_ratios: tuple[float, ...] = (0.0, 0.25, 0.45, 0.49)
    thicknesses: tuple[float, ...] = tuple(float(f"{d:.4g}") for d in np.geomspace(0.1, 1e-7, 13))
    realisations: int = 32
    tolerance: float = 1e-8
    method: str = "active-set"


QUICK = Configuration(
    num_points=2**14, cut_off_ratio=1 / 32, realisations=8, thicknesses=Configuration.thicknesses[:11]
)


@dataclass(frozen=True)
class Task:
    """One solve."""

    num_points: int
    cut_off_ratio: float
    pressure: float
    hurst: float
    poisson_ratio: float
    thickness: float
    seed: int
    tolerance: float
    method: str

    def scene(self) -> Scene:
        """The scene to solve."""
        indenter = RoughIndenter(self.hurst, self.seed, cut_off_ratio=self.cut_off_ratio)
        return Scene(Layer(self.thickness, self.poisson_ratio), indenter, self.pressure, num_points=self.num_points)

    def run(self, report: Progress | None) -> Record:
        """The solution's record."""
        return records.run_record(solve(self.scene(), method=self.method, tolerance=self.tolerance, progress=report))


@dataclass(frozen=True)
class PerssonLine:
    """Persson's prediction over the thickness, for the ensemble's spectrum; its gradient is the whole surface's."""

    task: Task
    thicknesses: tuple[float, ...]

    def run(self, _: Progress | None) -> Record:
        """Columns of the line; kappa for the rms gradient 1 of the whole surface."""
        areas = [self._area(d) for d in (*self.thicknesses, math.inf)]
        kappa = [area / self.task.pressure for area in areas]
        return {
            "reduced_thickness": [d / area for d, area in zip(self.thicknesses, areas, strict=False)],
            "kappa_ratio": [k / kappa[-1] for k in kappa[:-1]],
        }

    def _area(self, thickness: float) -> float:
        problem = Problem.from_scene(replace(self.task, thickness=thickness).scene())
        stiffness, height = problem.stiffness * problem.stiffness_unit, problem.height * problem.length_unit
        return closed_forms.persson_area(self.task.pressure, stiffness, height)


def study(c: Configuration) -> ensemble.Study:
    """The tasks: the half-space once for every surface, every layer for every Poisson's ratio."""

    def task(hurst: float, nu: float, thickness: float, seed: int) -> Task:
        return Task(c.num_points, c.cut_off_ratio, c.pressure, hurst, nu, thickness, seed, c.tolerance, c.method)

    layers = [(0.0, math.inf), *((nu, d) for nu in c.poisson_ratios for d in c.thicknesses)]
    line = tuple(np.geomspace(c.thicknesses[0] * 2, c.thicknesses[-1], 40).tolist())
    return ensemble.Study(
        kind=KIND,
        configuration=asdict(c),
        runs=[task(h, *layer, seed) for h in c.hursts for layer in layers for seed in range(c.realisations)],
        lines={
            f"persson H={h:g} nu={nu:g}": PerssonLine(task(h, nu, math.inf, 0), line)
            for h in c.hursts
            for nu in c.poisson_ratios
        },
        figures=("", "-patches", "-area"),
    )


@dataclass(frozen=True)
class Mean:
    """Mean over realisations and its standard error."""

    value: float
    error: float

    @classmethod
    def of(cls, values: Array64) -> "Mean":
        """From one value per realisation."""
        error = float(np.std(values, ddof=1)) / math.sqrt(values.size) if values.size > 1 else math.nan
        return cls(float(np.mean(values)) if values.size else math.nan, error)

    def __str__(self) -> str:
        if not self.error > 0:
            return f"{self.value:.4g} +- {self.error}"
        digits = max(0, -math.floor(math.log10(self.error)))
        return f"{self.value:.{digits}f} +- {self.error:.{digits}f}"


@dataclass(frozen=True)
class Realisation:
    """One surface on one layer, beside itself on the half-space; sub-grid areas, all dimensionless.

    reduced: d/a_r; kappa_ratio: kappa_d over kappa_inf of the same surface; patches: M; bias: a_r counted over a_r;
    kappa_inf: of the same surface.
    """

    reduced: float
    kappa_ratio: float
    patches: float
    bias: float
    kappa_inf: float

    @property
    def slope(self) -> float:
        """(kappa_d/kappa_inf)/(d/a_r)."""
        return self.kappa_ratio / self.reduced


@dataclass(frozen=True)
class Point:
    """Means over the realisations for one H, nu and d, all dimensionless.

    reduced_thickness: d/a_r; per_width: d over the mean width of a patch, M d/a_r; slope: (kappa_d/kappa_inf)/(d/a_r);
    patches: M; per_patch: kappa_d/(d/a_r)/M over (1-2nu)/(1-nu)^2, 2 sqrt(3) for one patch; bias: a_r counted over
    a_r.
    """

    hurst: float
    poisson_ratio: float
    thickness: float
    reduced_thickness: Mean
    per_width: Mean
    kappa_ratio: Mean
    slope: Mean
    patches: Mean
    per_patch: Mean
    bias: Mean


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
        own, foundation = list(surfaces.values()), (1 - 2 * nu) / (1 - nu) ** 2

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


def summary(file: StudyFile) -> Table:
    """The closing table: one row per Hurst exponent and Poisson's ratio."""
    c = file.configuration
    table = console.table(
        title=f"rough, {c['num_points']} points, p = {c['pressure']:g} E*, {c['realisations']} realisations",
        caption="ok: runs certified at the tolerance; M: mean number of patches from the thickest to the thinnest "
        "layer; y: (kappa_d/kappa_inf)/(d/a_r) at the thinnest, mean and standard error, and over the single patch's "
        "2 sqrt(3) (1-2nu)/(1-nu)^2/kappa_inf; alone: share of realisations with one patch there; s: seconds of "
        "solving in all. Sub-grid areas. Rows with nu = -: the half-space. All but s dimensionless.",
    )
    for heading in ("H", "nu", "ok", "M", "y", "y/single", "alone", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    every = list(points(file))
    for hurst in dict.fromkeys(p.hurst for p in every):
        kappa = Mean.of(np.array(list(half_space(file, hurst).values())))
        table.add_row(f"{hurst:g}", "-", *_half_space_row(file, hurst))
        for nu in dict.fromkeys(p.poisson_ratio for p in every):
            own = [p for p in every if (p.hurst, p.poisson_ratio) == (hurst, nu)]
            if not own:
                continue
            runs = file.select("scene.hurst", hurst).select("scene.poisson_ratio", nu)
            layers = [run for run in runs.runs if math.isfinite(run["scene.thickness"])]
            thin = min(own, key=lambda p: p.thickness)
            alone = [run["num_patches"] == 1 for run in layers if run["scene.thickness"] == thin.thickness]
            table.add_row(
                f"{hurst:g}",
                f"{nu:g}",
                f"{sum(run['status'] == 'converged' for run in layers)}/{len(layers)}",
                f"{own[0].patches.value:.3g} to {thin.patches.value:.3g}",
                str(thin.slope),
                f"{thin.slope.value / single_patch(nu, kappa.value):.3g}",
                f"{np.mean(alone):.2f}",
                f"{sum(run['seconds.total'] for run in layers):.0f}",
            )
    return table


def _half_space_row(file: StudyFile, hurst: float) -> tuple[str, ...]:
    runs = [run for run in file.select("scene.hurst", hurst).runs if math.isinf(run["scene.thickness"])]
    ok = sum(run["status"] == "converged" for run in runs)
    patches = Mean.of(np.array([run["num_patches"] for run in runs]))
    return f"{ok}/{len(runs)}", f"{patches.value:.3g}", "", "", "", f"{sum(run['seconds.total'] for run in runs):.0f}"


def single_patch(poisson_ratio: float, kappa_inf: float) -> float:
    """(kappa_d/kappa_inf)/(d/a_r) of one parabolic patch on a thin layer: 2 sqrt(3) (1-2nu)/(1-nu)^2/kappa_inf."""
    return 2 * math.sqrt(3) * (1 - 2 * poisson_ratio) / (1 - poisson_ratio) ** 2 / kappa_inf


def kappas(file: StudyFile) -> str:
    """kappa_inf with its standard error, for every Hurst exponent."""
    parts = []
    for hurst in file.configuration["hursts"]:
        values = [np.array(list(half_space(file, hurst, name).values())) for name in ("kappa_subgrid", "kappa")]
        if values[0].size:
            parts.append(f"H = {hurst:g}: {Mean.of(values[0])} (counted {Mean.of(values[1])})")
    return f"kappa_inf of the same surfaces (published: {PUBLISHED_KAPPA}), dimensionless: {'; '.join(parts)}."


def closing(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """Table and half-space values."""
    return [part for file in files.values() for part in (summary(file), kappas(file))]


@dataclass(frozen=True)
class Options(ensemble.Options):
    """Randomly rough surfaces (the published study's Figure 5), 2^18 points, 32 realisations: minutes on two cores.

    Run again after an interruption, it continues; run again when finished, it says so.
    """

    quick: bool = False
    """2^14 points and 8 realisations."""


def command(options: Options) -> int:
    """Run the study as asked; returns the exit status."""
    folder = Path("results/rough-quick" if options.quick else "results/rough")
    return ensemble.command([study(QUICK if options.quick else Configuration())], options, folder, closing)


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.rough"))
