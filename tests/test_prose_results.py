"""What the pages say in words of stored results: every sentence here is composed from these, and must stand in the
page, so a number that changes finds the sentences that it makes wrong."""

import math
import re
from collections import defaultdict

import numpy as np
import pytest
from linecontact.solver import RoughIndenter, Scene, solve
from linecontact.solver.calibration import FITTED
from linecontact.solver.grid import errors
from linecontact.solver.strategy import small_models
from linecontact.studies.multilevel import allocation
from linecontact.studies.paper import statements
from linecontact.studies.peers import areas
from linecontact.studies.pressure import analysis
from linecontact.studies.pressure.findings import findings
from linecontact.studies.rough_surfaces import means
from prose import column, digits, span, stored, words_of

pytestmark = pytest.mark.once


def curve_of_a_rough_surface():
    runs = stored("curve").runs
    pressure, kappa, patches = (column(runs, name) for name in ("scene.pressure", "kappa_subgrid", "num_patches"))
    flat = (pressure > 0.0025) & (pressure < 0.15)
    middle = (kappa[flat].max() + kappa[flat].min()) / 2
    off = math.ceil(100 * (kappa[flat].max() / middle - 1))
    many = round(patches[flat].max(), -2)
    yield (
        f"From {pressure[flat].min():.1g} to {digits(pressure[flat].max())} E*, with {patches[flat].min()} to {many} "
        f"patches, kappa stays within {off} % of {middle:.2f}."
    )
    yield f"down to {kappa[pressure < 0.003].min():.2f} where there is one"
    area, seconds = column(runs, "contact_area_subgrid"), column(runs, "seconds.total")
    times = round(np.median(seconds[area > 0.5]) / np.median(seconds[area < 0.1]))
    yield (
        f"The {len(runs)} loads of the figure take {digits(seconds.sum())} s of solving; where more than half is in "
        f"contact a solve takes about {times} times as long as where less than a tenth is."
    )


def kappa_over_the_load():
    curves = analysis.curves(stored("pressure"))
    rough = [c for c in curves if c.rough and c.is_half_space]
    small = [[point for point in curve.points if 0.0002 < point.pressure < 0.11] for curve in rough]
    kappa = [[point.kappa.value for point in points] for points in small]
    assert max(max(own) / min(own) - 1 for own in kappa) < 0.055
    areas = [point.area.value for points in small for point in points]
    yield f"to about 5 % from p = 0.0003 to 0.1 E*, which is a_r = {min(areas):.1g} to {digits(max(areas))}, if"
    falls = [100 * (1 - points[-1].kappa_surface.value / points[0].kappa_surface.value) for points in small]
    yield f"it falls by {min(falls):.0f} to {max(falls):.0f} % over these loads"
    theory = math.sqrt(8 / math.pi)
    above = [100 * (value / theory - 1) for own in kappa for value in own]
    yield f"Its value is {min(above):.0f} to {max(above):.0f} % above sqrt(8/pi) = {theory:.3f}"
    first = [curve.points[0].kappa_surface.value / theory for curve in rough]
    yield f"The slope measured at the smallest loads is {span(first)} times as large."
    layers = [curve for curve in curves if not curve.rough and not curve.is_half_space]
    at = [found for found in map(analysis.bending_thickness, layers) if not math.isnan(found)]
    yield f"a layer takes 5 % off it at d/a_r = {span(at)}."


def roughness_of_the_published_study():
    files = {name: stored(name) for name in ("sharp", "hertz", "blunt", "rough")}
    yield f"These are {sum(len(file.runs) for file in files.values())} solves, every one certified at 1e-8"
    kappa = [np.mean(list(means.half_space(files["rough"], hurst).values())) for hurst in (0.3, 0.5, 0.8)]
    yield f"edges kappa_inf is {min(kappa):.2f} to {max(kappa):.2f} and depends on H"
    assert not any(run["status"] != "converged" for file in files.values() for run in file.runs)
    points = [point for point in means.points(files["rough"]) if point.poisson_ratio <= 0.25]
    over_one_patch = [(p.per_width.value, p.per_patch.value / (2 * math.sqrt(3))) for p in points]
    near = [ratio for width, ratio in over_one_patch if width <= 0.25]
    one_patch = [s.verdict for s in statements.statements(files) if s.text.startswith("rough") and "alpha" in s.text]
    below = [float(verdict.split()[-2]) for verdict in one_patch]
    yield f"{min(below):.0f} to {max(below):.0f} % below the published 2 pi/3, on the surfaces that have one patch left"
    assert max(ratio for width, ratio in over_one_patch if width > 0.25) < 0.7
    off = 10 * math.ceil(10 * max(abs(ratio - 1) for ratio in near))
    yield (
        f"for nu = 0 and 0.25 it is the single patch's value, to about {off} %, "
        "where the layer is at most a quarter as thick as a patch is wide."
    )
    blunt = next(run for run in files["blunt"].runs if math.isinf(run["scene.thickness"]))
    yield f"on the half-space kappa is {blunt['kappa_subgrid'] / 1.283305:.4f} kappa_inf"


