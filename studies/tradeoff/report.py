"""Tables of the fronts, and the findings in words: all from the stored runs."""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from linecontact.solver import METHODS, Status
from linecontact.solver.methods import fire
from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..terminal import console
from .ensembles import ALONE, ENSEMBLES, MANY
from .families import FAMILIES, MEASURES, is_rough
from .front import AXES, NEAR, Point, Run, Worth, front, over_front, points, runs_of, worth
from .measuring import REFUSED


def parts(study: StudyFile) -> Iterator[RenderableType]:
    """A table for each family, and the sentences."""
    for family in FAMILIES:
        if any(run["status"] == "converged" for run in runs_of(study, "choice", family)):
            yield front_table(study, family)
    yield from never_worth(worth(study))
    yield from published(study)
    yield from precisions(study)
    yield from random_scenes(study)
    yield from means(study)
    yield from not_certified(study)


def paper_choice(study: StudyFile, family: str) -> Run | None:
    """The run of the published choice: plain FIRE on one grid of 2^18 points, float64."""
    size, mine = study.configuration["paper"], runs_of(study, "choice", family)
    asked = {
        "method": fire.KIND.name,
        "precision": "float64",
        "nested": False,
        "log2_points": size,
        "tolerance.asked": "1e-05",
    }
    return next((run for run in mine if all(run[name] == value for name, value in asked.items())), None)


def front_table(study: StudyFile, family: str) -> Table:
    """A table of the front of the area by choices by hand, and of others beside it."""
    table = console.table(
        padding=0,
        title=f"{family}: the least time for an error of a_r",
        caption="a_r, kappa, peak, field: relative errors of area, coefficient, largest pressure and (rms) pressure; "
        "s: seconds in all, set-up and certificate included; x: over the least time for such an error of a_r above the "
        "line; N: grid points; mass-w.: mass-weighted FIRE. Areas and kappa are between sub-grid edges unless counted. "
        "All but s dimensionless.",
    )
    for heading in ("a_r", "kappa", "peak", "field", "s", "x", "N", "choice"):
        table.add_column(heading, justify="left" if heading == "choice" else "right", no_wrap=True)
    best = front(points(runs_of(study, "choice", family), "a_r"))
    for point in best:
        table.add_row(*_cells(point, best), _choice(point))
    table.add_section()
    for point in _beside(study, family):
        table.add_row(*_cells(point, best), _choice(point))
    for text, point in _asked(study, family):
        table.add_row(*_cells(point, best), text)
    return table


def _beside(study: StudyFile, family: str) -> list[Point]:
    """The points shown beside the front: the published choice by counting, the peers, and the best by collocation."""
    paper = paper_choice(study, family)
    chosen = [p for p in points([paper], "a_r") if p.counted] if paper else []
    peers = runs_of(study, "peer", family)
    largest = max((run["log2_points"] for run in peers), default=0)
    chosen += points([run for run in peers if run["log2_points"] == largest], "a_r")
    return chosen + front(points(runs_of(study, "oracle", family), "a_r"))[-1:]


def _asked(study: StudyFile, family: str) -> Iterator[tuple[str, Point]]:
    """Rows on solving to an accuracy: one for all accuracies that gave the same solution, with the least time."""
    found = [p for p in points(runs_of(study, "accuracy", family), "a_r") if not p.counted]
    for (method, _), group in itertools.groupby(found, key=lambda p: (p.run["method"], p.run["log2_points"])):
        own = list(group)
        asked = dict.fromkeys(_short(p.run["accuracy"], 0) for p in (own[0], own[-1]))
        yield f"asked {' to '.join(asked)}: {method}", min(own, key=lambda p: p.seconds)


def _short(value: float, digits: int = 1) -> str:
    """A number in a few characters."""
    return "-" if math.isnan(value) else f"{value:.{digits}e}".replace("e-0", "e-").replace("e+00", "")


def _cells(point: Point, best: Sequence[Point]) -> list[str]:
    ratio, run = over_front(point, best), point.run
    others = [math.nan if point.counted and name == "kappa" else run[f"error.{name}"] for name in MEASURES[2:]]
    return [
        _short(point.error),
        *(_short(error, 0) for error in others),
        f"{point.seconds:.2g}",
        "-" if math.isnan(ratio) else f"{ratio:.2g}" if ratio < 100 else f"{ratio:.0f}",
        "-" if run["method"] == "collocation" else f"2^{run['log2_points']:.0f}",
    ]


def _choice(point: Point) -> str:
    run = point.run
    if run["kind"] == "oracle":
        return f"collocation, {run['num_nodes']:.0f} nodes"
    words = [run["method"].replace("mass-weighted-fire", "mass-w.").replace("fire", "FIRE")]
    if run["kind"] == "choice":
        words.append(run["precision"].replace("float", "f"))
    words.append(_short(run["tolerance"], 0))
    if run["kind"] == "choice":
        words.append("nested" if run["nested"] else "1 grid")
        words += ["2 thr"] * (run["threads"] > 1)
    return " ".join(words + ["counted"] * point.counted)


