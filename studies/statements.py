"""What the published study says, beside what was measured: every statement that can be checked on the stored data."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from linecontact.solver import closed_forms

from . import asperity, rough, store

Files = dict[str, store.StudyFile]


@dataclass(frozen=True)
class Statement:
    """text: what is said; published, measured: with errors where they have any; verdict: what comes of it; remark: why.

    All values are dimensionless.
    """

    text: str
    published: str
    measured: str
    verdict: str
    remark: str = ""


def judge(published: float, measured: float, error: float, rounding: float = 0.0) -> str:
    """'holds' within two errors and the published value's rounding, 'holds within x' up to 5 %, or 'does not hold'."""
    off = abs(measured - published)
    if not math.isfinite(off):
        return "not measured"
    if off <= 2 * error + rounding:
        return "holds"
    percent = 100 * off / abs(published)
    return f"holds within {percent:.2g} %" if percent <= 5 else f"does not hold, off by {percent:.3g} %"


def statements(files: Files) -> list[Statement]:
    """Every statement for which the files hold the data."""
    found: list[Statement] = []
    for kind in ("hertz", "sharp", "blunt"):
        if kind in files and files[kind].runs:
            found += _asperity(files[kind])
    if "rough" in files and files["rough"].runs:
        found += _rough(files["rough"])
    return found


def _asperity(file: store.StudyFile) -> Iterator[Statement]:
    c, name = file.configuration, file.kind
    n, published = c["exponent"], c["published_alpha"]
    run, lone = asperity.half_space(file), closed_forms.kappa_half_space(n)
    if run:
        measured, error = run["kappa_subgrid"] / lone, run["kappa_error"] / lone
        yield Statement(
            f"{name}: kappa_d = kappa_inf(n) = {lone:.6g} on the half-space",
            "kappa_d/kappa_inf = 1",
            f"{measured:.5f} +- {error:.0g}",
            judge(1.0, measured, error),
            f"The indenter's images in the neighbouring periods; with them the exact value at this load is "
            f"{run['oracle.kappa_ratio']:.5f}, at a_r = {run['oracle.contact_area']:.4f}.",
        )
    alphas = {nu: alpha for nu in c["poisson_ratios"] if nu < 0.5 and (alpha := _alpha(file, nu))}
    if alphas:
        values = np.array([value for value, _ in alphas.values()])
        middle, exact = float(np.median(values)), closed_forms.thin_layer_alpha(n)
        error = max(float(np.median(np.abs(values - middle))), float(np.median([e for _, e in alphas.values()])))
        yield Statement(
            f"{name}: kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/a_r on thin layers",
            f"alpha = {published:.4g}",
            f"{middle:.4f} +- {error:.1g} (median over nu)",
            judge(published, middle, error, 0.0 if published == exact else 0.005),
            f"Exactly alpha = {exact:.4f}. Measured at the thinnest layer, its second order divided out.",
        )
        yield Statement(
            f"{name}: Poisson's ratio enters thin layers by (1-2nu)/(1-nu)^2 only (nu < 1/2)",
            "one alpha for every nu",
            f"{values.min():.4f} to {values.max():.4f} for nu = {min(alphas):g} to {max(alphas):g}",
            judge(1.0, values.max() / values.min(), error / middle),
            "To first order. At finite d/a_r the second order depends on nu: without it the values spread "
            f"by {100 * _first_order_spread(file, list(alphas)):.2g} %.",
        )
    for nu in c["poisson_ratios"]:
        if nu in (c["poisson_ratios"][0], 0.5) and (power := _power(file, nu)):
            yield Statement(
                f"{name}: kappa_d is proportional to d/a_r on thin layers, nu = {nu:g}",
                "power 1",
                f"power {power:.3f}",
                judge(1.0, power, 0.0),
                "Between the two thinnest layers."
                if nu < 0.5
                else "The published study leaves nu = 1/2 out: the limit is (d/a_r)^3, and approached slowly.",
            )


