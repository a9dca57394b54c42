"""What people see of scenes and solutions: printed lines, tables in notebooks."""

import dataclasses

import numpy as np
import pytest
from linecontact import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve


@pytest.fixture(scope="module")
def solution():
    return solve(Scene(Layer(0.1 / 3, 0.25), num_points=256))


def digits(text):
    """The numbers in a text, without sign, point and exponent."""
    return ["".join(c for c in word.partition("e")[0] if c.isdigit()) for word in text.split() if word[0].isdigit()]


def test_printed_results_are_short_and_have_units(solution):
    things = [solution, solution.scene, solution.observables, solution.certificate, solution.patches, *solution.levels]
    things += [Layer(1 / 3, 0.1), PowerIndenter(4 / 3), RoughIndenter(0.3, 5)]
    for thing in things:
        text = repr(thing)
        assert text.startswith(type(thing).__name__)
        assert text.count("\n") < 8
        assert max(map(len, text.split("\n"))) <= 110
        assert all(len(number.lstrip("0")) <= 6 for number in digits(text))
        assert "array" not in text
    assert "thickness 0.0333333 [length]" in repr(solution)
    assert "status converged" in repr(solution)
    assert f"{solution.observables.contact_area_subgrid:.6g} +- " in repr(solution)
    assert "peak_pressure" in repr(solution.observables)
    assert all(f"{name} " in repr(solution.certificate) for name in dataclasses.asdict(solution.certificate))


def test_a_half_space_is_called_one():
    for text in (repr(Layer()), repr(Scene(num_points=64)), Scene(num_points=64)._repr_html_()):
        assert "half-space" in text
        assert "inf" not in text


def test_a_warning_is_printed_with_the_solution():
    solution = solve(Scene(pressure=0.5, num_points=64))
    (warning, *_) = solution.warnings
    assert f"warning, {warning.kind}: {warning.text}" in repr(solution)
    assert warning.kind in solution._repr_html_()


def test_the_unit_of_a_scan_stands_at_its_lengths():
    heights = np.cos(np.arange(64) / 64 * 2 * np.pi) / 100
    about = {"profile_file": "<script>alert('x')</script> & more", "profile_length_unit": "um"}
    scene = Scene(Layer(0.5), MeasuredIndenter(heights, description=about), 1e-4, num_points=64)
    assert "period 1 [um]" in repr(scene)
    assert "thickness 0.5 [um]" in repr(scene)
    assert "[length]" not in repr(scene)
    table = scene._repr_html_()
    assert '<td style="text-align: left">um</td>' in table
    assert "<script>" not in table
    assert "&lt;script&gt;alert(&#x27;x&#x27;)&lt;/script&gt; &amp; more" in table


def test_a_notebook_s_table_holds_the_numbers(solution):
    table = solution._repr_html_()
    for text in ("<table>", "converged", "0.0333333", f"{solution.observables.peak_pressure:.6g}", "dimensionless"):
        assert text in table
    assert table.count("<tr>") == table.count("</tr>") > 20