def _name(axis: str, value: Any) -> str:
    """A value of an axis in words."""
    if axis == "counted":
        return "counting nodes" if value else "sub-grid edges"
    if axis == "nested":
        return "nested" if value else "one grid"
    if axis == "threads":
        return f"{value:.0f} thread{'s' * (value > 1)}"
    if axis == "tolerance.asked":
        return "float32's default tolerance" if value == "default" else f"a tolerance of {value}"
    return METHODS[value].label if value in METHODS else str(value)


def never_worth(found: Sequence[Worth]) -> Iterator[str]:
    """Sentences on the values that are on no front, and on the gain by the others."""
    never = [w for w in found if w.never]
    if never:
        texts = [f"{_name(w.axis, w.value)} (off by {w.distance:.3g}: {w.where})" for w in never]
        yield (
            f"Never worth it, because on no front in any family: {'; '.join(texts)}. In brackets the factor, in time "
            "or error, by which it misses the front that it comes nearest to."
        )
    elif found:
        yield f"Nothing is never worth it: every value is within {NEAR} of some front."
    for axis in AXES:
        for w in (w for w in found if w.axis == axis and not w.never):
            if not w.near:
                yield f"{_name(axis, w.value)}: on no front of a_r, but of {w.where}."
                continue
            lost = f"error {w.lost.error:.0e}, 2^{w.lost.run['log2_points']:.0f}, {w.lost.run['family']}"
            loss = f"no error takes more than {max(NEAR, w.loss):.2g} times as long"
            if w.loss > NEAR:
                loss = f"up to {w.loss:.2g} times as long ({lost})"
            if math.isinf(w.loss):
                loss = f"some errors are out of reach ({lost})"
            errors = [point.error for point in w.near]
            sizes = sorted({int(point.run["log2_points"]) for point in w.near})
            families = dict.fromkeys(point.run["family"] for point in w.near)
            yield (
                f"{_name(axis, w.value)}: worth it for errors of a_r from {min(errors):.0e} to {max(errors):.0e}, N = "
                f"2^{sizes[0]} to 2^{sizes[-1]}, in {len(families)} of {len(FAMILIES)} families. Without: {loss}."
            )


def published(study: StudyFile) -> Iterator[str]:
    """Sentences on the fastest choice at the published choice's error, and on the price of an area to 1e-6."""
    for family in FAMILIES:
        paper = paper_choice(study, family)
        if not paper or paper["status"] != "converged":
            continue
        error, seconds, size = paper["error.area_counted"], paper["seconds.total"], paper["log2_points"]
        rivals = {
            "--accuracy": points(runs_of(study, "accuracy", family), "a_r"),
            "by hand": points(runs_of(study, "choice", family), "a_r"),
        }
        texts = []
        for name, found in rivals.items():
            good = [p for p in front(found) if p.error <= error]
            if good:
                what = f"{name} gets there in {good[0].seconds:.2g} s, {seconds / good[0].seconds:.0f} times faster"
                texts.append(f"{what} (error {good[0].error:.0e})")
        yield (
            f"{family}: plain FIRE on 2^{size:.0f} points, counting, is off by {error:.1e} after {seconds:.3g} s; "
            f"{'; '.join(texts) or 'nothing else gets there'}."
        )
    for run in runs_of(study, "accuracy"):
        if run["accuracy"] == 1e-6 and run["status"] == "converged" and not is_rough(run["family"]):
            yield (
                f"{run['family']}: a_r asked to 1e-6, found to {run['error.area']:.0e}, takes "
                f"{run['seconds.total']:.2g} s, {run['seconds.total'] / run['seconds.pair']:.2g} transform pairs at "
                "2^18."
            )


def precisions(study: StudyFile) -> Iterator[str]:
    """Sentences on the times of the precisions."""
    for run in runs_of(study, "precisions"):
        where = f"{_name('method', run['method'])}, {run['family']}, 2^{run['log2_points']:.0f}"
        double, mixed = run["seconds.float64"], run["seconds.mixed"]
        if run["tolerance.asked"] == "iteration":
            single = run["seconds.float32"]
            yield (
                f"An iteration of {where}: float64 {double * 1e3:.3g} ms, mixed {mixed * 1e3:.3g} ms, float32 "
                f"{single * 1e3:.3g} ms; float64 takes {double / single:.2f} times as long as float32."
            )
        else:
            yield (
                f"To {run['tolerance.asked']}, {where}, nested: float64 {double:.3g} s, mixed {mixed:.3g} s, "
                f"{mixed / double:.2f} of it; {run['status']}. Pairs: "
                f"{run['pairs.float64']:.3g} and {run['pairs.mixed']:.3g}; the coarser grids, float64 in any case, "
                f"take about {run['seconds.coarser'] / double:.2f} of float64's time."
            )


