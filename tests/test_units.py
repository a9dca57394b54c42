"""Pressures and moduli with units, Young's modulus of every layer, and numbers that are likely in different units."""

import json

import linecontact
import numpy as np
import pytest
from linecontact.solver import CoatedHalfSpace, Layer, Scene, SlidingLayer, solve
from linecontact.solver.warnings import WarningKind
from linecontact.studies.command_line import main

GRID = ["--num-points", "2^10"]
COATED = "--layer coated --thickness 0.1 --poisson-ratio 0.3"


def command(capsys, *words):
    status = main.main([*words])
    return status, capsys.readouterr()


@pytest.mark.parametrize(
    ("words", "unit", "pressure", "modulus"),
    [
        ("--pressure 0.1MPa --contact-modulus 3MPa", "MPa", 0.1, 3.0),
        ("--pressure 200Pa --contact-modulus 2GPa", "Pa", 200.0, 2e9),
        ("--pressure 1e5Pa --contact-modulus 3e6Pa", "Pa", 1e5, 3e6),
        ("--pressure 0.1N/mm^2 --contact-modulus 3N/mm2", "MPa", 0.1, 3.0),
        ("--pressure 2^-3kPa --contact-modulus 3kPa", "kPa", 0.125, 3.0),
        ("--pressure 0.1 --contact-modulus 3 --pressure-unit MPa", "MPa", 0.1, 3.0),
        ("--pressure 100kPa --contact-modulus 3 --pressure-unit MPa", "MPa", 0.1, 3.0),
        ("--pressure 0.1 --contact-modulus 3", None, 0.1, 3.0),
        ("--pressure 1MPa --youngs-modulus 3MPa --poisson-ratio 0.5", "MPa", 1.0, 4.0),
        ("--approach 0.01 --contact-modulus 3GPa", "GPa", None, 3.0),
    ],
)
def test_pressures_and_moduli_have_units_on_the_command_line(capsys, words, unit, pressure, modulus):
    status, said = command(capsys, "solve", *GRID, *words.split(), "--json")
    found = json.loads(said.out)
    assert status == 0
    assert found["scene"].get("pressure_unit") == unit
    assert found["scene"]["contact_modulus"] == modulus
    if pressure:
        assert found["scene"]["pressure"] == pressure
        same = solve(Scene(Layer(), pressure=pressure / modulus, num_points=2**10)).observables
        assert found["contact_area_subgrid"] == pytest.approx(same.contact_area_subgrid, rel=1e-9)
        assert found["peak_pressure"] == pytest.approx(modulus * same.peak_pressure, rel=1e-9)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--pressure 0.1MPa --youngs-modulus 3000000", "youngs_modulus is '3000000'; allowed: with its unit"),
        ("--pressure 0.1 --youngs-modulus 3MPa", "pressure is '0.1'; allowed: with its unit, like 0.1MPa"),
        ("--pressure 0.1MPa", "contact_modulus (or youngs_modulus) is missing; allowed: where lengths or pressures"),
        ("--contact-modulus 3MPa", "pressure (or approach) is missing; allowed: where lengths or pressures have units"),
        (
            "--pressure 5N/mm --youngs-modulus 3",
            "pressure is '5N/mm', a load F' per length; allowed: the mean pressure",
        ),
        ("--pressure 5kN/m --youngs-modulus 3GPa", "pressure is '5kN/m', a load F' per length; allowed: the mean"),
        ("--pressure 5mpa --youngs-modulus 3GPa", "pressure is '5mpa'; allowed: a number alone, or each pressure"),
        ("--pressure 1,5MPa --youngs-modulus 3GPa", "pressure is '1,5MPa'; allowed: a number with a decimal point"),
        ("--pressure 5um --youngs-modulus 3GPa", "pressure is '5um'; allowed: a number alone, or each pressure"),
        ("--thickness 5MPa", "thickness is '5MPa'; allowed: a number"),
        (f"{COATED} --base-modulus 3 --youngs-modulus 1GPa --pressure 1MPa", "base_modulus is '3'; allowed: with its"),
        (f"{COATED} --pressure 1MPa --youngs-modulus 1GPa", "base_modulus (or base_youngs_modulus) is missing"),
        (
            "--layer sliding --thickness 1 --youngs-modulus 3",
            "poisson_ratio is missing; allowed: -1 < nu <= 0.5 beside",
        ),
        ("--layer sliding --thickness 1 --poisson-ratio 0.3", "poisson_ratio is 0.3; allowed: with youngs_modulus"),
    ],
)
def test_units_that_are_not_given_are_not_guessed(capsys, words, said):
    status, told = command(capsys, "solve", *GRID, *words.split())
    assert status == 2
    assert told.err.startswith(f"linecontact: {said}")


