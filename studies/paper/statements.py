"""The published study beside the measurements: every statement that can be checked on the stored data."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.display import rounded_up
from linecontact.solver.layers.bonded import edge_shift, foundation_compliance
from linecontact.solver.reference import closed_forms

from ..files.study_files import StudyFile
from ..power_profiles import report as power_profiles
from ..rough_surfaces import means

Files = dict[str, StudyFile]
Curve = tuple[Array64, Array64, Array64]


@dataclass(frozen=True)
class Statement:
    """A statement of the published study beside the measurement; all values are dimensionless."""

    text: str
    """The statement."""
    published: str
    """The published value, with its error where it has one."""
    measured: str
    """The measured value, with its error where it has one."""
    verdict: str
    """Whether the statement holds."""
    remark: str = ""
    """Why, or another remark."""


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
            found += _power_profile(files[kind])
    if "rough" in files and files["rough"].runs:
        found += _rough(files["rough"])
    return found


def _power_profile(file: StudyFile) -> Iterator[Statement]:
    c, name = file.configuration, file.kind
    n, published = c["exponent"], c["published_alpha"]
    run, lone = power_profiles.half_space(file), closed_forms.kappa_half_space(n)
    if run:
        measured, error = run["kappa_subgrid"] / lone, run["kappa_error"] / lone
        yield Statement(
            f"{name}: kappa_d = kappa_inf(n) = {lone:.6g} on the half-space",
            "kappa_d/kappa_inf = 1",
            f"{measured:.5f} +- {rounded_up(error)}",
            judge(1.0, measured, error),
            f"The indenter's images in the neighbouring periods; with them the exact value at this load is "
            f"{run['oracle.kappa_ratio']:.5f}, at a_r = {run['oracle.contact_area']:.4f}.",
        )
    thin = {nu: _thin(file, nu) for nu in c["poisson_ratios"]}
    thin = {nu: curve for nu, curve in thin.items() if len(curve[0]) > 1}
    alphas = {nu: _alpha(n, nu, *thin[nu]) for nu in thin if nu < 0.5}
    alphas = {nu: (value, error) for nu, (value, error) in alphas.items() if error < 0.05 * value}
    if alphas:
        middle, error = sorted(alphas.values())[len(alphas) // 2]
        exact = closed_forms.thin_layer_alpha(n)
        rounding = 0.0 if math.isclose(published, exact, rel_tol=1e-12) else 0.005
        yield Statement(
            f"{name}: kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/a_r on thin layers",
            f"alpha = {published:.2f}" if rounding else f"alpha = 3 pi/4 = {published:.4f}",
            f"{middle:.4f} +- {rounded_up(error)} (median over nu)",
            judge(published, middle, error, rounding),
            f"Exactly alpha = {exact:.4f}. From the two thinnest layers, the second order divided out.",
        )
        (least, e1), (most, e2) = min(alphas.values()), max(alphas.values())
        yield Statement(
            f"{name}: Poisson's ratio enters thin layers by (1-2nu)/(1-nu)^2 only (nu < 1/2)",
            "one alpha for every nu",
            f"{least:.4f} +- {rounded_up(e1)} to {most:.4f} +- {rounded_up(e2)} for nu = {min(alphas):g} to "
            f"{max(alphas):g}",
            judge(1.0, most / least, e1 / least + e2 / most),
            "In the limit. At a finite thickness the second order depends on nu: with it the values at the thinnest "
            f"layer spread by {100 * _first_order_spread(thin, list(alphas)):.2g} %.",
        )
    yield from _powers(file, thin)


def _powers(file: StudyFile, thin: dict[float, Curve]) -> Iterator[Statement]:
    """Local powers of kappa_d in d/a_r between the two thinnest layers: the first Poisson's ratio, and 1/2."""
    c, name = file.configuration, file.kind
    n = c["exponent"]
    for nu, (t, kappa, _) in thin.items():
        power = float(np.log(kappa[1] / kappa[0]) / np.log(t[1] / t[0]))
        if nu == c["poisson_ratios"][0]:
            second = [closed_forms.thin_layer_kappa_ratio(n, nu, s, edge_shift(nu)) for s in t[:2]]
            expected = math.log(second[1] / second[0]) / math.log(t[1] / t[0])
            yield Statement(
                f"{name}: kappa_d is proportional to d/a_r on thin layers, nu = {nu:g}",
                "power 1 in the limit",
                f"power {power:.3f} at d/a_r = {t[0]:.2g} to {t[1]:.2g}",
                judge(1.0, power, abs(1 - expected)),
                f"The second order makes it {expected:.3f} there.",
            )
        if nu == 0.5:
            yield Statement(
                f"{name}: nu = 1/2",
                "left out",
                f"power {power:.3f} at d/a_r = {t[0]:.2g} to {t[1]:.2g}",
                "not part of the study",
                "The limit is (d/a_r)^3, and approached slowly.",
            )


