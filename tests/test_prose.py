"""The sentences of the pages on short examples, of limits in the source and of stored results: every sentence here is
composed from these, and must stand in the page, so a number that changes finds the sentences that it makes wrong."""

import math
import re
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from linecontact import read_scan
from linecontact.kernels import layout
from linecontact.solver import METHODS, Layer, MeasuredIndenter, RoughIndenter, Scene, scene, solve, warnings
from linecontact.solver.calibration import FITTED
from linecontact.solver.display import rounded_up
from linecontact.solver.grid import cached, contact, edges, errors, layer_on_grid, narrow, problem, shares
from linecontact.solver.layers import coated
from linecontact.solver.methods.active_set import greens_function
from linecontact.solver.reference import closed_forms
from linecontact.solver.solve import _OVER_FLOOR
from linecontact.solver.strategy import grids, small_models
from linecontact.solver.strategy.run import _MOST_WORK
from linecontact.solver.transforms import four_step, plain
from linecontact.studies.explore import controls
from linecontact.studies.figures.style import ONE_COLUMN, TWO_COLUMNS
from linecontact.studies.files import confined, study_files
from linecontact.studies.multilevel import allocation
from linecontact.studies.paper import statements
from linecontact.studies.peers import areas
from linecontact.studies.pressure import analysis
from linecontact.studies.pressure.findings import findings
from linecontact.studies.rough_surfaces import means
from linecontact.studies.scans import columns, missing, preparation, text
from pages import ROOT

pytestmark = pytest.mark.once


def stored(name):
    return study_files.load_study(ROOT / "studies" / "results" / f"{name}.h5")


def column(runs, name):
    return np.array([run[name] for run in runs])


def digits(value, count=2):
    return f"{value:.{count}g}"


def span(values, count=2):
    least, most = digits(min(values), count), digits(max(values), count)
    return least if least == most else f"{least} to {most}"


def words_of(page):
    """The text of a page on one line, without emphasis."""
    return " ".join((ROOT / f"{page}.md").read_text().replace("**", "").replace("\\*", "*").split())


def what_the_tutorial_finds():
    half_space = solve(Scene()).observables.contact_area_subgrid
    exact = closed_forms.periodic_half_space_area(2, 1.0, 2e-3)
    yield f"The relative contact area is {half_space:.6f}; in closed form it is {f'{exact:.8f}'[1:]}."
    thick, thin = (solve(Scene(Layer(d, poisson_ratio=0.25))).observables for d in (1.0, 0.001))
    yield f"d = 1.0 L: a_r = {thick.contact_area_subgrid:.6f}, kappa = {thick.kappa_subgrid:.4f}"
    yield f"down to a_r = {thin.contact_area_subgrid:.6f}."
    values = 20 * np.random.default_rng(0).standard_normal(1000).cumsum() / 30
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scan.csv"
        table = np.stack([0.5 * np.arange(1000), values], axis=1)
        np.savetxt(file, table, delimiter=",", header="x [um],z [nm]")
        scan = read_scan(file)
    rubber = Layer(thickness=2e-3, poisson_ratio=0.49, youngs_modulus=3e6)
    found, pressed = (solve(scan.scene(rubber, pressure=pressure)).observables for pressure in (5e3, 5e4))
    yield f"Of the period {found.contact_area_subgrid:.2f} is in contact, in {found.num_patches} patches."
    yield f"The estimated error, {rounded_up(found.contact_area_error)}, is as large"
    yield "Ten times the load closes all gaps."
    assert pressed.contact_area == 1


def the_pictured_rough_surface():
    found = solve(Scene(indenter=RoughIndenter(hurst=0.8, seed=0), pressure=0.01)).observables
    yield f"{found.num_patches} contact patches on 2^18 points."
    yield f"a column in a journal, {ONE_COLUMN} inches ({2.54 * ONE_COLUMN:.1f} cm)"
    yield f"two columns ({TWO_COLUMNS:.0f} inches) wide"


def areas_of_hertz_contacts():
    exact = closed_forms.periodic_half_space_area(2, 1.0, 2e-3)
    off = [abs(solve(Scene(num_points=n)).observables.contact_area_subgrid / exact - 1) for n in (2**12, 2**14)]
    assert off[0] < 1e-8
    assert off[1] < 2e-10
    yield "Hertz contacts on 2^12 points are right to 1e-8 of themselves, on 2^14 points to 2e-10."
    assert (edges._NARROW, contact._LOADS_KNOW_BEST, contact.MOST_NODES) == (2, 10, 32)
    yield "The row is taken, and the last term with it, for patches of up to two thicknesses of the layer,"
    yield "Patches of up to 10 nodes get the ends by load"
    yield "Those of up to 32 nodes get the ends"


