"""The findings of the study beside those of others: every statement that can be checked on the stored data.

The earlier study is J. S. van Dokkum, M. Khajeh Salehani, N. Irani and L. Nicola, On the Proportionality Between Area
and Load in Line Contacts, Tribology Letters 66, 115 (2018).

Independent parabolic asperities, after J. A. Greenwood and J. B. P. Williamson (1966): with half-widths a that grow
like the root of an asperity's penetration, and penetrations distributed exponentially, kappa = 8/(sqrt(3) pi)
sqrt(<a> <a^3>)/<a^2> = sqrt(8/pi). That is also the slope of Persson's theory for small loads, whose p* has the
gradient of the whole surface.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from linecontact.solver.layers.bonded import edge_shift
from linecontact.solver.reference import closed_forms

from ..files.study_files import StudyFile
from ..paper.statements import Statement, judge
from ..power_profiles.tasks import RADIUS
from ..rough_surfaces.means import Mean
from .analysis import CONSTANT, Curve, Point, bending_thickness, curves, parabola

_SMALL = 0.3  # a_r up to which a contact is far from full
_NEARLY = 0.85  # a_r from which it is nearly full
_NEAR, _MOST = 0.25, 0.7  # relative distance from a parabola that counts as near, and share that must be
_THIN, _CLOSE = 0.02, 1e-3  # d/(a_r L) up to which a layer is thin, and relative error with which its law holds
_PERCENT = f"{100 * CONSTANT:g} %"
_THEORY = math.sqrt(8 / math.pi)


def findings(file: StudyFile) -> list[Statement]:
    """Every statement for which the file holds the data."""
    every = [curve for curve in curves(file) if len(curve.points) > 1]
    found: list[Statement] = []
    for curve in every:
        if curve.is_half_space:
            found += _rough_half_space(curve) if curve.rough else _profile_half_space(curve)
    layers = [curve for curve in every if not curve.is_half_space]
    found += _bent_profiles([curve for curve in layers if not curve.rough])
    for _, group in groupby(layers, key=lambda curve: (curve.rough, curve.shape)):
        own = list(group)
        found += [*_bent_roughness(own), *_as_a_parabola(own, every), *_thinnest(own)] if own[0].rough else _thin(own)
    return found


def _span(points: Sequence[Point]) -> str:
    return f"p = {points[0].pressure:g} to {points[-1].pressure:g}"


def _rough_half_space(curve: Curve) -> Iterator[Statement]:
    name = f"{curve.name}, half-space"
    far = [point for point in curve.points if point.area.value <= _SMALL]
    if len(far) > 1:
        yield _surface_gradient(name, far)
        yield _contact_gradient(name, far)
        for what, value in (
            ("Persson's theory for small loads: a_r/p*, gradient of the whole surface", far[0].kappa_surface),
            ("independent asperities with exponential heights: kappa", far[0].kappa),
        ):
            measured = f"{value} at p = {far[0].pressure:g}"
            verdict = judge(_THEORY, value.value, value.error)
            yield Statement(f"{name}, {what}", f"sqrt(8/pi) = {_THEORY:.4f}", measured, verdict)
    for point in curve.points:
        if not _NEARLY < point.area.value < 1:
            continue
        free, theory = Mean(1 - point.area.value, point.area.error), 1 - point.persson
        what = f"{name}, Persson's theory near full contact, p = {point.pressure:g}: 1 - a_r"
        yield Statement(what, f"{theory:.4f}", str(free), judge(theory, free.value, free.error))


def _surface_gradient(name: str, points: Sequence[Point]) -> Statement:
    first, last = points[0].kappa_surface, points[-1].kappa_surface
    differ = abs(first.value - last.value) > 2 * math.hypot(first.error, last.error)
    return Statement(
        f"{name}: a_r/p* with the gradient of the whole surface depends on the load",
        "it does (2018)",
        f"{first} to {last} for {_span(points)}",
        "holds" if differ else "not seen",
    )


def _contact_gradient(name: str, points: Sequence[Point]) -> Statement:
    least, most = (pick(points, key=lambda point: point.kappa.value).kappa for pick in (min, max))
    spread = most.value / least.value - 1
    return Statement(
        f"{name}: with the gradient over the contact a_r is proportional to p*",
        "it is (2018)",
        f"kappa = {least} to {most} for {_span(points)}",
        f"holds within {100 * spread:.2g} %" if spread <= CONSTANT else f"does not hold, off by {100 * spread:.2g} %",
    )


def _profile_half_space(curve: Curve) -> Iterator[Statement]:
    areas, lone = np.linspace(0.01, 0.99, 981), closed_forms.kappa_half_space(curve.shape)
    loads = [closed_forms.periodic_line_load(a / 2, lambda x: (x / RADIUS) ** (curve.shape - 1)) for a in areas]
    kappa = [closed_forms.kappa_from_area(curve.shape, a, RADIUS, p) for a, p in zip(areas, loads, strict=True)]
    bent = areas[np.flatnonzero(np.array(kappa) < lone / (1 + CONSTANT))[0]]
    error = max(abs(point.kappa.value - point.exact_kappa) / lone for point in curve.points)
    yield Statement(
        f"{curve.name}, half-space: kappa is constant to {_PERCENT}, until the images in other periods share the load",
        "no limit given",
        f"up to a_r = {bent:.2f} by the closed form, from which the solves are {error:.0e} of kappa off",
        "new",
    )


def _range(at: Sequence[float]) -> str:
    return f"d/a_r = {min(at):.3g} to {max(at):.3g} in {len(at)} cases"


def _bent_profiles(layers: Sequence[Curve]) -> Iterator[Statement]:
    """From which d/(a_r L) on a layer shows under power profiles, for every Poisson's ratio."""
    by_ratio = sorted(layers, key=lambda curve: curve.poisson_ratio)
    for nu, group in groupby(by_ratio, key=lambda curve: curve.poisson_ratio):
        at = [found for found in map(bending_thickness, group) if not math.isnan(found)]
        if len(at) > 1:
            yield Statement(
                f"power profiles, nu = {nu:g}: a layer takes {_PERCENT} off kappa at one d/a_r, whatever load and n",
                "not studied",
                _range(at),
                "new" if max(at) < 1.1 * min(at) else "does not hold",
            )


