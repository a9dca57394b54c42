"""The form of a study, once, in words and types; and how a study is found by its name.

A study's module holds its instance of `Study` as `STUDY`, the class of its options as `Options`, and
`command(options) -> int`, which runs it, most often by `run.run_study`. Its line in `linecontact.studies.STUDIES` is
all that the rest of the program needs to know of it.
"""

import importlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linecontact.solver import checks
from rich.console import RenderableType

from .. import STUDIES
from ..files.study_files import StudyFile
from . import executors
from .tasks import ROWS, Record, Task, identity

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Options:
    """The options of every study."""

    folder: Path | None = None
    """Where data and figures go; default: results/ and the study's name."""
    workers: int = executors.usable_cores()
    """Processes of one thread each, 1 to 1024; with 1 everything happens in this one. Default: the usable cores."""
    memory: float | None = None
    """Budget of each worker process [GiB]; default: the memory that is free at the start, shared."""
    scheduler: str | None = None
    """Address of a Dask scheduler, like tcp://host:8786, whose workers do the tasks; `workers` has no effect then."""
    overwrite: bool = False
    """Start anew even if there are results, and replace any file that has the name of a figure."""


@dataclass(frozen=True)
class Plan:
    """The tasks whose records make one file, as a study plans them for the user's options."""

    kind: str
    """Name of the study that draws the file, and of the file."""
    configuration: dict[str, Any]
    """The choices of the user, fit for JSON."""
    runs: Sequence[Task]
    """Tasks whose records are the rows of the file."""
    lines: Mapping[str, Task] = field(default_factory=dict)
    """Tasks that make reference curves, by the curve's name; their records are columns."""
    figures: Collection[str] = ("",)
    """Endings of the names of the file's figures; none for a file that is not drawn."""
    adjustable: Collection[str] = ()
    """Names in the configuration that may be others when the study goes on."""
    enough: Callable[[StudyFile], bool] | None = None
    """Whether a complete file of other adjustable values holds all that is asked for now; None: never."""
    more: Callable[[Mapping[Task, Record]], Sequence[Task]] | None = None
    """Further tasks, from the records of all so far; none when there are enough. For a study that decides on the way.
    """
    outlook: Callable[[Mapping[Task, Record]], tuple[float, str]] | None = None
    """From the same records the share of the work that is done, 0 to 1, and the state. For such a study, too."""
    num_points: int = 0
    """Points of the largest grid of the tasks, for which there must be memory; 0: not known."""

    @property
    def tasks(self) -> list[Task]:
        """Everything there is to do."""
        return [*self.lines.values(), *self.runs]

    def further(self, records: Mapping[Task, Record]) -> list[Task]:
        """Tasks that are to follow those of the plan, from their records."""
        if not self.more:
            return []
        planned = set(self.runs)
        found = self.more({task: records[task] for task in self.runs if task in records})
        return [task for task in dict.fromkeys(found) if task not in planned]

    def path(self, folder: Path) -> Path:
        """The file."""
        return folder / f"{self.kind}.h5"

    def collect(self, records: Mapping[Task, Record], failures: Mapping[Task, str]) -> StudyFile:
        """The file's contents as far as the tasks are done."""
        own = set(self.tasks)
        return StudyFile(
            kind=self.kind,
            configuration=self.configuration,
            runs=[row | {"task": identity(task)} for task in self.runs for row in _rows(records.get(task))],
            lines={name: records[task] for name, task in self.lines.items() if task in records},
            failures={identity(task): reason for task, reason in failures.items() if task in own},
            complete=own <= records.keys() and not self.further(records),
        )


def _rows(record: Record | None) -> Sequence[Record]:
    """The rows of a task in a file: its record, or several that this holds as 'rows'; none without a record."""
    return () if record is None else record.get(ROWS, (record,))


def _none(_: StudyFile) -> Sequence[str]:
    return ()


_REQUIRED: Any = None  # the default of members that a study must have: a study without it is refused in plain words


@dataclass(frozen=True, kw_only=True)
class Study:
    """The members of a study. Raises `ValueError` for a study without a required one, which it names."""

    name: str = _REQUIRED
    """On the command line, and of the folder that its results go to."""
    options: type[Options] = _REQUIRED
    """The options of the user: a frozen dataclass. Its docstring is the help text of the command, and so are those
    of its fields. With a field `quick` that is true, the default folder ends in -quick."""
    plans: Callable[[Any], Sequence[Plan]] = _REQUIRED
    """From the options to the tasks: one plan for each file. Raises `ValueError` for options that make no sense."""
    report: Callable[[dict[str, StudyFile], Path], Sequence[RenderableType]] = _REQUIRED
    """From the stored files, by kind, and their folder to the output at the end: tables and sentences."""
    draw: Callable[[Path], "dict[str, Figure]"] = _REQUIRED
    """From a stored file to its figures, by the endings of their names. It imports matplotlib when it is called."""
    defects: Callable[[StudyFile], Sequence[str]] = _none
    """Defects in a stored file, a line each; any of them makes the exit status that of a failed task."""
    missed: Callable[[StudyFile], Sequence[str]] = _none
    """Why a stored file is less than was asked for, with the allowed values, a line each; any of them makes
    the exit status that of a run less accurate than asked."""
    may_not_converge: bool = False
    """Whether a run that does not converge is a result like any other, and the exit status 0 all the same."""

    def __post_init__(self) -> None:
        required = [f.name for f in fields(self) if f.default is _REQUIRED]
        missing = [name for name in required if getattr(self, name) is None]
        if missing:
            raise ValueError(
                f"study {self.name!r} does not offer {', '.join(missing)}; allowed: a study with {', '.join(required)}"
            )
        for name in ("plans", "report", "draw"):
            if not callable(getattr(self, name)):
                raise checks.refusal(f"{name} of study {self.name}", getattr(self, name), "a function")
        if not (isinstance(self.options, type) and issubclass(self.options, Options)):
            raise checks.refusal(f"options of study {self.name}", self.options, "a subclass of `Options`")

    def planned(self, options: Options) -> Sequence[Plan]:
        """The tasks. Raises `ValueError` if the study gives something else, or none."""
        plans = self.plans(options)
        if not isinstance(plans, Sequence) or not plans or not all(isinstance(plan, Plan) for plan in plans):
            raise checks.refusal(f"result of plans of study {self.name}", plans, "one `Plan` or more, in a list")
        return plans

    def check_report(self, parts: object) -> None:
        """Raise `ValueError` if these are no parts of a report."""
        if isinstance(parts, str) or not isinstance(parts, Sequence):
            raise checks.refusal(f"result of report of study {self.name}", parts, "tables and texts, in a list")

    def folder(self, options: Options) -> Path:
        """Where the results go."""
        quick = "-quick" if getattr(options, "quick", False) else ""
        return options.folder or Path("results") / f"{self.name}{quick}"


def find(name: str) -> Study:
    """The study of this name in the list. Raises `ValueError` if there is none, or its module does not offer it."""
    if name not in STUDIES:
        raise ValueError(f"study is {name!r}; allowed: {', '.join(STUDIES)}")
    module = importlib.import_module(STUDIES[name])
    missing = [what for what in ("STUDY", "Options", "command") if not hasattr(module, what)]
    if missing:
        raise ValueError(
            f"study {name}: module {STUDIES[name]} does not offer {', '.join(missing)}; allowed: a module with STUDY, "
            "Options and command"
        )
    if not isinstance(module.STUDY, Study):
        raise checks.refusal(f"study {name}: STUDY of module {STUDIES[name]}", module.STUDY, "a `Study`")
    return module.STUDY