def errors_of_the_hertz_study():
    runs = stored("hertz").runs
    yield f"All {len(runs)} runs of the Hertz study"
    edges = [
        (run["scene.thickness"] * n, abs(run["contact_area_subgrid"] - run["oracle.contact_area"]) * n / 2)
        for run, n in zip(runs, column(runs, "scene.num_points"), strict=True)
    ]
    yield f"known to {digits(max(off for thickness, off in edges if thickness > 5))} grid spacings, as long as"
    yield f"{FITTED.of_difference:g}$/\\sqrt m$ of the difference between two estimates to the power"
    yield f"3/2, {FITTED.of_size:g}$/m^2$ and {FITTED.beside_gap:g}$/k^2$"
    yield f"in patches wide beside the layer also {FITTED.of_size_if_wide:g}$\\,t/m$"
    yield f"if that is more, and {FITTED.of_heights:g}$/k^2$; of several patches"
    yield f"{FITTED.of_heights:g} of the sixth over the second difference of the heights"
    yield f"{FITTED.of_heights_at_gaps:g} of the fourth over the second difference of the heights"
    yield f"and {FITTED.in_common:g} of the sum"
    yield f"an end is off by {FITTED.of_layer:g}$\\,m^3/d^4$ more, or by {FITTED.of_layer:g}$\\,k/d^2$ if"
    yield f"For both, $\\alpha = {errors._LEFT:g}$"
    yield f"$b = {FITTED.of_nodes_in_peak:g}$ in the peak pressure and {FITTED.of_nodes_in_approach:g} in the approach"
    assert errors.FACTOR**2 == 16
    yield f"contacts of up to {2 * small_models._LONG_ASPERITY:.0f} thicknesses: milliseconds"
    yield f"of the contact area, from 1e-9 to {errors.MOST_ACCURACY}."


def the_figure_of_the_first_page():
    layers = sum(not math.isinf(run["scene.thickness"]) for run in stored("hertz").runs)
    yield f"Symbols: the {layers} runs on layers, at 2^18 points."


def scatter_of_rough_surfaces():
    kappa = defaultdict(list)
    for run in stored("rough").runs:
        kappa[run["scene.hurst"], run["scene.poisson_ratio"], run["scene.thickness"]].append(run["kappa_subgrid"])
    scatter = [np.std(values, ddof=1) / np.mean(values) for values in kappa.values()]
    yield f"standard errors of kappa of {span([100 * s / math.sqrt(32) for s in scatter], 1)} %"
    worst = max(scatter)
    yield f"kappa scatters from surface to surface by up to {100 * worst:.0f} %"
    few, many = (float(digits((worst / error) ** 2, 1)) for error in (0.03, 0.01))
    yield f"a standard error of 0.01 takes some {many:.0f} surfaces, 0.03 some {few:.0f}."
    sixteen, eight = {16: "Sixteen"}[allocation.PILOT], {8: "eight"}[allocation.FINER_PILOT]
    yield f"{sixteen} surfaces, solved first on the three coarsest grids, and {eight} on finer ones"
    assert allocation.FIRST_GRIDS == 3


def contacts_of_rough_surfaces():
    areas = [run["contact_area"] for run in stored("rough").runs if math.isinf(run["scene.thickness"])]
    yield f"on the half-space have {100 * np.mean(areas):.1f} % of their nodes in contact"