def _bent_roughness(layers: Sequence[Curve]) -> Iterator[Statement]:
    """The same for one kind of roughness."""
    at = [found for found in map(bending_thickness, layers) if not math.isnan(found)]
    if len(at) > 1:
        yield Statement(
            f"{layers[0].name}: a layer takes {_PERCENT} off kappa at one d/a_r, whatever the load",
            "as for one asperity",
            _range(at),
            "holds" if max(at) < 1.25 * min(at) else f"does not hold, it varies by a factor of {max(at) / min(at):.2g}",
        )


def _thin(layers: Sequence[Curve]) -> Iterator[Statement]:
    """The second order of thin layers under one power profile."""
    off = []
    for curve in layers:
        shift = edge_shift(curve.poisson_ratio)
        for thickness, ratio in ((point.reduced_thickness.value, point.ratio) for point in curve.points):
            if thickness <= _THIN:
                law = closed_forms.thin_layer_kappa_ratio(curve.shape, curve.poisson_ratio, thickness, shift)
                off.append(abs(ratio.value / law - 1))
    if off:
        yield Statement(
            f"{layers[0].name}: kappa of thin layers to second order, whatever the load, d/a_r up to {_THIN:g}",
            "closed form",
            f"off by {100 * max(off):.1g} % at most, {len(off)} points",
            "holds" if max(off) < _CLOSE else f"holds within {100 * max(off):.1g} %",
        )


def _as_a_parabola(layers: Sequence[Curve], every: Sequence[Curve]) -> Iterator[Statement]:
    """How far roughness on a layer is from one parabola on it, by the width of a patch or of the whole contact."""
    off: dict[str, list[float]] = {"per_width": [], "reduced_thickness": []}
    for curve in layers:
        x, ratio = parabola([c for c in every if c.poisson_ratio == curve.poisson_ratio])
        for point in (point for point in curve.points if x.size and point.area.value <= _SMALL):
            for name, found in off.items():
                width = getattr(point, name).value
                if x[0] <= width <= x[-1]:
                    expected = math.exp(float(np.interp(math.log(width), np.log(x), np.log(ratio))))
                    found.append(point.ratio.value / expected - 1)
    own, whole = (np.array(found) for found in off.values())
    if own.size and whole.size:
        near, far = (np.mean(np.abs(found) <= _NEAR) for found in (own, whole))
        yield Statement(
            f"{layers[0].name}: kappa_d/kappa_inf at one load is that of a parabola as wide as the mean patch, within "
            f"{100 * _NEAR:g} %",
            "not studied",
            f"{near:.0%} of the points with a_r up to {_SMALL:g}, at most {100 * own.min():+.0f} and "
            f"{100 * own.max():+.0f} %; {far:.0%} with a parabola as wide as all patches together",
            f"new, {near:.0%} of the points" if near >= _MOST else "does not hold",
        )


def _thinnest(layers: Sequence[Curve]) -> Iterator[Statement]:
    """How the area grows with the load on the thinnest layer."""
    curve = min(layers, key=lambda c: (c.thickness, c.poisson_ratio))
    first, second = curve.points[:2]
    width = math.log(second.pressure / first.pressure)
    power = math.log(second.area.value / first.area.value) / width
    error = math.hypot(first.area.error / first.area.value, second.area.error / second.area.value) / width
    yield Statement(
        f"{curve.name}, d = {curve.thickness:g}, nu = {curve.poisson_ratio:g}: a_r grows like p^(1/3), as under one "
        "parabola on a thin layer",
        "power 0.333 for one patch",
        f"power {Mean(power, error)} with {first.patches} and {second.patches} patches, {_span(curve.points[:2])}",
        judge(1 / 3, power, error),
    )
