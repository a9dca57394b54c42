"""What the pages say in words of short examples and of limits in the source: every sentence here is composed from
these, and must stand in the page, so a number that changes finds the sentences that it makes wrong."""

import math
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from linecontact import read_scan
from linecontact.kernels import layout
from linecontact.solver import METHODS, Layer, MeasuredIndenter, RoughIndenter, Scene, scene, solve, warnings
from linecontact.solver.display import rounded_up
from linecontact.solver.grid import cached, contact, edges, layer_on_grid, narrow, problem, shares
from linecontact.solver.layers import coated
from linecontact.solver.methods.active_set import greens_function
from linecontact.solver.reference import closed_forms
from linecontact.solver.solve import _OVER_FLOOR
from linecontact.solver.strategy import grids, run
from linecontact.solver.transforms import four_step, plain
from linecontact.studies.explore import controls
from linecontact.studies.figures.style import ONE_COLUMN, TWO_COLUMNS
from linecontact.studies.files import confined
from linecontact.studies.scans import columns, missing, preparation, text
from prose import digits, words_of

pytestmark = pytest.mark.once


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
    most = run._MOST_WORK
    assert heavy.max_iterations == most / 2**16 == 20_000
    yield f"20 000 iterations on up to 2^16 points, {most / 2**18:.0f} on 2^18,"


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


@pytest.mark.parametrize(
    ("page", "sentences"),
    [
        ("docs/accuracy", limits_of_precision),
        ("docs/costs", what_is_kept),
        ("docs/curves", stiffness_under_a_sine_wave),
        ("docs/edges", areas_of_hertz_contacts),
        ("docs/edges", limits_of_edges),
        ("docs/edges", patches_of_a_few_nodes),
        ("docs/explore", reach_of_the_sliders),
        ("docs/methods", limits_of_the_methods),
        ("docs/physics", limits_of_scenes),
        ("docs/results", the_pictured_rough_surface),
        ("docs/scans", limits_of_scans),
        ("docs/tutorial", what_the_tutorial_finds),
    ],
)
def test_a_sentence_says_what_is_found(page, sentences):
    text = words_of(page)
    for sentence in sentences():
        assert sentence in text