def random_scenes(study: StudyFile) -> Iterator[str]:
    """Sentences on how many random scenes met the request, which did not, and how reliable estimated errors are."""
    runs = runs_of(study, "scene")
    if not runs:
        return
    solved = [run for run in runs if run["status"] != REFUSED]
    met = [run for run in solved if run["error.area"] <= run["accuracy"]]
    short = [run for run in solved if run["status"] == str(Status.INACCURATE)]
    held = [run for run in solved if run["error.area"] <= run["claimed"]]
    yield (
        f"{len(runs)} random scenes, none used for calibration: {len(met)} meet the accuracy asked for; "
        f"{len(short)} say of themselves that they fall short, "
        f"{sum(run in met for run in short)} of which met it all the same; the estimated error holds in {len(held)}."
    )
    for run in runs:
        if run not in met:
            yield f"  missed: {_scene(run)}"
    if solved:
        ratio, former = (
            float(np.median([run.get(name, math.nan) / max(run["error.area"], 1e-15) for run in solved]))
            for name in ("claimed", "claimed.former")
        )
        slow = float(np.median([run["seconds.decide"] for run in runs]))
        yield (
            f"The estimated error is {ratio:.2g} times the true one (median; by the rule of version 0.1.0, "
            f"{former:.2g}). The planner alone takes {slow * 1e6:.0f} us "
            f"(median, {max(run['seconds.decide'] for run in runs) * 1e6:.0f} us at most)."
        )


def means(study: StudyFile) -> Iterator[str]:
    """Sentences on the cost of means over random surfaces, with surfaces on one grid and on several."""
    for family in ENSEMBLES:
        rounds, alone = (runs_of(study, kind, family) for kind in (MANY, ALONE))
        if not rounds:
            continue
        last = rounds[-1]
        error, spent, finest = last["standard_error"], last["seconds.total"], last["scene.num_points"]
        plain = {run["scene.num_points"]: (run["std"] / error) ** 2 * run["seconds.total"] for run in alone}
        yield (
            f"Mean kappa of random surfaces, {family}: {last['mean']:.4f} +- {error:.1g} in {spent:.3g} s of solving, "
            f"multilevel up to 2^{math.log2(finest):.0f} points. The same error by plain sampling: "
            + ", ".join(f"{seconds:.3g} s on 2^{math.log2(size):.0f}" for size, seconds in sorted(plain.items()))
            + " points, estimated."
        )


def _scene(run: Run) -> str:
    shape = f"n = {run['scene.exponent']:.3g}" if run["family"] == "power" else f"H = {run['scene.hurst']:.2g}"
    text = (
        f"{run['family']} {run['seed']:.0f} ({shape}, d = {float(run['scene.thickness']):.2g} L, nu = "
        f"{run['scene.poisson_ratio']:.2g}, p = {run['scene.pressure']:.2g} E*): asked {run['accuracy']:.1e}, "
    )
    if run["status"] == REFUSED:
        return text + f"refused: {run['reason']}"
    return text + (
        f"off by {run['error.area']:.1e} +- {run['error.reference']:.0e}, estimated error {run['claimed']:.1e}; "
        f"{run['method']}, {run['scene.num_points']:.0f} points, {run['status']}"
    )


def not_certified(study: StudyFile) -> Iterator[str]:
    """Sentences on choices that were refused, or did not converge."""
    runs = runs_of(study, "choice")
    no = [run for run in runs if run["status"] == REFUSED]
    if no:
        yield f"{len(no)} of {len(runs)} choices by hand were refused: a tolerance below float32's level."
    for run in runs:
        if run["status"] not in (REFUSED, "converged"):
            yield (
                f"Not certified: {run['family']}, {run['method']}, {run['precision']}, tolerance "
                f"{run['tolerance.asked']}, 2^{run['log2_points']:.0f}, {'nested' if run['nested'] else 'one grid'}: "
                f"{run['status']}, residual {run['certificate.equilibrium_residual']:.1e}."
            )
    reference = max((run["error.reference"] for run in runs if is_rough(run["family"])), default=0.0)
    if reference > 0:
        size = study.configuration["reference"]
        exact = f"The rough surfaces' areas on 2^{size} points, which count as exact,"
        yield f"{exact} have an estimated error of {reference:.0e}."
    for run in (*runs_of(study, "accuracy"), *runs_of(study, "oracle")):
        if run["status"] == REFUSED:
            by_nodes = run["kind"] == "oracle"
            what = f"collocation, {run['num_nodes']} nodes" if by_nodes else f"accuracy {run['accuracy']:g}"
            yield f"Refused: {run['family']}, {what}: {run['reason']}"
