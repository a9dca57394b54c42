"""Titles of figures: a scene in words, from its stored numbers, on lines that are not too wide."""

import re
from collections.abc import Collection, Mapping
from numbers import Real
from typing import Any

import numpy as np
from linecontact.solver import PowerIndenter, RoughIndenter
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from .scales import base, load, of_scene, thickness
from .style import ONE_COLUMN, kind, plain, typeset

_SIZE = 8  # points
_MOST_LETTERS = 100  # of a name that are looked at
_SHARE = 0.92  # of the figure's width: how wide a line may be, as far as widths are known
_SPECIAL = r"\\.|\$(?:\\.|[^\\$])*\$"
"""An escaped sign, or a formula."""
_WORD = re.compile(f" *(?:{_SPECIAL}|[^ ])+")
"""And the spaces before it; formulas whole."""
_WIDEST_NAME = 0.9 * 72 * ONE_COLUMN
"""Of a scan [points]."""
_NUMBERS = {"exponent": "n", "hurst": "H", "cut_off_ratio": r"\lambda_s/\lambda_r"}
_UNUSUAL = {
    "radius": ("R", PowerIndenter.radius),
    "roll_off_ratio": (r"\lambda_r/L", RoughIndenter.roll_off_ratio),
    "rms_gradient": (r"\mathrm{rms}\ h'", RoughIndenter.rms_gradient),
}
"""Numbers of an indenter with their signs; those of the second list are told where they are not the default."""
_ELSEWHERE = {"seed", "thickness", "poisson_ratio", "contact_modulus", "base_modulus"}
_ELSEWHERE |= {"base_poisson_ratio", "stiffness_rows", "pressure", "approach", "period", "num_points"}
"""Other numbers of a scene that the program knows; those that are none of all these belong to a kind of one's own."""


def put(figure: Figure, text: str) -> None:
    """Write the title of a figure; lines wider than it are broken between words.

    Matplotlib can break them, too, but takes about as long for that as for the rest of the figure.
    """
    widest = _SHARE * 72 * figure.get_figwidth()
    lines: list[str] = []
    for line in text.split("\n"):
        words = _WORD.findall(line)
        lines += words[:1] or [""]
        for word in words[1:]:
            if _width(lines[-1] + word) < widest:
                lines[-1] += word
            else:
                lines.append(word.lstrip())
    figure.suptitle("\n".join(lines), fontsize=_SIZE)


def _width(text: str) -> float:
    """About the width of a line [points]: formulas count as letters in a row, and each of their commands as one."""

    def letters(found: re.Match[str]) -> str:
        sign = found[0]
        if sign[0] == "\\":
            return sign[1]
        return re.sub(r"[${}^_]", "", re.sub(r"\\[a-z]+", "m", re.sub(r"\\mathrm|\\[^a-z]", "", sign)))

    return _plain_width(re.sub(_SPECIAL, letters, text))


def _plain_width(text: str) -> float:
    return float(text_to_path.get_text_width_height_descent(text, FontProperties(size=_SIZE), ismath=False)[0])


def _shortened(name: str) -> str:
    """The beginning of a name that is too wide for a title."""
    end = min(len(name), _MOST_LETTERS)
    while _plain_width(name[:end] + "..." * (end < len(name))) > _WIDEST_NAME:
        end -= 1
    return name[:end] + "..." * (end < len(name))


def pressed(results: Mapping[str, Any], but: Collection[str] = ()) -> str:
    """The indenter: the name of a scan, or a profile and its numbers.

    results: with `scene.` before each name. but: numbers that are left out.
    """
    if scan := str(results.get("scene.profile_file", "")):
        return plain(_shortened(scan))
    known = {name: value for name, value in of_scene(results).items() if name not in but}
    told = [f"profile: {plain(str(results['scene.profile']))}"]
    told += [f"${sign}={typeset(float(known[name]))}$" for name, sign in _NUMBERS.items() if name in known]
    for name, (sign, usual) in _UNUSUAL.items():
        if float(known.get(name, usual)) != usual:
            told.append(f"${sign}={typeset(float(known[name]))}$")
    return ", ".join([*told, *([f"seed {int(known['seed'])}"] if "seed" in known else [])])


def own(results: Mapping[str, Any], but: Collection[str] = ()) -> str:
    """The numbers of layers and indenters of one's own. results, but: as in `pressed`."""
    known = {*_NUMBERS, *_UNUSUAL, *_ELSEWHERE, *but}
    told = {name: value for name, value in of_scene(results).items() if isinstance(value, Real) and name not in known}
    return ", ".join(
        f"{plain(name.replace('_', ' '))} {value:g}"
        for name, value in told.items()
        if not name.startswith("profile_")  # which scans have
    )


def poisson(results: Mapping[str, Any]) -> str:
    """Poisson's ratio of the layer; empty where it has none."""
    ratio = results.get("scene.poisson_ratio")
    return "" if ratio is None else f"$\\nu={typeset(float(ratio), 6)}$"


def scene(results: Mapping[str, Any], but: Collection[str]) -> str:
    """A scene in a line. results: with `scene.` before each name. but: numbers that are left out."""
    told = [pressed(results, but), kind(str(results["scene.layer"]))]
    if "thickness" not in but and "scene.thickness" in results:
        told.append(_thickness(results, but))
    if "poisson_ratio" not in but:
        told.append(poisson(results))
    told.append(base(results, but))
    if not {"pressure", "approach"} & set(but):
        told.append(load(of_scene(results)))
    if "num_points" not in but:
        told.append(f"{results['scene.num_points']} points")
    told.append(own(results, but))
    return ", ".join(filter(None, told))


def _thickness(results: Mapping[str, Any], but: Collection[str]) -> str:
    """The layer's thickness, without a unit also where the period varies."""
    size = float(results["scene.thickness"])
    if "period" in but and np.isfinite(size):  # it is no scan's
        return f"$d={typeset(size)}$"
    return thickness(of_scene(results))
