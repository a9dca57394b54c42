"""What identifies a task: its class's own kind and its fields, wherever its module is."""

import dataclasses
import hashlib
import importlib.util
from typing import ClassVar

import pytest
from dummy_tasks import Kills, Raises, Square
from linecontact.studies import STUDIES
from linecontact.studies.runner import study, tasks


def test_identity_is_that_of_kind_and_fields():
    assert tasks.identity(Square(1)) == tasks.identity(Square(1, 0.0, "")) == "50fa67869f842e3a"
    different = [
        Square(1),
        Square(2),
        Square(1, 0.5),
        Square(1, float("inf")),
        Raises(1),
        Kills(1),
        Kills(1, once=True),
    ]
    assert len({tasks.identity(task) for task in different}) == len(different)


def test_a_class_that_moves_keeps_its_records(tmp_path):
    """The same kind and fields under another name and in another module."""

    @dataclasses.dataclass(frozen=True)
    class Moved:
        kind: ClassVar[str] = "square"
        number: int
        pause: float = 0.0
        gate: str = ""

    folder = tasks.TaskFolder(tmp_path)
    folder.save(Square(3), {"square": 9})
    assert folder.load(Moved(3)) == {"square": 9}
    assert folder.load(Moved(4)) is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("hertz", "ea240c6573f21a2f"),
        ("rough", "9eeb3be07f4b1ec8"),
        ("iterations", "77e9dc68e00a0a21"),
        ("peers", "8913afb4c16dd64d"),
        ("tradeoff", "e7ef5831b9175d69"),
        ("extremes", "3ed69bb49e71b0e2"),
        ("soak", "30c616c43e2fbe09"),
    ],
)
def test_tasks_have_the_names_that_they_always_had(monkeypatch, name, expected):
    """Those of version 0.1.0 before its modules moved: unfinished runs of that time go on.

    But for the lines of hertz and rough: their last digits differed from machine to machine, and are rounded since. And
    tasks of kernels have the names of what they measure. The trade-off has more random scenes, and ensembles, and no
    mixed precision with the active set.
    """
    monkeypatch.setattr(importlib.util, "find_spec", lambda peer: peer == "tamaas" or None)
    (plan,) = study.find(name).plans(study.find(name).options())
    names = " ".join(tasks.identity(task) for task in plan.tasks)
    assert hashlib.sha256(names.encode()).hexdigest()[:16] == expected


def test_a_class_without_a_kind_of_its_own_is_refused():
    """An inherited one would make two classes share their records."""
    for bases in ((), (Square,)):
        made = dataclasses.make_dataclass("Made", [("number", int)], bases=bases, frozen=True)
        with pytest.raises(ValueError, match="task class Made has no kind of its own; allowed: "):
            tasks.identity(made(1))


def test_kinds_are_unique_over_all_studies():
    classes = set()
    for name in STUDIES:
        found = study.find(name)
        asked = {"quick": True} if "quick" in found.options.__dataclass_fields__ else {}
        for options in (found.options(), found.options(**asked)):
            for plan in found.plans(options):
                assert name in (plan.kind, "paper", "peers", "edge-curve")
                classes |= {type(task) for task in plan.tasks}
    kinds = [vars(task_class)["kind"] for task_class in classes]
    assert len(kinds) > 12
    assert len(set(kinds)) == len(kinds)
