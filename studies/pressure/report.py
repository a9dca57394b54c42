"""The report of the study pressure: for every shape a table, and which statements hold."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from rich.console import RenderableType
from rich.table import Table

from ..files.study_files import StudyFile
from ..rough_surfaces.means import Mean
from ..terminal import console
from .analysis import CONSTANT, Curve, curves
from .findings import findings

_SHOWN = 3  # loads of a curve in the table


def summary(own: Sequence[Curve]) -> Table:
    """The table of one shape: a row for each layer."""
    rough = own[0].rough
    most = max((curve.points for curve in own), key=len)
    chosen = list(dict.fromkeys(most[round(i * (len(most) - 1) / (_SHOWN - 1))].pressure for i in range(_SHOWN)))
    table = console.table(
        title=f"{'rough surface' if rough else 'power profile'}, {own[0].name}: kappa over the load",
        caption="p over E*, d over L; kappa = a_r/p* with the gradient over the contact, between sub-grid edges"
        + (", mean over the surfaces, in brackets the standard error of its last digits" if rough else "")
        + f"; constant: the longest run of loads within which kappa changes by {100 * CONSTANT:g} % at most. "
        "All dimensionless.",
    )
    for heading in ("d", "nu", *(f"p =\n{p:.2g}" for p in chosen), "constant\nfor p"):
        table.add_column(heading, justify="right", no_wrap=True)
    for curve in own:
        at = {point.pressure: point.kappa for point in curve.points}
        cells = [(_short(at[p]) if rough else f"{at[p].value:.4f}") if p in at else "" for p in chosen]
        layer = ("half-space", "-") if curve.is_half_space else (f"{curve.thickness:g}", f"{curve.poisson_ratio:g}")
        flat = curve.constant
        where = f"{flat[0].pressure:.2g} to {flat[-1].pressure:.2g}" if len(flat) > 1 else "none"
        table.add_row(*layer, *cells, where)
    return table


def _short(mean: Mean) -> str:
    """A mean with its standard error in brackets: 1.6980(20) is 1.6980 +- 0.0020."""
    if not mean.error > 0:
        return f"{mean.value:.4g}"
    value, error = str(mean).split(" +- ")
    return f"{value}({error.replace('.', '').lstrip('0')})"


def said(file: StudyFile) -> Table:
    """The findings beside those of others."""
    table = console.table(
        title="What holds",
        caption="p over E*, d over L; kappa = a_r/p*; after +-: standard errors. All dimensionless. (2018): J. S. van "
        "Dokkum et al., Tribology Letters 66, 115.",
    )
    for heading in ("statement", "said", "measured", "verdict"):
        table.add_column(heading)
    for found in findings(file):
        table.add_row(found.text, found.published, found.measured, found.verdict)
    return table


def report(files: dict[str, StudyFile], _: Path) -> Sequence[RenderableType]:
    """For every shape a table, and a table of findings."""
    tables: list[RenderableType] = []
    for file in files.values():
        grouped = groupby(curves(file), key=lambda curve: (curve.rough, curve.shape))
        tables += [summary(list(own)) for _, own in grouped]
        tables.append(said(file))
    return tables