def loads_of_the_study_pressure():
    runs = stored("pressure").runs
    yield f"{len(runs)} solves, every one certified at 1e-8"
    assert all(run["status"] == "converged" and run["tolerance"] <= 1e-8 for run in runs)
    seconds = defaultdict(list)
    for run in runs:
        if run["scene.profile"] == "rough":
            seconds[run["scene.pressure"]].append(run["seconds.solve"])
    means_of_loads = [np.mean(values) for values in seconds.values()]
    yield f"a solve takes up to {max(means_of_loads) / min(means_of_loads):.0f} times as long"
    rough = [curve for curve in analysis.curves(stored("pressure")) if curve.rough]
    full = [(curve, point) for curve in rough for point in curve.points if point.pressure == 1]
    scatter = [200 * p.kappa.error / p.kappa.value for curve, p in full if curve.thickness == 1e-5]
    assert max(200 * p.kappa.error / p.kappa.value for curve, p in full if curve.is_half_space) < 1
    yield f"still scatter by {min(scatter):.0f} to {max(scatter):.0f} %."
    free = [100 * ((1 - p.persson) / (1 - p.area.value) - 1) for curve, p in full if curve.is_half_space]
    yield "the theory's share of the period without contact, 1 - a_r, is"
    yield f"{min(free):.0f} to {max(free):.0f} % larger than the measured one."


def kappa_on_layers():
    curves = analysis.curves(stored("pressure"))
    thin = [c for c in curves if c.rough and c.thickness == 0.001]
    largest = {(c.shape, c.poisson_ratio): max(point.area.value for point in c.constant) for c in thin}
    smooth = [area for (hurst, nu), area in largest.items() if hurst == 0.3 and nu <= 0.25]
    assert digits(min(smooth), 1) == digits(max(smooth), 1)
    most = digits(max(area for (hurst, _), area in largest.items() if hurst > 0.3), 1)
    yield (
        f"at d = 0.001 L kappa is constant to a_r = {digits(min(smooth), 1)} for H = 0.3 and nu up to 0.25, and to no "
        f"more than {most} for H = 0.5 and 0.8."
    )
    said = [s.measured for s in findings(stored("pressure")) if "as wide as the mean patch" in s.text]
    near, below, above = (
        [int(re.search(part, text)[1]) for text in said]
        for part in (r"(\d+)% of the points", r"at most -(\d+)", r"and \+(\d+) %")
    )
    yield f"up to {1 + max(above) / 100:.1f} times as high as the line"
    yield f"an abscissa that the line covers, {min(near)} to {max(near)} % are within 25 % of it."
    yield f"off by up to a factor of {1 / (1 - max(below) / 100):.1f}: below the line by {max(below)} %"


def the_map_of_extremes():
    runs = stored("extremes").runs
    yield f"some {round(len(runs), -4) / 1000:.0f} 000 scenes"
    *_, others, slowest = sorted(run["seconds.cell"] for run in runs)
    yield f"took {slowest / 60:.0f} minutes; all others {others:.0f} seconds at most."
    exponents = [run["scene.exponent"] for run in runs if not math.isnan(run.get("scene.exponent", math.nan))]
    yield f"power profiles with n = {min(exponents)} to {max(exponents):.0f}"


def times_of_a_point():
    runs = [run for run in stored("peers").runs if (run["solver"], run["name"]) == ("linecontact", "H=0.8")]
    (run,) = (run for run in runs if math.isinf(run["scene.thickness"]) and run["scene.num_points"] == 2**18)
    yield (
        f"with 64 points to the shortest wave and {run['num_patches']:.0f} patches, 2^18 points take "
        f"{digits(run['seconds.total'])} s in all, {digits(1e6 * run['seconds.total'] / 2**18)} us a point."
    )
    surface = RoughIndenter(0.8, roll_off_ratio=1 / 8, cut_off_ratio=8 * 8 / 2**18)
    found = solve(Scene(indenter=surface, pressure=areas.PRESSURE)).observables
    yield f"a line of 2^18 points has about {round(found.num_patches, -1)} contact patches then."


def share_of_the_step_control():
    runs = [run for run in stored("kernels").runs if run["num_points"] == 2**18]
    seconds = {
        name: np.median([run["seconds.warp"] for run in runs if run["benchmark"] == name])
        for name in ("fire_control", "plain_move", "loaded_move", "mass_weighted_move")
    }
    assert all(seconds["fire_control"] < 0.01 * value for name, value in seconds.items() if name != "fire_control")
    yield "it is less than a hundredth of the move that it is part of"


def pairs_over_the_load():
    runs = stored("curve").runs
    pairs, area = column(runs, "transform_pairs"), column(runs, "contact_area_subgrid")
    yield f"up to {pairs.max():.0f} of them, most where a_r = {digits(area[pairs.argmax()])}."


