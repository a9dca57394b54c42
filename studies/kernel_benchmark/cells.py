"""The repetitions of a measurement as one, with their scatter."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from ..files.study_files import StudyFile
from .benchmark import Benchmark
from .benchmarks import BENCHMARKS

Run = dict[str, Any]

MACHINE = "machine"
"""Stands for a benchmark in the record of the machine itself."""

GROUPED = ("kernels", "sequences", "iterations")
"""Groups that are measured beside C."""

_SHIPPED = ("warp", "c", "element", "numpy", "copy", "roof", "transforms")  # variants of these groups

INTERVAL = 0.95
"""Probability of the intervals that are shown."""


class Key(NamedTuple):
    """The measurement."""

    benchmark: str
    """Its name."""
    precision: str
    """Of the values per point."""
    num_points: int
    """Number of points."""


@dataclass
class Cell:
    """All repetitions of one measurement."""

    key: Key
    """The measurement."""
    runs: list[Run]
    """Its records, one for every repetition."""

    @property
    def benchmark(self) -> Benchmark:
        """Its entry in the list."""
        return BENCHMARKS[self.key.benchmark]

    @property
    def variants(self) -> list[str]:
        """Names of the timed variants."""
        found = dict.fromkeys(n for run in self.runs for n in run if n.startswith("seconds."))
        names = (name.removeprefix("seconds.") for name in found)
        return [name for name in names if "." not in name and self.seconds(name) > 0]

    def value(self, name: str) -> float:
        """Median of a quantity over the repetitions that have it; NaN where none has."""
        values = [v for run in self.runs if not math.isnan(v := float(run.get(name, math.nan)))]
        return float(np.median(values)) if values else math.nan

    def seconds(self, variant: str) -> float:
        """Time of a call [s]; NaN where it was not measured."""
        return self.value(f"seconds.{variant}")

    def logs(self, variant: str) -> list[float]:
        """Logarithms of the ratios to the yardstick, one for each repetition."""
        ratios = (float(run.get(f"ratio.{variant}", math.nan)) for run in self.runs)
        return [math.log(ratio) for ratio in ratios if ratio > 0]

    def ratio(self, variant: str) -> float:
        """Time over the yardstick's in the same round, geometric mean over the repetitions; NaN without."""
        logs = self.logs(variant)
        return math.exp(float(np.mean(logs))) if logs else math.nan

    def bandwidth(self, variant: str) -> float:
        """Bytes read and written in a second [1e9 byte/s]."""
        return self.value("bytes.traffic") / self.seconds(variant) / 1e9


def cells(runs: Iterable[Run]) -> dict[Key, Cell]:
    """Records put together by measurement, in their order."""
    found: dict[Key, Cell] = {}
    for run in runs:
        if run["benchmark"] in BENCHMARKS:
            key = Key(run["benchmark"], run["precision"], int(run["num_points"]))
            found.setdefault(key, Cell(key, [])).runs.append(run)
    return found


def own_names(found: Iterable[Cell]) -> list[str]:
    """Names of users' variants in measurements beside C, each once."""
    return list(dict.fromkeys(v for cell in found for v in cell.variants if v not in _SHIPPED))


def machine(study: StudyFile) -> Run:
    """The record of the machine; empty if there is none."""
    return next((run for run in study.runs if run["benchmark"] == MACHINE), {})


class Scatter:
    """How much logarithms of ratios scatter from one repetition to the next, by number of points.

    Few repetitions tell little of their own scatter, so that of all measurements of a size is the least that any of
    them is taken to have: the variance of which the median of theirs is the median.
    """

    def __init__(self, found: Iterable[Cell], variant: str) -> None:
        squares: dict[int, list[float]] = {}
        self._freedom: dict[int, int] = {}
        for cell in found:
            logs, size = cell.logs(variant), cell.key.num_points
            if len(logs) > 1:
                expected = (1 - 2 / (9 * (len(logs) - 1))) ** 3  # median of chi square over its degrees of freedom
                squares.setdefault(size, []).append(float(np.var(logs, ddof=1)) / expected)
                self._freedom[size] = self._freedom.get(size, 0) + len(logs) - 1
        self._pooled = {size: float(np.median(values)) for size, values in squares.items()}

    def freedom(self, cell: Cell) -> int:
        """Degrees of freedom of the scatter."""
        return self._freedom.get(cell.key.num_points, 1)

    def error(self, cell: Cell, variant: str) -> float:
        """Standard error of the mean logarithm of a ratio; NaN for a single repetition."""
        logs = cell.logs(variant)
        if len(logs) < 2:
            return math.nan
        variance = max(float(np.var(logs, ddof=1)), self._pooled.get(cell.key.num_points, 0.0))
        return math.sqrt(variance / len(logs))

    def half_width(self, cell: Cell, variant: str) -> float:
        """Half the width of the interval of a ratio."""
        return cell.ratio(variant) * quantile((1 + INTERVAL) / 2, self.freedom(cell)) * self.error(cell, variant)


def quantile(probability: float, freedom: int) -> float:
    """Quantile of Student's t, by its expansion in the degrees of freedom (Abramowitz and Stegun, 26.7.5)."""
    z = NormalDist().inv_cdf(probability)
    first, second = (z**3 + z) / 4, (5 * z**5 + 16 * z**3 + 3 * z) / 96
    return z + first / freedom + second / freedom**2
