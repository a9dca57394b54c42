"""Sphinx: these pages as a site, which takes nothing from elsewhere when it is read.

sphinx-build -W docs docs/build
"""

import re
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math import latex2mathml
from linecontact import __version__

sys.path.append(str(Path(__file__).parent))
import fill_in

project, author, release = "linecontact", "the linecontact developers", __version__
copyright = author
extensions = ["myst_nb"]
nb_execution_mode, nb_execution_timeout, nb_execution_raise_on_error = "force", 120, True
exclude_patterns = ["build"]
html_theme, html_title = "furo", f"linecontact {release}"
html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3


def _formula(text: str, block: bool) -> str:
    made: str = latex2mathml.tex2mathml(text, as_block=block)
    # long ones scroll sideways; the theme's bar for up and down would be there always
    return made.replace("<math ", '<math style="overflow-y: hidden; padding: 0.3em 0" ', 1)


def _inline(self, node: nodes.math) -> None:  # type: ignore[no-untyped-def]
    self.body.append(_formula(node.astext(), block=False))
    raise nodes.SkipNode


def _block(self, node: nodes.math_block) -> None:  # type: ignore[no-untyped-def]
    self.body.append(f"<div>{_formula(node.astext(), block=True)}</div>")
    raise nodes.SkipNode


def _for_the_site(app, page, content: list[str]) -> None:  # type: ignore[no-untyped-def]
    """Help texts and names are made now. Markdown files elsewhere in the repository are not pages of the site: links to
    them give the file.
    """
    content[0] = fill_in.made(content[0])
    content[0] = re.sub(r"\]\((\.\./[^)#]+\.md)\)", r"](path:\1)", content[0])


def setup(app) -> None:  # type: ignore[no-untyped-def]
    """Formulas as MathML, which browsers draw themselves."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("source-read", _for_the_site)
