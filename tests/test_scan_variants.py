"""One scan, written in many ways: each is read rightly, or refused with the remedy; none is misread.

The values are those of a stylus profilometer: positions in steps of 0.156 um, heights of some 10 nm.
"""

import numpy as np
import pytest
from linecontact.studies.scans.reading import read_scan

COUNT, SPACING = 200, 0.156e-6
HEIGHTS = 1e-8 * (np.random.default_rng(7).standard_normal(COUNT).cumsum() + 30)
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "angstrom": 1e-10, "inch": 0.0254}


def rows(x="um", z="um", sep=",", decimal=".", order="xz", end="", **more):
    """The lines of the table; columns in the order of the letters, n is a running number.

    more: offset [m], reverse, digits, keep (the rows that are written).
    """
    position = (np.arange(COUNT) * SPACING + more.get("offset", 0.0)) / METRES[x]
    values = {"x": position, "z": HEIGHTS / METRES[z], "n": np.arange(1, COUNT + 1), "q": np.full(COUNT, 0.5)}
    table = np.stack([values[letter] for letter in order], axis=1)
    table = (table[::-1] if more.get("reverse") else table)[more.get("keep", slice(None))]
    lines = (sep.join(f"{value:.{more.get('digits', 9)}g}" for value in line) + end for line in table)
    return "\n".join(lines).replace(".", decimal) + "\n"


PARAMETERS = (
    "Scan Parameters\nScan Type,Standard Scan\n"
    "Stylus,Radius: 2.5 \u00b5m\nLength,1500.0 um\nResolution,0.156 um/sample\n"
    "\nAnalytical Results\nFunction,Result\nRa,0.00525 um\n\nScan Data\n"
)
UNITS = {"x_unit": "um", "z_unit": "um"}