def what_a_gpu_brings():
    runs = stored("gpu").runs
    by_size = defaultdict(dict)
    for run in runs:
        if run["what"] == "iteration" and run["precision"] == "float64" and run["seconds.cpu"] > 0:
            by_size[run["num_points"]][run["method"]] = run["seconds.cpu"] / run["seconds.gpu"]
    plain, weighted = (by_size[2**22][name] for name in ("fire", "mass-weighted-fire"))
    yield (
        f"At 2^22 points in float64 plain FIRE's iteration takes 1/{plain:.0f} of its time on the CPU, mass-weighted "
        f"FIRE's 1/{weighted:.0f}"
    )
    assert max(by_size[2**14].values()) < 4
    yield "on 2^14 points little is gained."
    shares = [run["share"] for run in runs if run["what"] == "kernel"]
    yield f"The kernels move {span(shares)} times as many bytes a second"
    solved = {(run["method"], run["where"], run["num_points"]): run for run in runs if run["what"] == "solve"}
    active, there = (
        {n: run for (method, where, n), run in solved.items() if (method, where) == key}
        for key in (("active-set", "cpu"), ("mass-weighted-fire", "cuda"))
    )
    ratios = [active[n]["seconds.total"] / there[n]["seconds.total"] for n in (2**22, 2**24)]
    yield f"at 2^22 points the active set takes {ratios[0]:.1f} times as long, at 2^24 points {ratios[1]:.1f} times."
    rest = 1 - there[2**22]["seconds.solve"] / there[2**22]["seconds.total"]
    yield f"is most of the GPU's solve: {100 * rest:.0f} % at 2^22 points."
    slower = [n for n in there.keys() & active.keys() if active[n]["seconds.total"] < there[n]["seconds.total"]]
    yield f"Up to 2^{math.log2(max(slower)):.0f} points the active set on the CPU is faster."
    most = max(run["num_points"] for run in runs if run["what"] == "iteration")
    yield f"With 80 GB both methods fit 2^{math.log2(most):.0f} points"
    fit = {run["method"] for run in runs if run["what"] == "iteration" and run["num_points"] == most}
    assert fit == {"fire", "mass-weighted-fire"}


def what_the_machine_gains():
    runs = stored("transforms").runs
    pairs = [run for run in runs if run["benchmark"] == "real_pair" and run["precision"] == "float64"]
    planning = max(run["seconds.planning.measure"] for run in pairs)
    saved = [100 * (1 - run["ratio.measure"]) for run in pairs]
    yield f"measuring takes {digits(planning)} s and saves {span(saved)} % of its time"
    seconds = defaultdict(dict)
    for run in stored("tradeoff").runs:
        if run.get("method") == "active-set" and run["precision"] == "float64" and run["nested"] == 1:
            seconds[run["family"], run["scene.num_points"], run["tolerance"]][run["threads"]] = run["seconds.total"]
    ratios = {key: times[2] / times[1] for key, times in seconds.items() if {1, 2} <= times.keys()}
    yield f"takes {span(ratios.values())} times as long with it on 2^16 to 2^20 points, "
    yield f"{np.median([*ratios.values()]):.2f} times in the median"
    assert {n for _, n, _ in ratios} == {2**16, 2**18, 2**20}


@pytest.mark.parametrize(
    ("page", "sentences"),
    [
        ("README", the_figure_of_the_first_page),
        ("docs/accuracy", errors_of_the_hertz_study),
        ("docs/architecture", contacts_of_rough_surfaces),
        ("docs/costs", pairs_over_the_load),
        ("docs/costs", what_the_machine_gains),
        ("docs/curves", curve_of_a_rough_surface),
        ("docs/ensembles", scatter_of_rough_surfaces),
        ("docs/extremes", the_map_of_extremes),
        ("docs/gpu", what_a_gpu_brings),
        ("docs/kernels", share_of_the_step_control),
        ("docs/paper", roughness_of_the_published_study),
        ("docs/peers", times_of_a_point),
        ("docs/pressure", kappa_on_layers),
        ("docs/pressure", kappa_over_the_load),
        ("docs/pressure", loads_of_the_study_pressure),
    ],
)
def test_a_sentence_says_what_is_found(page, sentences):
    text = words_of(page)
    for sentence in sentences():
        assert sentence in text