def test_results_name_the_unit_of_pressure(capsys, tmp_path):
    words = ["--pressure", "0.1MPa", "--contact-modulus", "3MPa", "--save", str(tmp_path / "run.h5")]
    status, said = command(capsys, "solve", *GRID, *words, "--patches", str(tmp_path / "patches.csv"))
    assert status == 0
    assert "MPa/length" in said.out
    assert "0.1 │ MPa" in said.out
    assert "pressure]" not in said.out
    assert "peak_pressure [MPa]" in (tmp_path / "patches.csv").read_text()
    status, said = command(capsys, "export", str(tmp_path / "run.h5"))
    assert said.out.startswith("x [length],profile [length],displacement [length],contact_pressure [MPa]")
    scene = Scene(Layer(contact_modulus=3.0), pressure=0.1, num_points=2**10, pressure_unit="MPa")
    assert "contact_modulus 3 [MPa]" in repr(scene)
    assert linecontact.load(tmp_path / "run.h5").results["scene.pressure_unit"] == "MPa"
    with pytest.raises(ValueError, match="pressure_unit is 'mPa'; allowed: Pa, kPa, MPa, GPa"):
        Scene(pressure_unit="mPa")


@pytest.mark.parametrize(
    ("words", "values"),
    [
        ("--contact-modulus 3MPa --from 30kPa --to 0.3MPa", [0.03, 0.3]),
        ("--pressure 1MPa --over contact_modulus --from 10MPa --to 1GPa", [10.0, 1000.0]),
        ("--pressure 1 --pressure-unit MPa --over contact_modulus --from 10 --to 1GPa", [10.0, 1000.0]),
    ],
)
def test_a_curve_over_a_pressure_has_units(capsys, tmp_path, words, values):
    words = [*words.split(), "--points", "2", "--folder", str(tmp_path / "out"), "--workers", "1"]
    status, said = command(capsys, "curve", *GRID, *words)
    assert status == 0
    assert "[MPa]" in said.out
    assert [float(line.split()[0]) for line in said.out.splitlines() if line.endswith(" 1 ")] == values


def test_every_layer_takes_youngs_modulus():
    coated = CoatedHalfSpace(
        0.1, poisson_ratio=0.5, base_poisson_ratio=0.0, youngs_modulus=3.0, base_youngs_modulus=5.0
    )
    assert coated == CoatedHalfSpace(0.1, 5.0, poisson_ratio=0.5, base_poisson_ratio=0.0, contact_modulus=4.0)
    assert SlidingLayer(0.1, youngs_modulus=3.0, poisson_ratio=0.5) == SlidingLayer(0.1, 4.0)
    with pytest.raises(ValueError, match=r"base_youngs_modulus is 5, and base_modulus 2\.0; allowed"):
        CoatedHalfSpace(0.1, 2.0, base_youngs_modulus=5)


def test_a_pressure_far_above_the_modulus_is_questioned():
    (found, *_) = solve(Scene(Layer(youngs_modulus=3.0), pressure=1e5, num_points=2**8)).warnings
    assert found.kind is WarningKind.UNITS
    assert found.text == "the mean pressure is 3.1e+04 times the contact modulus E*: check that they are in one unit"


@pytest.mark.parametrize(
    ("unit", "thickness", "said"),
    [
        ("um", 50e-6, "the layer is 5e-05 um thick, and the period of the scan is 1e+03 um: check"),
        ("um", 50.0, ""),
        ("m", 50.0, "the layer is 50 m thick, and the period of the scan is 0.001 m: check"),
        ("m", 50e-6, ""),
        ("m", np.inf, ""),
    ],
)
def test_a_layer_in_another_unit_than_its_scan_is_questioned(tmp_path, unit, thickness, said):
    heights = np.random.default_rng(0).normal(size=1000).cumsum() * 1e-3
    np.savetxt(tmp_path / "scan.txt", np.column_stack([np.arange(1000) * 0.5, heights]), header="x [um] z [um]")
    scan = linecontact.read_scan(tmp_path / "scan.txt", x_unit="um", z_unit="um", length_unit=unit, num_points=2**11)
    solution = solve(scan.scene(Layer(thickness, contact_modulus=1e9), 1e6))
    found = [warning.text for warning in solution.warnings if warning.kind is WarningKind.UNITS]
    assert found == ([f"{said} that they are in one unit"] if said else [])