READ = {
    # units in the label of a column
    "nanometer": ("Distance (um),Height (nanometer)\n" + rows(z="nm"), {}),
    "one of several heights": ("x [um],z2 [nm]\n" + rows(z="nm"), {}),
    "a label left out": ('"No.","Distance","Height"\n"","\u00b5m","\u00b5m"\n' + rows(order="nxz"), {}),
    "whole numbers with labels": ("x [um],z [nm]\n" + "".join(f"{i},{i % 7}\n" for i in range(COUNT)), {}),
    "two returns": (("x [um],z [um]\n" + rows()).replace("\n", "\r\r\n"), {}),
    "two brackets": ("x (lateral) [um],Height (raw) [nm]\n" + rows(z="nm"), {}),
    "words that only sound like another quantity": (
        "x [um],High resolution triangle height (orange) [nm]\n" + rows(z="nm"),
        {"columns": "1,2"},
    ),
    "inch": ("x (in),z (inch)\n" + rows(x="inch", z="inch"), {}),
    "Angstrom sign": ("Lateral (um),Height (\u00c5)\n" + rows(z="angstrom"), {}),
    # units elsewhere
    "a line of units": ("X,Z\n\u00b5m,nm\n" + rows(z="nm"), {}),
    "a line of units in brackets": ("Position\tHeight\n[mm]\t[um]\n" + rows(x="mm", sep="\t"), {}),
    "given": (rows(), UNITS),
    "given for one": ("x [mm],z\n" + rows(x="mm", z="nm"), {"z_unit": "nm"}),
    "the scene's own": (rows(x="m", z="m"), {"scene_units": True}),
    "the scene's own, mm": (rows(x="mm", z="mm"), {"scene_units": True, "length_unit": "mm"}),
    "a scene in mm": ("x [um],z [nm]\n" + rows(z="nm"), {"length_unit": "mm"}),
    # encodings
    "Latin 1": (("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("latin-1"), {}),
    "UTF-16, big end first": (b"\xfe\xff" + ("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("utf-16-be"), {}),
    "UTF-8 with a mark": (("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("utf-8-sig"), {}),
    "decoded once too little": ("x [\u00c2\u00b5m],z [\u00c2\u00b5m]\n" + rows(), {}),
    "old line ends": (("x [um],z [um]\n" + rows()).replace("\n", "\r"), {}),
    "a comment below the labels": ("x [um],z [um]\n# measured by me\n" + rows(), {}),
    # separators and decimals
    "decimal commas, semicolons": ("x [um];z [um]\n" + rows(sep=";", decimal=","), {}),
    "decimal commas, spaces": ("x [um]  z [um]\n" + rows(sep="  ", decimal=","), {}),
    "comma and space": ("x [um], z [um]\n" + rows(sep=", "), {}),
    "trailing empty columns": ("x [um],z [um],,\n" + rows(end=" , ,"), {}),
    "blank lines at the end": ("x [um],z [um]\n" + rows() + "\n\n , \n", {}),
    # columns
    "heights first": ("Height [nm],Position [um]\n" + rows(z="nm", order="zx"), {}),
    "an index between labels": ("Index,X [um],Z [um]\n" + rows(order="nxz"), {}),
    "a column of heights": ("Height [nm]\n" + rows(z="nm", order="z"), {"scan_length": COUNT * SPACING}),
    # positions
    "reversed": ("x [um],z [um]\n" + rows(reverse=True), {}),
    "printed minus signs": ("x [um],z [um]\n" + rows(offset=-1e-5).replace("-", "\u2212"), {}),
    "a kilometre away": ("x [um],z [um]\n" + rows(offset=1000.0, digits=16), {}),
    "a value left out": ("x [um],z [um]\n" + rows(keep=np.r_[:90, 91:COUNT]), {}),
}

REFUSED = {
    "no header": (rows(), {}, "x_unit and z_unit are missing: .* names no unit of its positions and"),
    "UTF-16 without a mark": (("x [um],z [um]\n" + rows()).encode("utf-16-le"), {}, "no table of numbers"),
    "one label without": ("x [um],z\n" + rows(), {}, "z_unit is missing"),
    "labels without units": ("Lateral,Raw\n" + rows(), {}, "x_unit and z_unit are missing"),
    "volts": ("x [um],z [V]\n" + rows(), {}, r"the heights, 'z \[V\]', are no lengths for 'V'"),
    "a parameter above": ("Stylus radius 2.5 um\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a pipe": (rows(sep="|"), UNITS, r"no table .*; the last line is .*\|.*; allowed: .* by commas, semicolons"),
    "a second axis": (
        "X unit: mm\nY unit: mm\nX,Y,Z\n" + rows(order="xqz"),
        {},
        "columns is missing: .* 'X', 'Y', 'Z'",
    ),
    "a factor alone": ("x [um],x10 [nm]\n" + rows(), {}, "columns is missing: .*'x10 .nm.'"),
    "a raised digit": ("x [um],z\u00b2 [nm]\n" + rows(), {}, "\\^"),
    "gaps or heights": ("x [um],gap [um]\n" + rows(), {}, "profile_convention is missing"),
    "bits over": ("x [um],Height (nm)/LSB\n" + rows(), {}, "LSB"),
    "a spectral density": ("x [um],PSD [nm]\n" + rows(), {}, "PSD"),
    "an inverted axis": ("x [um],-z [nm]\n" + rows(z="nm"), {}, "profile_convention is missing"),
    "depths, said above": ("Values are depths\nx [um],z [um]\n" + rows(), {}, "profile_convention is missing"),
    "a scan along a diagonal": ("x [um],y [um],z [nm]\n" + rows(order="xxz", z="nm"), {}, "columns is missing"),
    "two units in a label": ("x [um],Height [nm] (mm)\n" + rows(z="nm"), {}, "Height .nm. .mm."),
    "columns against labels": ("x [um],z [nm]\n" + rows(z="nm"), {"columns": "2,1"}, "columns is '2,1', labelled"),
    "downwards": ("Z axis points down\nx [um],z [um]\n" + rows(), {}, "profile_convention is missing"),
    "the user against the file": ("x [um],z [um]\n" + rows(), {"z_unit": "nm"}, "z_unit is nm, but .* names um"),
    "words for heights": ("x [um],z [um]\n" + rows(order="x", end=",a"), {}, "no numbers below 'z .um.' in '0,a'"),
    "a slope in formulas": ("x [um],dz/dx\n" + rows(), {"z_unit": "um"}, "columns is missing: .*'dz/dx'"),
    "a title above a slope": ("Steel, run 5\nx [um],y-slope [um]\n" + rows(), {}, "no lengths for 'slope'"),
    "a power of ten": ("Z scale: 1000\nx [um],z [um]\n" + rows(), {}, "Z scale: 1000"),
    "three columns": (rows(order="nxz"), UNITS, "columns is missing: .* has 3 columns"),
    "heights first, no labels": (rows(order="zx"), UNITS, "columns, like 2,1"),
    "no positions": ("Height [um]\n" + rows(order="z"), {}, "scan_length is missing"),
    "an index for positions": ("Index,Height [um]\n" + rows(order="nz"), {}, "scan_length is missing"),
    "its own length": (
        "x [um],z [um]\n" + rows(),
        {"scan_length": 1.0},
        "scan_length is 1.0; allowed: none, .* has positions",
    ),
    "decimal or not": ("0,5\n1,7\n2,9\n" * 20, {}, "decimal is missing: in '0,5', commas .*; allowed: comma, or point"),
    "thousands": ("1,234 5,678\n2,345 6,789\n" * 20, UNITS, "decimal is missing"),
    "depths": ("x [um],Depth [um]\n" + rows(), {}, "profile_convention is missing"),
    "a long gap": ("x [um],z [um]\n" + rows(keep=np.r_[:60, 100:COUNT]), {}, "x has a gap of .* of the scan"),
    "too few digits": ("x [um],z [um]\n" + rows(digits=2), {}, "x goes from"),
    "a period": (
        "x [um],z [um]\n" + rows(),
        {"period": 1e-3},
        "period is 0.001; allowed: none with a file, whose scan is the period",
    ),
}


def write(folder, content):
    path = folder / "scan.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


NM = {"x_unit": "um", "z_unit": "nm"}
TABS = rows(z="nm", sep="\t")

OTHERWISE = {
    "without brackets": ("Lateral um,Raw Nanometer,\n" + rows(z="nm", end=",,"), NM, "Lateral um"),
    "quantity over unit": ("x / um\tz / nm\n" + TABS, NM, "x / um"),
    "hyphens": ("x_um,z_nm\n" + rows(z="nm"), NM, "x_um"),
    "commas over tabs": ("# x [um], z [nm]\n" + TABS, NM, r"x \[um\], z \[nm\]"),
    "a depth over tabs": ("# x [um], Depth [nm]\n" + TABS, NM | {"profile_convention": "heights"}, "Depth"),
    "a line of units": ("Units;um;nm\nx,z\n" + rows(z="nm"), NM, "Units;um;nm"),
    "one unit for all": ("Unit;um\nx;z\n" + rows(sep=";"), UNITS, "Unit;um"),
    "a sentence": ("x in um, z in nm\n" + rows(z="nm", sep=" "), NM, "x in um, z in nm"),
    "an axis a line": ("X Unit: um\nZ Unit: nm\n" + rows(z="nm"), NM, "X Unit: um"),
    "parameters too": (PARAMETERS + "Lateral um,Raw um,\n" + rows(end=",,"), UNITS, "Lateral um"),
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_what_is_not_understood_is_quoted_and_never_contradicted(tmp_path, name):
    content, options, quoted = OTHERWISE[name]
    path, kept = write(tmp_path, content), {"num_points": COUNT, "detrend": "none", "window": "none"}
    with pytest.raises(ValueError, match=quoted):
        read_scan(path, **kept)
    scan = read_scan(path, **kept, **options)
    np.testing.assert_allclose(scan.indenter.heights, HEIGHTS.max() - HEIGHTS, atol=5e-15)
    for wrong in ({"x_unit": "mm"}, {"z_unit": "cm"}, {"x_unit": options["z_unit"], "z_unit": options["x_unit"]}):
        if wrong != {key: options[key] for key in wrong}:
            with pytest.raises(ValueError, match=r"contradicts|but .* names"):
                read_scan(path, **kept, **options | wrong)


@pytest.mark.parametrize(
    ("header", "named"),
    [
        ("x-position [mm]; y-slope [urad]", "'urad', which is no length|no lengths for 'slope'"),
        ("x [um] | z [V]", "'V', which is no length"),
        ("Unit Z [V]\nx,z", "'V', which is no length"),
        ("Signal in mV\nx,z", "'mV', which is no length"),
        ("Bit2nm = 0.1\nx [um],z [um]", "'Bit2nm = 0.1'|names um"),
    ],
)
@pytest.mark.parametrize("sep", ["\t", ","])
def test_columns_that_are_no_lengths_are_refused_whatever_is_given(tmp_path, header, named, sep):
    with pytest.raises(ValueError, match=named):
        read_scan(write(tmp_path, f"{header}\n" + rows(sep=sep)), x_unit="mm", z_unit="um")


OTHERS = rows(order="xzq")  # a third column, in which anything may be missing


@pytest.mark.parametrize(
    "content",
    [
        OTHERS.replace(",0.5\n", ",\n", 50),
        OTHERS.replace(",0.5\n", ",nan\n", 150),
        OTHERS.replace(",0.5\n", ",N/A\n", 9),
        OTHERS.replace(",0.5\n", ",good\n"),
        OTHERS.replace(",0.5\n", ",out of range\n", 9),
        OTHERS.replace(",0.5\n", ";ok\n").replace(",", ";").replace(".", ","),
    ],
)
def test_other_columns_may_miss_values(tmp_path, content):
    columns = {} if "good" in content or "ok" in content else {"columns": "1,2"}
    path = write(tmp_path, content)
    scan = read_scan(path, num_points=COUNT, detrend="none", window="none", **UNITS, **columns)
    np.testing.assert_allclose(scan.indenter.heights, HEIGHTS.max() - HEIGHTS, atol=5e-15)


@pytest.mark.parametrize("between", [".", "'", "\u202f"])
def test_thousands(tmp_path, between):
    table = [(i / 2, 1234.5 + i % 7) for i in range(40)]
    text = "".join(f"{x};{z:,}\n".replace(".", "!").replace(",", between).replace("!", ",") for x, z in table)
    scan = read_scan(write(tmp_path, text), num_points=40, detrend="none", window="none", **UNITS)
    assert np.ptp(scan.indenter.heights) == pytest.approx(6e-6)
    assert scan.period == pytest.approx(20e-6)


@pytest.mark.parametrize("cell", ["", "nan", "***", "---", "-9999"])
def test_missing_heights_are_filled_or_left_out_and_told(tmp_path, cell):
    lines = rows(z="nm").splitlines()
    lines[40:43] = [f"{line.split(',')[0]},{cell}" for line in lines[40:43]]
    path = write(tmp_path, "x [um],z [nm]\n" + "\n".join(lines))
    kept = {"num_points": COUNT, "detrend": "none", "window": "none"}
    options = {"invalid": "-9999"} if cell == "-9999" else {"missing": "interpolate"}
    if cell != "-9999":
        with pytest.raises(ValueError, match="line 42: a value is missing, and 3 of 200 in all"):
            read_scan(path, **kept)
    filled = read_scan(path, **kept, **options)
    assert filled.indenter.description["profile_missing"] == "3 of 200 values were missing and filled by straight lines"
    expected = HEIGHTS.copy()
    expected[40:43] = np.interp([40, 41, 42], [39, 43], HEIGHTS[[39, 43]])
    np.testing.assert_allclose(filled.indenter.heights, expected.max() - expected, atol=5e-15)
    dropped = read_scan(path, **kept, **options | {"missing": "drop"})
    assert dropped.indenter.description["profile_missing"] == "3 of 200 values were missing and left out"
    assert dropped.period == pytest.approx(filled.period, rel=1e-9)


ALONE = {"scan_length": 1.0}
COMMA = UNITS | {"decimal": "comma"}
COMMAS = "".join(f"{i},5,{i * 7 % 11},1\n" for i in range(60))


@pytest.mark.parametrize(
    ("content", "options", "named"),
    [
        (f"x [um],z [nm]\n{rows()}32,high\n", {}, "line 202: height is text or inf in '32,high'; allowed: finite"),
        (rows(sep=";", decimal=",", keep=slice(90)) + rows(sep=";", keep=slice(90, None)), UNITS, "line 1: .*not writ"),
        (f"x [um],z [nm]\n{rows()}\n32,1\n", {}, "line 202 is empty; allowed: rows like"),
        (f"x [um],z [nm]\n0,1\n1\n{rows()}", {}, "line 3: '1' is not 2 cells; allowed: rows like '0,1' in line 2"),
        (f"x [um],z [nm]\n{rows()}x [um],z [nm]\n{rows()}", {}, "line 202: height is text or inf"),
        (rows(order="z") + "39.0\n", ALONE | {"invalid": "-1"}, "invalid is '-1'; allowed: numbers"),
        ("z [nm]\nnan\nnan\n" + rows(order="z"), ALONE | {"missing": "drop"}, "missing drop if the file has positions"),
        ("16\n" + rows(order="z", keep=slice(16)), ALONE, "line 1: 16 is the number of the values below"),
        (COMMAS, UNITS, "decimal is missing: in '0,5,0,1'"),
        ("x [um],z [um]\n" + COMMAS, {}, "decimal is missing"),
        ("x [um],,z [um],\n" + COMMAS, {}, "decimal is missing"),
        ("".join(f"{i},{i * 7 % 11}\n" for i in range(60)), UNITS, "decimal is missing"),
        (COMMAS.replace("1\n", "1e-1,ok\n"), UNITS | {"columns": "1,3"}, "decimal is missing"),
        (COMMAS, COMMA | {"columns": "1,3"}, "no table .* with decimal commas; .*; decimal commas between commas"),
        ("0;0.5;1\n" * 60, COMMA, "no table of numbers with decimal commas; the last line is '0;0.5;1'"),
        ("".join(f"{i},000;0,{i * 7 % 10}\n" for i in range(60)), UNITS | {"decimal": "point"}, "with decimal points"),
    ],
)
def test_rows_that_are_none(tmp_path, content, options, named):
    with pytest.raises(ValueError, match=named):
        read_scan(write(tmp_path, content), **options)


def test_integers_between_commas_are_integers_if_asked(tmp_path):
    path = write(tmp_path, "Profile of sample A\n" + "".join(f"{i:04},{i * 7 % 11:04}\n" for i in range(60)))
    scan = read_scan(path, num_points=60, detrend="none", window="none", decimal="point", **UNITS)
    assert scan.period == pytest.approx(60e-6)


@pytest.mark.parametrize("name", READ)
def test_read_rightly(tmp_path, name):
    content, options = READ[name]
    kept = {"num_points": COUNT, "detrend": "none", "window": "none"}
    scan = read_scan(write(tmp_path, content), **kept, **options)
    length = 1e3 if options.get("length_unit") == "mm" else 1.0  # of the scene
    whole = name != "a value left out"
    if name == "whole numbers with labels":
        assert scan.period == pytest.approx(COUNT * 1e-6)
        assert np.ptp(scan.indenter.heights) == pytest.approx(6e-9)
        return
    assert scan.period == pytest.approx(COUNT * SPACING * length, rel=2e-5 if whole else 1e-4)
    got, expected = scan.indenter.heights / length, HEIGHTS.max() - HEIGHTS
    error = np.abs(got - expected).max()
    assert error < (5e-15 if whole else 0.1 * np.ptp(HEIGHTS)), name


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_the_remedy(tmp_path, name):
    content, options, named = REFUSED[name]
    with pytest.raises(ValueError, match=named):
        read_scan(write(tmp_path, content), **options)


def test_an_s_shaped_form_is_doubted_and_a_pitch_is_a_parameter(tmp_path):
    i, z = np.linspace(-1, 1, 400), np.random.default_rng(3).standard_normal(400)
    table = "".join(f"{0.5 * j},{value:.6f}\n" for j, value in enumerate(10 * i**3 + z))
    path = write(tmp_path, f"XY pitch,0.0005,mm\n{table}")
    for options, kept in ({}, True), ({"detrend": "curvature"}, True), ({"detrend": "linear"}, False):
        about = read_scan(path, **UNITS, **options).indenter.description
        assert ("an S-shaped form of 8." in about.get("profile_doubts", "")) is kept
    path = write(tmp_path, "".join(f"{0.5 * j},{value:.6f}\n" for j, value in enumerate(2 * i**3 + z)))
    assert "S-shaped" not in read_scan(path, **UNITS).indenter.description.get("profile_doubts", "")


def test_an_option_that_is_given_is_not_advised_again(tmp_path):
    """A number that no spike's rule has found is doubted all the same."""
    path, heights = tmp_path / "scan.csv", HEIGHTS.copy()
    heights[-40:] = HEIGHTS.min() - np.ptp(HEIGHTS)  # wider than a spike
    path.write_text("\n".join(f"{1e6 * SPACING * i:.6g},{1e6 * z:.9g}" for i, z in enumerate(heights)))
    said = [read_scan(path, despike=d, **UNITS).indenter.description["profile_doubts"] for d in (False, True)]
    assert all("may stand for missing values (--invalid) or be dust" in doubts for doubts in said)
    assert ["--despike" in doubts for doubts in said] == [True, False]