def patches_of_a_few_nodes():
    """A parabola, pressed to an approach that is known from a fine grid."""
    coarse, fine, forces = 2**8, 2**12, defaultdict(list)

    def parabola(num_points, beside):
        return ((np.arange(num_points) / num_points - beside / coarse + 0.5) % 1 - 0.5) ** 2 / 2

    def pressed(h, **load):
        return solve(Scene(indenter=MeasuredIndenter(h, convention="gap"), num_points=h.size, **load))

    for width in np.linspace(0.5, 4, 15):
        pressure = math.pi * (width / coarse / 2) ** 2 / 4
        exact = pressed(parabola(fine, 0), pressure=pressure).observables
        for beside in np.linspace(0, 0.5, 5):
            h = parabola(coarse, beside)
            if exact.approach > h.min():
                found = pressed(h, approach=exact.approach - h.min())
                forces[int(found.contact.sum())].append(100 * (found.scene.pressure / pressure - 1))
    one, two, three = (digits(np.sqrt(np.mean(np.square(forces[k])))) for k in (1, 2, 3))
    yield f"off by {one} % where it touches one node, by {two} % with two and {three} % with three (root mean squares)"


def limits_of_edges():
    yield "from the polynomial through six nodes"
    yield "of up to the sixth degree, fitted to its values on the patch and on up to three nodes to each side"
    assert (layout.STENCIL, layout.DEGREE, narrow.MARGIN) == (6, 6, 3)
    yield "More than 128 patches are corrected in groups of 128 that follow each other."
    assert shares._TOGETHER == 128
    yield "on which its shortest wave finds the half-space's stiffness to within a fifth"
    assert layer_on_grid._ALIKE == 0.2
    yield "narrower than two thicknesses of the layer each end feels the other"
    yield "on layers thicker than two grid spacings they have the half-space's edge"
    assert edges._NARROW == 2


def limits_of_precision():
    scene_of_hertz = Scene()
    discrete = problem.Problem.from_scene(scene_of_hertz, scene_of_hertz.num_points)
    displacement = solve(scene_of_hertz).displacement / discrete.length_unit
    floor = problem.rounding_floor(discrete.stiffness, displacement, "float64")
    yield f"some {floor:.0e} for the parabola on the half-space at 2^18 points"
    yield f"The default tolerance, {grids.DEFAULT_TOLERANCE:.0e}, is raised".replace("e-0", "e-")
    yield "the larger of 1e-4 and four times the prediction"
    assert (math.sqrt(grids.DEFAULT_TOLERANCE), _OVER_FLOOR) == (1e-4, 4)


def stiffness_under_a_sine_wave():
    x = np.arange(2**14) / 2**14
    sine = MeasuredIndenter(0.01 * (1 - np.cos(2 * np.pi * x)), convention="gap")
    worst = 0.0
    for area in (0.1, 0.3, 0.6, 0.8):
        pressure = math.pi * 0.01 * math.sin(math.pi * area / 2) ** 2
        solution = solve(Scene(indenter=sine, pressure=pressure, num_points=2**14))
        exact = -math.pi / (2 * math.log(math.sin(math.pi * solution.observables.contact_area_subgrid / 2)))
        worst = max(worst, abs(solution.contact_stiffness / exact - 1))
    assert worst < 2e-7
    yield "met to 2e-7 at 2^14 points for $a_r$ from 0.1 to 0.8"


def limits_of_the_methods():
    search, heavy = METHODS["active-set"], METHODS["mass-weighted-fire"]
    yield f"of up to {greens_function.SMALL} nodes, are solved by elimination."
    yield f"has not settled after {search.max_iterations} iterations"
    assert heavy.max_iterations == _MOST_WORK / 2**16 == 20_000
    yield f"20 000 iterations on up to 2^16 points, {_MOST_WORK / 2**18:.0f} on 2^18,"


