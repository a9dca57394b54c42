"""Tables that lose nothing on a narrow screen.

Columns that may not be wrapped, those of numbers, are as wide as their longest cell; the others take the rest.
Where even that is too wide, the table comes in parts below one another, each beginning with the first column.
"""

from collections.abc import Iterator, Sequence
from copy import copy

from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.measure import Measurement
from rich.table import Column, Table

_MOST = 10_000  # columns of a screen on which everything has room
_SHORTEST = 8  # columns to which a text may be wrapped, also within a word


class Whole(Table):
    """A table of Rich that cuts nothing off; numbers belong in columns with `no_wrap`."""

    def __rich_console__(self, screen: Console, options: ConsoleOptions) -> RenderResult:
        wide = options.update_width(_MOST)
        if Measurement.get(screen, wide, self).maximum <= options.max_width:
            yield from super().__rich_console__(screen, options)
            return
        for part in _parts(self, screen, options.max_width):
            yield from Table.__rich_console__(part, screen, options.update_width(max(options.max_width, _width(part))))


def _width(table: Table) -> int:
    """Columns of the screen that a table takes whose own columns all have their widths."""
    return sum(column.width or 0 for column in table.columns) + _between(table, len(table.columns))


def _between(table: Table, count: int) -> int:
    """Columns of the screen for padding and lines of so many columns of the table."""
    left, right = table.padding[3], table.padding[1]
    edges = 0 if table.pad_edge else left + right
    lines = (count - 1 + 2 * table.show_edge) if table.box else 0
    return count * (left + right) - edges + lines


def _parts(table: Table, screen: Console, width: int) -> Iterator[Table]:
    """The table in parts of which each fits if it can, its columns with their widths."""
    spans, groups = _layout(table, screen, width)
    for group in groups:
        room = width - _between(table, len(group)) - sum(spans[i].minimum for i in group)
        part = copy(table)
        part.columns, part.rows = [], []
        part.title = table.title if group is groups[0] else None
        part.caption = table.caption if group is groups[-1] else None
        for i, more in zip(group, _shared(room, [spans[i] for i in group]), strict=True):
            column = table.columns[i]
            part.add_column(column.header, justify=column.justify, overflow="fold", width=spans[i].minimum + more)
        for row, *cells in zip(table.rows, *(table.columns[i].cells for i in group), strict=True):
            part.add_row(*cells, end_section=row.end_section)
        yield part


def _layout(table: Table, screen: Console, width: int) -> tuple[list[Measurement], list[list[int]]]:
    """The widths of all columns, and the columns of each part, counted from 0; words are broken where one part is then
    enough.
    """
    whole, broken = ([_span(column, screen, shortest) for column in table.columns] for shortest in (_MOST, _SHORTEST))
    groups, fewer = (_groups(table, spans, width) for spans in (whole, broken))
    return (broken, fewer) if len(fewer) == 1 < len(groups) else (whole, groups)


def _groups(table: Table, spans: Sequence[Measurement], width: int) -> list[list[int]]:
    """The columns of each part, counted from 0, where each column has its least width."""
    groups = [[0]]
    for i in range(1, len(spans)):
        least = sum(spans[k].minimum for k in (*groups[-1], i)) + _between(table, len(groups[-1]) + 1)
        if least > width and len(groups[-1]) > 1:
            groups.append([0])
        groups[-1].append(i)
    return groups


def _span(column: Column, screen: Console, shortest: int) -> Measurement:
    """The least and the largest width that a column makes use of. shortest: to which words may be broken."""
    wide = screen.options.update_width(_MOST)
    cells: list[RenderableType] = [column.header, *column.cells]
    measured = [Measurement.get(screen, wide, cell) for cell in cells]
    longest, words = (max(values) for values in zip(*((one.maximum, one.minimum) for one in measured), strict=True))
    return Measurement(longest if column.no_wrap else min(words, shortest), longest)


def _shared(room: int, spans: Sequence[Measurement]) -> list[int]:
    """The share of each column in the room that the least widths leave: all that it can use if it can use little."""
    found = [0] * len(spans)
    order = sorted(range(len(spans)), key=lambda i: spans[i].maximum - spans[i].minimum)
    for served, i in enumerate(order):
        found[i] = min(spans[i].maximum - spans[i].minimum, max(room, 0) // (len(spans) - served))
        room -= found[i]
    return found
