"""What the title of a figure says of a scene, from its stored numbers."""

from collections.abc import Mapping
from typing import Any

from .style import plain, typeset

_LONGEST_NAME = 48  # characters of a scan's name
_NUMBERS = {"exponent": "n", "hurst": "H", "cut_off_ratio": r"\lambda_s/\lambda_r"}  # of an indenter, with their signs


def pressed(results: Mapping[str, Any], but: str = "") -> str:
    """What is pressed against the layer: the name of a scan, or a profile and its numbers, without the one named `but`.

    results: with `scene.` before each name.
    """
    if scan := plain(str(results.get("scene.profile_file", ""))):
        return scan if len(scan) <= _LONGEST_NAME else f"{scan[: _LONGEST_NAME - 4]} ..."
    told = [f"profile: {plain(str(results['scene.profile']))}"]
    for name, sign in _NUMBERS.items():
        if name != but and (key := f"scene.{name}") in results:
            told.append(f"${sign}={typeset(float(results[key]))}$")
    if but != "seed" and "scene.seed" in results:
        told.append(f"seed {int(results['scene.seed'])}")
    return ", ".join(told)


def poisson(results: Mapping[str, Any]) -> str:
    """Poisson's ratio of the layer; empty where it has none."""
    ratio = results.get("scene.poisson_ratio")
    return "" if ratio is None else f"$\\nu={typeset(float(ratio))}$"