def _thin(file: StudyFile, poisson_ratio: float) -> Curve:
    """d/a_r, kappa_d/kappa_inf and the latter's error on layers of one nu, from thin to thick."""
    part = power_profiles.layers(file).select("scene.poisson_ratio", poisson_ratio)
    part.runs = [run for run in part.runs if run["kappa_subgrid"] > 0]  # 0 for a contact of one node
    if not part.runs:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    t, kappa = power_profiles.curve(part)
    error = part.column("kappa_error") / part.column("kappa_subgrid") * kappa
    order = np.argsort(t)
    return t[order], kappa[order], error[order]


def _alpha(exponent: float, poisson_ratio: float, t: Array64, kappa: Array64, error: Array64) -> tuple[float, float]:
    """alpha and its error, from the two thinnest layers.

    The second order is divided out; the third is extrapolated like (d/a_r)^2, and the change by that is the error,
    together with the solution's own.
    """
    nu = poisson_ratio
    second = 1 + 2 * edge_shift(nu) * t[:2]
    if second.min() < 0.5:
        return math.nan, math.inf
    value = kappa[:2] / t[:2] / foundation_compliance(nu) * second ** (exponent + 1)
    r = (t[0] / t[1]) ** 2
    extrapolated = (value[0] - r * value[1]) / (1 - r)
    return float(extrapolated), float(abs(value[0] - extrapolated) + extrapolated * error[0] / kappa[0])


def _first_order_spread(thin: dict[float, Curve], poisson_ratios: list[float]) -> float:
    plain = [thin[nu][1][0] / thin[nu][0][0] / foundation_compliance(nu) for nu in poisson_ratios]
    return float(max(plain) / min(plain) - 1)


def _rough(file: StudyFile) -> Iterator[Statement]:
    nu = file.configuration["poisson_ratios"][0]
    thin = sorted(file.configuration["thicknesses"])[:2]
    layers = means.realisations(file)
    for hurst in file.configuration["hursts"]:
        halves = [means.half_space(file, hurst, name) for name in ("kappa", "kappa_subgrid")]
        if not halves[0]:
            continue
        counted, subgrid = (means.Mean.of(np.array(list(half.values()))) for half in halves)
        yield Statement(
            f"rough, H = {hurst:g}: kappa_inf on the half-space",
            f"{means.PUBLISHED_KAPPA}",
            f"{counted} counted, {subgrid} between sub-grid edges",
            judge(means.PUBLISHED_KAPPA, counted.value, counted.error, 0.005),
            "Judged as published, by counting nodes, which is biased upwards on rough surfaces.",
        )
        curves = [layers.get((hurst, nu, d), {}) for d in thin]
        seeds = sorted(set(curves[0]) & set(curves[1]))
        if seeds:
            patches = [float(np.mean([curve[seed].patches for seed in seeds])) for curve in curves]
            yield from _rough_alpha(hurst, nu, thin[0], [curves[0][seed] for seed in seeds], subgrid.value, patches[0])
            power = _rough_power(curves, seeds)
            yield Statement(
                f"rough, H = {hurst:g}: kappa_d is proportional to d/a_r on thin layers",
                "power 1",
                f"power {power} between d = {thin[0]:g} L and {thin[1]:g} L, nu = {nu:g}",
                judge(1.0, power.value, power.error),
                f"Means over all surfaces. The number of patches goes from {patches[1]:.2f} to {patches[0]:.2f}.",
            )


def _rough_alpha(
    hurst: float, nu: float, thickness: float, surfaces: list[means.Realisation], kappa_inf: float, patches: float
) -> Iterator[Statement]:
    """The thin layer's slope where one patch is left, and over all surfaces."""
    foundation = foundation_compliance(nu)
    every, alone = (np.array([r.slope / foundation for r in surfaces if r.patches <= most]) for most in (math.inf, 1))
    if alone.size:
        one = means.Mean.of(alone)
        yield Statement(
            f"rough, H = {hurst:g}: kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/a_r on thin layers",
            f"alpha = 2 pi/3 = {means.PUBLISHED_ALPHA:.3f}",
            f"{one} on the {alone.size} of {every.size} surfaces with one patch at d = {thickness:g} L, nu = {nu:g}",
            judge(means.PUBLISHED_ALPHA, one.value, one.error, 0.005),
            f"One parabolic patch has 2 sqrt(3)/kappa_inf = {means.single_patch(0.0, kappa_inf):.3f}. Over all "
            f"surfaces, with {patches:.2f} patches on the average: {means.Mean.of(every)}.",
        )


def _rough_power(curves: list[dict[int, means.Realisation]], seeds: list[int]) -> means.Mean:
    """Power between the means at two thicknesses, its error by resampling the surfaces (paired bootstrap)."""
    t, kappa = (np.array([[getattr(c[s], name) for s in seeds] for c in curves]) for name in ("reduced", "kappa_ratio"))
    draws = np.random.default_rng(0).integers(len(seeds), size=(400, len(seeds)))
    draws[0] = np.arange(len(seeds))
    powers = np.log(kappa[1][draws].mean(axis=1) / kappa[0][draws].mean(axis=1))
    powers /= np.log(t[1][draws].mean(axis=1) / t[0][draws].mean(axis=1))
    return means.Mean(float(powers[0]), float(powers.std()))