def limits_of_scenes():
    yield "Ratios from 1e-60 to 1e60 are allowed."
    assert (scene.SMALLEST, scene.LARGEST) == (1e-60, 1 / 1e-60)
    yield "(1e-6 to 1e6 of the layer's)"
    assert coated._MOST_RATIO == 1e6


def what_is_kept():
    yield f"on grids of up to 2^{math.log2(cached.MOST_POINTS):.0f} points"
    yield "The last seven grids are kept"
    assert cached._GRIDS == 7
    yield f"Float64 transforms of 2^{math.log2(plain.IN_PLACE):.0f} points and more"
    yield f"of 2^{math.log2(four_step.FASTER):.0f} points and more are done"


def limits_of_scans():
    yield f"up to {text.MAX_TEXT / 2**20:.0f} MiB"
    yield f"with up to 2^{math.log2(columns.MAX_VALUES):.0f} numbers."
    yield f"with {confined.MEMORY / 2**30:.0f} GiB (and the file's size) of memory and {confined.SECONDS} s"
    yield f"A gap of more than {100 * missing.LONGEST_GAP:.0f} % of the scan is refused"
    yield f"more than {100 * missing.DOUBTED:.0f} % of the scan had no values"
    assert (preparation._ROOM, preparation._BETWEEN, preparation._FORM) == (2 / 8, 1 / 4, 5)
    yield "at most sixteen for each value"
    assert columns.MAX_REFINEMENT == 16
    yield "the patches have fewer than three nodes on the average"
    assert warnings._FEWEST_NODES == 3
    yield f"the edges of the patches and gaps between two nodes may be off by {100 * warnings.LARGEST_ERROR:.0f} %"
    yield f"patches as narrow as two values carry more than {100 * warnings._MOST_LEFT_OUT:.0f} % of the load"
    yield f"strains reach about {warnings.LARGEST_STRAIN}:"
    slope = warnings.LARGEST_SLOPE
    off = f"tan(t) is {100 * (math.tan(slope) / slope - 1):.0f} % off t there, the length of the surface "
    yield f"the rms slope in the contact is above {slope} | {off}{100 * (math.sqrt(1 + slope**2) - 1):.0f} % off"
    yield f"a_r is above {warnings.NEARLY_FULL}"


def reach_of_the_sliders():
    ranges = {control.name: (control.low, control.high) for control in controls.CONTROLS}
    assert (ranges["thickness"], ranges["pressure"]) == ((-5, 1), (-6, -1))
    yield "| thickness d/L, logarithmic | 1e-5 | 10,"
    yield "| mean pressure p/E*, logarithmic | 1e-6 | 0.1 |"
    for name, field in (
        ("Poisson's ratio nu", "poisson_ratio"),
        ("exponent n of a power profile", "exponent"),
        ("Hurst exponent H of a rough surface", "hurst"),
        ("seed of its random phases", "seed"),
    ):
        yield f"| {name} | {ranges[field][0]} | {ranges[field][1]} |"


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
        ("docs/accuracy", limits_of_precision),
        ("docs/architecture", contacts_of_rough_surfaces),
        ("docs/costs", pairs_over_the_load),
        ("docs/costs", what_is_kept),
        ("docs/costs", what_the_machine_gains),
        ("docs/curves", curve_of_a_rough_surface),
        ("docs/curves", stiffness_under_a_sine_wave),
        ("docs/edges", areas_of_hertz_contacts),
        ("docs/edges", limits_of_edges),
        ("docs/edges", patches_of_a_few_nodes),
        ("docs/ensembles", scatter_of_rough_surfaces),
        ("docs/explore", reach_of_the_sliders),
        ("docs/extremes", the_map_of_extremes),
        ("docs/gpu", what_a_gpu_brings),
        ("docs/kernels", share_of_the_step_control),
        ("docs/methods", limits_of_the_methods),
        ("docs/paper", roughness_of_the_published_study),
        ("docs/peers", times_of_a_point),
        ("docs/physics", limits_of_scenes),
        ("docs/pressure", kappa_on_layers),
        ("docs/pressure", kappa_over_the_load),
        ("docs/pressure", loads_of_the_study_pressure),
        ("docs/results", the_pictured_rough_surface),
        ("docs/scans", limits_of_scans),
        ("docs/tutorial", what_the_tutorial_finds),
    ],
)
def test_a_sentence_says_what_is_found(page, sentences):
    text = words_of(page)
    for sentence in sentences():
        assert sentence in text