def _thin(file: store.StudyFile, poisson_ratio: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """d/a_r, kappa_d/kappa_inf and the latter's error on layers of one nu, from thin to thick."""
    part = asperity.layers(file).select("scene.poisson_ratio", poisson_ratio)
    if not part.runs:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    t, kappa = asperity.curve(part)
    error = part.column("kappa_error") / part.column("kappa_subgrid") * kappa
    order = np.argsort(t)
    return t[order], kappa[order], error[order]


def _alpha(file: store.StudyFile, poisson_ratio: float) -> tuple[float, float] | None:
    """alpha from the thinnest layer with the second order divided out, and its error: the solution's and the next
    order's, taken as the square of half the second. None where the second order is no small correction.
    """
    t, kappa, error = _thin(file, poisson_ratio)
    nu, n = poisson_ratio, file.configuration["exponent"]
    if not t.size:
        return None
    second = 2 * closed_forms.edge_shift(nu) * t[0]
    if abs((n + 1) * second) > 0.25:
        return None
    value = kappa[0] / t[0] / ((1 - 2 * nu) / (1 - nu) ** 2) * (1 + second) ** (n + 1)
    return float(value), float(value * (error[0] / kappa[0] + ((n + 1) * second) ** 2 / 4))


def _first_order_spread(file: store.StudyFile, poisson_ratios: list[float]) -> float:
    plain = []
    for nu in poisson_ratios:
        t, kappa, _ = _thin(file, nu)
        plain.append(kappa[0] / t[0] / ((1 - 2 * nu) / (1 - nu) ** 2))
    return float(max(plain) / min(plain) - 1)


def _power(file: store.StudyFile, poisson_ratio: float) -> float:
    """Local power of kappa_d in d/a_r between the two thinnest layers; 0 where there are not two."""
    t, kappa, _ = _thin(file, poisson_ratio)
    return float(np.log(kappa[1] / kappa[0]) / np.log(t[1] / t[0])) if t.size > 1 else 0.0


def _rough(file: store.StudyFile) -> Iterator[Statement]:
    points = list(rough.points(file))
    for hurst in file.configuration["hursts"]:
        counted, subgrid = (
            rough.Mean.of(np.array(list(rough.half_space(file, hurst, name).values())))
            for name in ("kappa", "kappa_subgrid")
        )
        yield Statement(
            f"rough, H = {hurst:g}: kappa_inf on the half-space",
            f"{rough.PUBLISHED_KAPPA}",
            f"{counted} counted, {subgrid} between sub-grid edges",
            judge(rough.PUBLISHED_KAPPA, counted.value, counted.error, 0.005),
            "Judged as published, by counting nodes, which is biased upwards on rough surfaces.",
        )
        own = [p for p in points if p.hurst == hurst and p.poisson_ratio < 0.5]
        if not own:
            continue
        least = min(p.thickness for p in own)
        thin = [p for p in own if p.thickness == least]
        foundation = [(1 - 2 * p.poisson_ratio) / (1 - p.poisson_ratio) ** 2 for p in thin]
        values = np.array([p.slope.value / f for p, f in zip(thin, foundation, strict=True)])
        error = max(p.slope.error / f for p, f in zip(thin, foundation, strict=True))
        single = rough.single_patch(0.0, subgrid.value)
        patches = max(p.patches.value for p in thin)
        yield Statement(
            f"rough, H = {hurst:g}: kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/a_r on thin layers",
            f"alpha = 2 pi/3 = {rough.PUBLISHED_ALPHA:.3f}",
            f"{values.mean():.3f} +- {error:.1g} at d = {least:g} L (mean over nu)",
            judge(rough.PUBLISHED_ALPHA, float(values.mean()), error),
            f"One parabolic patch has 2 sqrt(3)/kappa_inf = {single:.3f}; at this thickness at most {patches:.2f} "
            "patches are left on the average. With more of them the slope is larger.",
        )
        first = [p for p in own if p.poisson_ratio == thin[0].poisson_ratio]
        first.sort(key=lambda p: p.thickness)
        if len(first) > 1:
            a, b = first[0], first[1]
            power = math.log(b.kappa_ratio.value / a.kappa_ratio.value) / math.log(
                b.reduced_thickness.value / a.reduced_thickness.value
            )
            yield Statement(
                f"rough, H = {hurst:g}: kappa_d is proportional to d/a_r on thin layers",
                "power 1",
                f"power {power:.3f}",
                judge(1.0, power, 0.0),
                f"Means at the two thinnest layers, nu = {a.poisson_ratio:g}; the number of patches goes from "
                f"{b.patches.value:.2f} to {a.patches.value:.2f}.",
            )
