"""The whole published study: Figures 2 to 5, and what holds of what it says.

python -m linecontact.studies.paper [--quick] [--folder FOLDER]
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import RenderableType
from rich.table import Table

from .. import blunt, hertz, rough, sharp
from ..files.study_files import StudyFile
from ..power_profiles import study as asperity
from ..runner import ensemble
from ..terminal import console
from . import report
from .statements import Statement, statements

_CAPTIONS = {
    "": "Symbols: this study, between sub-grid edges; solid lines: the collocation oracle, which uses no grid.",
    "-accuracy": "Errors against the oracle.",
}
_ROUGH_CAPTIONS = {
    "": "Means over the realisations, with standard errors.",
    "-patches": "Above: the slope over the number of patches; one parabolic patch has 2 sqrt(3). Below: that number.",
    "-area": "What counting nodes adds to the area.",
}


@dataclass(frozen=True)
class Options(ensemble.Options):
    """The whole published study at 2^18 points: sharp, Hertz, blunt, rough; data, figures and a report in one folder.

    Run again after an interruption, it continues; run again when finished, it says so.
    """

    quick: bool = False
    """2^14 points and 8 realisations, in a minute."""


def studies(num_points: int | None = None, realisations: int = rough.QUICK.realisations) -> list[ensemble.Study]:
    """The four studies at full size, or quick ones at `num_points` with so many rough surfaces."""
    modules = {"sharp": sharp, "hertz": hertz, "blunt": blunt}
    if num_points is None:
        single = [asperity.study(kind, module.CONFIGURATION) for kind, module in modules.items()]
        return [*single, rough.study(rough.Configuration())]
    quick = [asperity.study(kind, asperity.quick(m.CONFIGURATION, num_points)) for kind, m in modules.items()]
    surfaces = replace(rough.QUICK, num_points=num_points, cut_off_ratio=512 / num_points, realisations=realisations)
    return [*quick, rough.study(surfaces)]


def command(options: Options) -> int:
    """Run the studies as asked; returns the exit status."""
    folder = Path("results/paper-quick" if options.quick else "results/paper")
    return ensemble.command(studies(2**14 if options.quick else None), options, folder, closing)


def closing(files: dict[str, StudyFile], folder: Path) -> Sequence[RenderableType]:
    """Write the report; show its verdicts."""
    found = statements(files)
    parts = []
    for kind, file in files.items():
        module, captions = (rough, _ROUGH_CAPTIONS) if kind == "rough" else (asperity, _CAPTIONS)
        parts.append(f"## {kind}")
        parts += [f"![{kind}{suffix}]({kind}{suffix}.png)\n\n*{caption}*" for suffix, caption in captions.items()]
        parts += [
            report.from_rich(part) if isinstance(part, Table) else str(part)
            for part in module.closing({kind: file}, folder)
        ]
    title = "How thickness affects the area-pressure relation"
    written = report.write(folder, report.markdown(title, made(files), found, parts))
    return [verdicts(found), f"Report: {', '.join(map(str, written))}"]


def made(files: dict[str, StudyFile]) -> str:
    """What a report was made from."""
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
    """The statements on the terminal."""
    table = console.table(
        title="The published study's statements",
        caption="All dimensionless. Remarks: see the report.",
    )
    for heading in ("statement", "published", "measured", "verdict"):
        table.add_column(heading)
    for s in found:
        table.add_row(s.text, s.published, s.measured, s.verdict)
    return table


if __name__ == "__main__":
    sys.exit(console.run(Options, command, "python -m linecontact.studies.paper"))
