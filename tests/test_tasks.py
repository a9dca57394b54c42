"""What identifies a task: its class's own kind and its fields, wherever its module is."""

import dataclasses
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
                assert name in (plan.kind, "paper")
                classes |= {type(task) for task in plan.tasks}
    kinds = [vars(task_class)["kind"] for task_class in classes]
    assert len(kinds) > 12
    assert len(set(kinds)) == len(kinds)
