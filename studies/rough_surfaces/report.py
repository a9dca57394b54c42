"""The report of the study of rough surfaces: a table, and the values on the half-space."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..multilevel.allocation import State
from ..multilevel.samples import FOUNDATION
from ..terminal import console
from . import ensembles, means


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
    every = list(means.points(file))
    for hurst in dict.fromkeys(p.hurst for p in every):
        kappa = means.Mean.of(np.array(list(means.half_space(file, hurst).values())))
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
                f"{thin.slope.value / means.single_patch(nu, kappa.value):.3g}",
                f"{np.mean(alone):.2f}",
                f"{sum(run['seconds.total'] for run in layers):.0f}",
            )
    return table


def _half_space_row(file: StudyFile, hurst: float) -> tuple[str, ...]:
    runs = [run for run in file.select("scene.hurst", hurst).runs if math.isinf(run["scene.thickness"])]
    ok = sum(run["status"] == "converged" for run in runs)
    patches = means.Mean.of(np.array([run["num_patches"] for run in runs]))
    return f"{ok}/{len(runs)}", f"{patches.value:.3g}", "", "", "", f"{sum(run['seconds.total'] for run in runs):.0f}"


def kappas(file: StudyFile) -> str:
    """kappa_inf with its standard error, for every Hurst exponent."""
    parts = []
    for hurst in file.configuration["hursts"]:
        values = [np.array(list(means.half_space(file, hurst, name).values())) for name in ("kappa_subgrid", "kappa")]
        if values[0].size:
            parts.append(f"H = {hurst:g}: {means.Mean.of(values[0])} (counted {means.Mean.of(values[1])})")
    return f"kappa_inf of the same surfaces (published: {means.PUBLISHED_KAPPA}), dimensionless: {'; '.join(parts)}."


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """For each file a table, and a sentence on the values on the half-space or on the request."""
    return [
        part
        for file in files.values()
        for part in (_to_standard_error(file) if ensembles.is_one(file) else (summary(file), kappas(file)))
    ]


def _to_standard_error(file: StudyFile) -> Sequence[RenderableType]:
    """A row for each Hurst exponent and Poisson's ratio, and the missing ones."""
    asked, found = file.configuration["standard_error"], ensembles.states(file)
    table = console.table(
        padding=0,
        title=f"rough to a standard error of {asked:g}, p = {file.configuration['pressure']:g} E*",
        caption="ok: points whose kappa and contact area have that standard error, over their means; surfaces: the "
        "fewest and the most of a point; grids: the finest ones of the points; y: (kappa_d/kappa_inf)/(d/a_r) at the "
        "thinnest layer, mean and standard error, and over the single patch's 2 sqrt(3) (1-2nu)/(1-nu)^2/kappa_inf; s: "
        "seconds of solving in all; plain: seconds that the finest grids alone would take for the same error. Rows "
        "with nu = -: the half-space, y is kappa_inf. All but s and plain dimensionless.",
    )
    for heading in ("H", "nu", "ok", "surfaces", "grids", "y", "y/single", "s", "plain"):
        table.add_column(heading, justify="right", no_wrap=True)
    every, in_all = list(ensembles.points(found)), np.zeros(2)
    for hurst, nu, half_space in dict.fromkeys((h, nu, math.isinf(d)) for h, nu, d in found):
        kappa = ensembles.kappa_inf(found, hurst)
        own = [p for p in every if (p.hurst, p.poisson_ratio) == (hurst, nu)]
        y = ("", "")
        if half_space and kappa:
            y = (str(means.Mean(kappa.mean, kappa.standard_error)), "")
        elif own and kappa:
            thin = min(own, key=lambda p: p.thickness)
            y = (str(thin.slope), f"{thin.slope.value / means.single_patch(nu, kappa.mean):.3g}")
        chosen = {key: s for key, s in found.items() if (*key[:2], math.isinf(key[2])) == (hurst, nu, half_space)}
        runs = file.select("scene.hurst", hurst).select("scene.poisson_ratio", nu).runs
        spent = sum(run["seconds.total"] for run in runs if math.isinf(run["scene.thickness"]) == half_space)
        ok, *sizes, plain = _sizes(list(chosen.values()))
        in_all += spent, plain
        table.add_row(f"{hurst:g}", "-" if half_space else f"{nu:g}", ok, *sizes, *y, f"{spent:.0f}", f"{plain:.0f}")
    compared = f"In all {in_all[0]:.3g} s of solving; the points' finest grids alone would take about {in_all[1]:.3g} s"
    if in_all[0] > in_all[1]:
        compared += ": at this standard error, which few surfaces reach, coarse grids do not pay"
    return [table, f"{compared}."]


def missed(file: StudyFile) -> list[str]:
    """Why points have not the standard error asked for, a line each; none where nothing was asked for."""
    found = ensembles.states(file).values() if ensembles.is_one(file) else ()
    return sorted({state.out_of_reach for state in found if state.out_of_reach})


def _sizes(states: Sequence[State]) -> tuple[str, str, str, float]:
    """How many points are done, their surfaces and grids, and the time of plain sampling [s]."""
    known = [state.estimates["kappa"] for state in states if state.estimates]
    ok = f"{sum(state.done for state in states)}/{len(states)}"
    if not known:
        return ok, "", "", 0.0
    surfaces = [next(term.count for term in estimate.terms if term.num_points != FOUNDATION) for estimate in known]
    finest = [math.log2(estimate.terms[-1].num_points) for estimate in known]
    plain = sum(estimate.plain_cost(estimate.standard_error) for estimate in known)
    return ok, _span(surfaces), f"2^{_span(finest)}", plain


def _span(numbers: Sequence[float]) -> str:
    low, high = min(numbers), max(numbers)
    return f"{low:g}" if low == high else f"{low:g}-{high:g}"
