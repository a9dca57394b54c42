"""The whole published study: Figures 2 to 5, and which of its statements hold.

linecontact study paper [--quick] [--folder FOLDER]
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.table import Table

from .. import blunt, hertz, rough, sharp
from ..files.hdf5 import file_kind
from ..files.study_files import StudyFile
from ..power_profiles import tasks as power_profiles
from ..rough_surfaces import tasks as rough_surfaces
from ..runner import study
from ..runner.run import run_study
from ..runner.study import Plan
from ..terminal import console
from . import markdown
from .statements import Statement, statements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_POWER_PROFILES = {"sharp": sharp.CONFIGURATION, "hertz": hertz.CONFIGURATION, "blunt": blunt.CONFIGURATION}
_STUDIES = {part.name: part for part in (sharp.STUDY, hertz.STUDY, blunt.STUDY, rough.STUDY)}


@dataclass(frozen=True)
class Options(study.Options):
    """The whole published study at 2^18 points: sharp, Hertz, blunt, rough; data, figures and a report in one folder.

    Run again after an interruption, it continues; run again when finished, it says so.
    """

    quick: bool = False
    """2^14 points and 8 realisations, in a minute."""


def plans(options: Options) -> Sequence[Plan]:
    """The plans of the four studies at full size, or quick ones."""
    return quick_plans() if options.quick else [part for s in _STUDIES.values() for part in s.plans(s.options())]


def quick_plans(num_points: int = 2**14, realisations: int = rough_surfaces.QUICK.realisations) -> Sequence[Plan]:
    """The plans of the four studies at `num_points`, with as many rough surfaces as `realisations`."""
    single = [power_profiles.plan(name, power_profiles.quick(c, num_points)) for name, c in _POWER_PROFILES.items()]
    quick = replace(
        rough_surfaces.QUICK, num_points=num_points, cut_off_ratio=512 / num_points, realisations=realisations
    )
    return [*single, rough_surfaces.plan(quick)]


def draw(path: Path) -> "dict[str, Figure]":
    """The figures of one of the four files, by the endings of their names."""
    return _STUDIES[file_kind(path)].draw(path)


def report(files: dict[str, StudyFile], folder: Path) -> Sequence[RenderableType]:
    """Write the report as a file; show its verdicts."""
    found = statements(files)
    parts = []
    for kind, file in files.items():
        captions = (rough_surfaces if kind == "rough" else power_profiles).FIGURES
        parts.append(f"## {kind}")
        parts += [f"![{kind}{ending}]({kind}{ending}.png)\n\n*{caption}*" for ending, caption in captions.items()]
        parts += [
            markdown.from_rich(part) if isinstance(part, Table) else str(part)
            for part in _STUDIES[kind].report({kind: file}, folder)
        ]
    title = "How thickness affects the area-pressure relation"
    written = markdown.write(folder, markdown.page(title, made(files), found, parts))
    return [verdicts(found), f"Report: {', '.join(map(str, written))}"]


def made(files: dict[str, StudyFile]) -> str:
    """A sentence on the origin of a report."""
    runs = [run for file in files.values() for run in file.runs]
    versions, points = (sorted({str(run[name]) for run in runs}) for name in ("version", "scene.num_points"))
    commits = sorted({str(run["provenance.commit"]) for run in runs})
    surfaces = len({run["scene.seed"] for run in files["rough"].runs}) if "rough" in files else 0
    certified = sum(run["status"] == "converged" for run in runs)
    return (
        f"{len(runs)} solves on {' and '.join(points)} points, {surfaces} rough surfaces for every point; {certified} "
        f"certified at 1e-8. linecontact {', '.join(versions)}, commit {', '.join(commits)}."
    )


def verdicts(found: Sequence[Statement]) -> Table:
    """A table of the statements, for the terminal."""
    table = console.table(
        title="The published study's statements",
        caption="All dimensionless. Remarks: see the report.",
    )
    for heading in ("statement", "published", "measured", "verdict"):
        table.add_column(heading)
    for s in found:
        table.add_row(s.text, s.published, s.measured, s.verdict)
    return table


STUDY = study.Study(name="paper", options=Options, plans=plans, report=report, draw=draw)


def command(options: Options) -> int:
    """Run the studies as asked; returns the exit status."""
    return run_study(STUDY, options)
