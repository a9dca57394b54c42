"""The report of the whole paper: Markdown, and one HTML page that holds its figures."""

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from rich.table import Table

from .. import PUBLISHED
from ..files import writing
from . import formulas
from .statements import Statement

_LONG = 40
"""Characters of a cell, above which a table is restacked on a phone, not scrolled."""

_STYLE = """
body { max-width: 60em; margin: 2em auto; padding: 0 1em; font: 16px/1.5 system-ui, sans-serif; color: #222; }
img { max-width: 100%; }
div { overflow-x: auto; }
table { border-collapse: collapse; font-size: 14px; margin: 1em 0; }
th, td { border-bottom: 1px solid #ccc; padding: 0.25em 0.6em; text-align: left; vertical-align: top; }
h1, h2 { line-height: 1.2; }
math { font-size: 110%; }
@media (max-width: 40em) {
  body { margin: 1em auto; padding: 0 0.6em; }
  th, td { padding: 0.2em 0.3em; }
  table { font-size: 12px; }
  table.long { font-size: 15px; }
  .long, .long tbody, .long tr, .long td { display: block; }
  .long thead { display: none; }
  .long tr { border-top: 2px solid #222; padding: 0.4em 0; }
  .long td { border: 0; padding: 0.1em 0; }
  .long td:empty { display: none; }
  .long td::before { content: attr(data-label) ": "; color: #555; }
  .long td:first-child { font-weight: bold; }
  .long td:first-child::before { content: none; }
}
"""


def table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [list(headings), ["---"] * len(headings), *rows]
    cells = [[cell.replace("\n", " ").replace("|", "\\|") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def from_rich(source: Table) -> str:
    """The Markdown of a table that the terminal shows, title and caption included."""
    columns = [[str(cell) for cell in column.cells] for column in source.columns]
    headings = [str(column.header).replace("-\n", "-") for column in source.columns]
    body = table(headings, list(zip(*columns, strict=True)))
    title, caption = (str(text or "").replace("*", "\\*") for text in (source.title, source.caption))
    return f"**{title}**\n\n{body}\n\n{caption}"


_RULE = (
    "All values are dimensionless unless a unit is given. After +-: for single profiles an estimate of the error, for "
    "rough surfaces the standard error over the surfaces. A statement *holds* if the measured value is within two such "
    "errors, and half of the last digit published, of the published one; it *holds within x* up to 5 %; else it "
    "does not hold."
)


def page(title: str, made: str, statements: Sequence[Statement], parts: Sequence[str]) -> str:
    """The report in Markdown: first the published statements and the measurements, then the studies one by one.

    made: a sentence on the origin of the report. parts: Markdown of the studies.
    """
    rows = [(s.text, s.published, s.measured, f"**{s.verdict}**", s.remark) for s in statements]
    head = table(("statement", "published", "measured", "verdict", "remark"), rows)
    source = f"Published: {PUBLISHED}."
    return "\n\n".join([f"# {title}", made, source, _RULE, head, *parts]) + "\n"


def _html(text: str) -> str:
    """The HTML of Markdown: formulas typeset, tables that a narrow page scrolls or, where cells are long, restacks."""
    reader = MarkdownIt("commonmark").enable("table")
    reader.add_render_rule("text", lambda _, tokens, place, *more: formulas.typeset(tokens[place].content))
    reader.add_render_rule("table_open", _open_table)
    reader.add_render_rule("table_close", lambda *_: "</table></div>\n")
    tokens = reader.parse(text)
    table, headings, column, longest = tokens[0], [""], 0, 0
    for token, content in zip(tokens, [*tokens[1:], tokens[-1]], strict=True):
        if token.type == "table_open":
            table, headings, longest = token, [], 0
        elif token.type == "th_open":
            headings.append(content.content)
        elif token.type == "tr_open":
            column = 0
        elif token.type == "td_open":
            token.attrSet("data-label", headings[column])
            column, longest = column + 1, max(longest, len(content.content))
            if longest > _LONG:
                table.attrSet("class", "long")
    return str(reader.renderer.render(tokens, reader.options, {}))


def _open_table(renderer: RendererHTML, tokens: Sequence[Token], place: int, *_: Any) -> str:
    return f"<div><table{renderer.renderAttrs(tokens[place])}>\n"


def write(folder: Path, text: str) -> tuple[Path, Path]:
    """Write report.md and report.html beside the figures that the text shows, unless they are there already."""
    shown = _html(text)
    title = text.partition("\n")[0].lstrip("# ")
    for image in folder.glob("*.png"):
        data = base64.b64encode(image.read_bytes()).decode()
        shown = shown.replace(f'src="{image.name}"', f'src="data:image/png;base64,{data}"')
    shown = (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{title}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{shown}</body>\n</html>\n"
    )
    files = folder / "report.md", folder / "report.html"
    for file, content in zip(files, (text.encode(), shown.encode()), strict=True):
        if not file.is_file() or file.read_bytes() != content:
            writing.write_bytes(file, [content])
    return files
