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
    "um": ("Lateral um,Raw um\n" + rows(), {}),
    "Micrometer": ("Lateral um,Raw Micrometer,\n" + rows(end=",,"), {}),
    "micro sign": ("x [\u00b5m],z [\u00b5m]\n" + rows(), {}),
    "Greek mu": ("x [\u03bcm],z [\u03bcm]\n" + rows(), {}),
    "microns": ("Position (microns),Height (microns)\n" + rows(), {}),
    "micrometre": ("Distance (micrometre),Height (micrometres)\n" + rows(), {}),
    "nanometer": ("Distance (um),Height (nanometer)\n" + rows(z="nm"), {}),
    "in um": ("Position in \u00b5m;H\u00f6he in nm\n" + rows(z="nm", sep=";"), {}),
    "two languages": ("Weg / Distance [um],H\u00f6he / Height [nm]\n" + rows(z="nm"), {}),
    "both ways": ("x [um],Height Trace/Retrace [nm]\n" + rows(z="nm"), {}),
    "what was done to it": ("x [um],Height (nm) / filtered\n" + rows(z="nm"), {}),
    "a log of heights": ("x [um],Profile log (nm)\n" + rows(z="nm"), {}),
    "a mean of lines": ("x [um],Mean height per line [nm]\n" + rows(z="nm"), {}),
    "accents": ("x (microm\u00e8tres),z (nanom\u00e8tres)\n" + rows(z="nm"), {}),
    "one of several profiles": ("x [um],Profile 1 [nm]\n" + rows(z="nm"), {}),
    "one of several heights": ("x [um],z2 [nm]\n" + rows(z="nm"), {}),
    "one of several heights without brackets": ("x1 um,Height3 nm\n" + rows(z="nm"), {}),
    "one of several heights and positions": ("x1 (um),z_nm\n" + rows(z="nm"), {}),
    "heights before their positions": ("z1 [nm],x1 [um]\n" + rows(z="nm", order="zx"), {}),
    "one of several lines": ("x [um],Height line 12 [nm]\n" + rows(z="nm"), {}),
    "a slope that was removed": ("x [um],Height (slope corrected) [nm]\n" + rows(z="nm"), {}),
    "a total": ("Lateral um,Total Profile um\n" + rows(), {}),
    "units with a colon": ("x (units: um),z (unit: nm)\n" + rows(z="nm"), {}),
    "slash": ("x / mm\tz / nm\n" + rows(x="mm", z="nm", sep="\t"), {}),
    "slash without spaces": ("x/mm z/nm\n" + rows(x="mm", z="nm", sep=" "), {}),
    "a comma within a label": ('"Position, um","Height, nm"\n' + rows(z="nm"), {}),
    "one a micrometre": ("x [um],z [um]\n" + rows(order="nz"), {}),
    "depths of something else": ("Depth resolution 0.1 nm\nRautiefe Rz;1\nx [um],z [um]\n" + rows(), {}),
    "a label left out": ('"No.","Distance","Height"\n"","\u00b5m","\u00b5m"\n' + rows(order="nxz"), {}),
    "a blank label": (" ,Distance (microns),Height (um)\n" + rows(order="nxz"), {}),
    "whole numbers with labels": ("x [um],z [nm]\n" + "".join(f"{i},{i % 7}\n" for i in range(COUNT)), {}),
    "axes with hyphens": ("X-axis [um],Z-axis [nm]\n" + rows(z="nm"), {}),
    "a name before a height": ("x [um],Sample - height [nm]\n" + rows(z="nm"), {}),
    "two returns": (("x [um],z [um]\n" + rows()).replace("\n", "\r\r\n"), {}),
    "two brackets": ("x (lateral) [um],Height (filtered) [nm]\n" + rows(z="nm"), {}),
    "a title of two words": ("x [um]  z [nm]\n".replace("x", "#x") + rows(z="nm", sep="  "), {}),
    "underscore": ("x_um,z_nm\n" + rows(z="nm"), {}),
    "inch": ("x (in),z (inch)\n" + rows(x="inch", z="inch"), {}),
    "inches": ("x (inches),z (um)\n" + rows(x="inch"), {}),
    "Angstrom": ("Lateral (um),Height (Angstrom)\n" + rows(z="angstrom"), {}),
    "Angstrom sign": ("Lateral (um),Height (\u00c5)\n" + rows(z="angstrom"), {}),
    "metres": ("x [m],z [m]\n" + rows(x="m", z="m"), {}),
    "centimetres": ("x [cm],z [um]\n" + rows(x="cm"), {}),
    "upper case": ("X(MM),Z(UM)\n" + rows(x="mm"), {}),
    "quoted": ('"X [um]","Z [um]"\n' + rows(), {}),
    "braces": ("x {mm};z <nm>\n" + rows(x="mm", z="nm", sep=";"), {}),
    # units elsewhere
    "parameters in two columns": ("Profile,Hills\nMode,um\nLateral um,Raw um\n" + rows(), {}),
    "a line of units": ("X,Z\n\u00b5m,nm\n" + rows(z="nm"), {}),
    "a line of units in brackets": ("Position\tHeight\n[mm]\t[um]\n" + rows(x="mm", sep="\t"), {}),
    "a comment": ("# x in mm, z in nm\n" + rows(x="mm", z="nm", sep=" "), {}),
    "lengths in": ("# all lengths in um\n" + rows(sep=" "), {}),
    "X Unit": ("X Unit: mm\nZ Unit: nm\n\n" + rows(x="mm", z="nm"), {}),
    "units of axes in German": ("Einheit X: mm\nEinheit Z: nm\n" + rows(x="mm", z="nm"), {}),
    "units of axes in French": ("Unit\u00e9 X : mm\nUnit\u00e9 Z : \u00b5m\n" + rows(x="mm"), {}),
    "units of axes behind them": ("XUnit: mm\nZUnit: um\n" + rows(x="mm"), {}),
    "Units": ("Units,um\nPoints,200\nx,z\n" + rows(), {}),
    "padded labels": ("# x [mm]    z [nm]\n" + rows(x="mm", z="nm", sep="    "), {}),
    "given": (rows(), UNITS),
    "given as the file has it": ("x [um],z [um]\n" + rows(), UNITS),
    "given for one": ("x [mm],z\n" + rows(x="mm", z="nm"), {"z_unit": "nm"}),
    "the scene's own": (rows(x="m", z="m"), {"scene_units": True}),
    "the scene's own, mm": (rows(x="mm", z="mm"), {"scene_units": True, "length_unit": "mm"}),
    "positions the scene's own, mm": ("x,z [nm]\n" + rows(x="mm", z="nm"), {"scene_units": True, "length_unit": "mm"}),
    "a scene in mm": ("x [um],z [nm]\n" + rows(z="nm"), {"length_unit": "mm"}),
    # encodings
    "Latin-1": ((PARAMETERS + "Lateral \u00b5m,Raw \u00b5m\n" + rows()).encode("latin-1"), {}),
    "UTF-16": (("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("utf-16"), {}),
    "UTF-16, big end first": (b"\xfe\xff" + ("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("utf-16-be"), {}),
    "UTF-16 without a mark": (("x [um],z [um]\n" + rows()).encode("utf-16-le"), {}),
    "UTF-8 with a mark": (("x [\u00b5m],z [\u00b5m]\n" + rows()).encode("utf-8-sig"), {}),
    "decoded once too little": ("x [\u00c2\u00b5m],z [\u00c2\u00b5m]\n" + rows(), {}),
    "line ends": (("x [um],z [um]\n" + rows()).replace("\n", "\r\n"), {}),
    "old line ends": (("x [um],z [um]\n" + rows()).replace("\n", "\r"), {}),
    "a comment below the labels": ("x [um],z [um]\n# measured by me\n" + rows(), {}),
    "labels and a comment, both marked": ("# x [um],z [um]\n# measured by me\n" + rows(), {}),
    # separators and decimals
    "decimal commas, semicolons": ("x [um];z [um]\n" + rows(sep=";", decimal=","), {}),
    "decimal commas, tabs": ("x [um]\tz [um]\n" + rows(sep="\t", decimal=","), {}),
    "decimal commas, spaces": ("x [um]  z [um]\n" + rows(sep="  ", decimal=","), {}),
    "comma and space": ("x [um], z [um]\n" + rows(sep=", "), {}),
    "trailing empty columns": ("x [um],z [um],,\n" + rows(end=" , ,"), {}),
    "trailing semicolons": ("x [um];z [um];\n" + rows(sep=";", decimal=",", end=";"), {}),
    "parameters before": (PARAMETERS + "Lateral um,Raw Micrometer,\n" + rows(end=",,"), {}),
    "blank lines at the end": ("x [um],z [um]\n" + rows() + "\n\n , \n", {}),
    # columns
    "heights first": ("Height [nm],Position [um]\n" + rows(z="nm", order="zx"), {}),
    "an index between labels": ("Index,X [um],Z [um]\n" + rows(order="nxz"), {}),
    "an index, asked for": (rows(order="nxz"), {"columns": "2,3", **UNITS}),
    "heights last": ("X [um],Quality,Height [um]\n" + rows(order="xqz"), {}),
    "a column of heights": ("Height [nm]\n" + rows(z="nm", order="z"), {"scan_length": COUNT * SPACING}),
    "an index and heights": ("Point,Height [nm]\n" + rows(z="nm", order="nz"), {"scan_length": COUNT * SPACING}),
    # positions
    "reversed": ("x [um],z [um]\n" + rows(reverse=True), {}),
    "printed minus signs": ("x [um],z [um]\n" + rows(offset=-1e-5).replace("-", "\u2212"), {}),
    "a kilometre away": ("x [um],z [um]\n" + rows(offset=1000.0, digits=16), {}),
    "a metre before zero": ("x [um],z [um]\n" + rows(offset=-1.0, digits=14), {}),
    "mm and nm": ("x [mm],z [nm]\n" + rows(x="mm", z="nm"), {}),
    "a value left out": ("x [um],z [um]\n" + rows(keep=np.r_[:90, 91:COUNT]), {}),
}

REFUSED = {
    "no header": (rows(), {}, "x_unit and z_unit are missing"),
    "no header, one given": (rows(), {"x_unit": "um"}, "z_unit is missing"),
    "one label without": ("x [um],z\n" + rows(), {}, "z_unit is missing"),
    "labels without units": ("Lateral,Raw\n" + rows(), {}, "x_unit and z_unit are missing"),
    "volts": ("x [um],z [V]\n" + rows(), {}, r"z_unit is missing: .* names no unit of length \(the label 'z \[V\]'\)"),
    "seconds": ("t [s],z [um]\n" + rows(), {}, "x_unit is missing: .* names no unit of length"),
    "two units": ("Z unit: um\nZ unit: nm\nx [um],z\n" + rows(), {}, "z_unit is missing: .* names um .* and nm"),
    "a unit of something else": ("Stylus radius unit: um\nSpeed unit: um/s\nx,z\n" + rows(), {}, "units? .* missing"),
    "a parameter above": ("Stylus radius 2.5 um\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a parameter above two": ("Radius,2.5 um\n" + rows(), {}, "x_unit and z_unit are missing"),
    "another height": ("Stage height in mm: 12\nx in um, z\n" + rows(), {}, "z_unit is missing"),
    "a pipe": (
        rows(sep="|"),
        UNITS,
        r"no table .*; the last line is .*\|.*; allowed: .* by commas, semicolons",
    ),
    "pixels": ("x [pixel],z [um]\n" + rows(), {}, "x_unit is missing: .* names no unit of length"),
    "an exponent of Fortran": ("x [um],z [um]\n" + rows().replace("e-", "D-") + "1,2D0\n", {}, "'1,2D0' is not 2"),
    "units of both": ("Units,um,nm\nx,z\n" + rows(), {}, "x_unit is missing: .* names no unit of length"),
    "two units and tabs": ("Units\tum\tnm\n" + rows(sep="\t"), {}, "x_unit is missing"),
    "one or the other": ("Unit: mm / um\n" + rows(), {}, "x_unit is missing"),
    "heights in counts": (
        "coordinates in mm; heights in counts\n" + rows(),
        {},
        "z_unit is missing: .* names mm .* and no",
    ),
    "a label against a line": ("X unit: mm\nZ unit: nm\n\nx [um],z [um]\n" + rows(), {}, "x_unit is missing: .* mm"),
    "two lines of labels": ("x [mm],z [mm]\num,nm\n" + rows(), {}, "x_unit is missing"),
    "a second axis": (
        "X unit: mm\nY unit: mm\nX,Y,Z\n" + rows(order="xqz"),
        {},
        "columns is missing: .* 'X', 'Y', 'Z'",
    ),
    "a factor": ("x [um],Height x10 nm\n" + rows(), {}, "z_unit is missing"),
    "a factor alone": ("x [um],x10 [nm]\n" + rows(), {}, "z_unit is missing"),
    "a factor of one digit": ("x [um],Height x5 nm\n" + rows(), {}, "z_unit is missing"),
    "a factor before a name": ("x [um],x2 z [nm]\n" + rows(), {}, "z_unit is missing"),
    "a raised digit": ("x [um],z\u00b2 [nm]\n" + rows(), {}, "z_unit is missing"),
    "logarithms to the base two": ("x [um],log2 [nm]\n" + rows(), {}, "z_unit is missing"),
    "gaps or heights": ("x [um],gap [um]\n" + rows(), {}, "profile_convention is missing"),
    "a point among commas": (
        "x [um];z [um]\n" + rows(sep=";", decimal=",") + "32;1.000\n",
        {},
        "line 202: '32;1.000' has a point",
    ),
    "an operator's initials": ("Operator,CM\nx [um],z\n" + rows(), {}, "z_unit is missing"),
    "the time of day": ("Created,Monday 3:15 PM\nLateral um,Raw\n" + rows(), {}, "z_unit is missing"),
    "a filter": ("Filter mm\nx z\n" + rows(sep=" "), {}, "x_unit and z_unit are missing"),
    "a spacing": ("Spacing: 0.5 um\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a date": ("Date 12/03/2022 3:15 PM\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a position in millimetres": ("Height at y=3 mm\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "only the positions": ("All positions in um\n" + rows(), {}, "z_unit is missing"),
    "counts of a converter": ("x [um],Height (nm) per bit\n" + rows(), {}, "z_unit is missing: .* no unit of length"),
    "nanometres for each count": ("x [um],Height (nm)/count\n" + rows(), {}, "z_unit is missing"),
    "logarithms above units": ("x,log z\num,nm\n" + rows(), {}, "z_unit is missing"),
    "a number of no column": (
        "x [um],Height 12 [nm]\n" + rows(),
        {},
        r"x_unit .* \(its line 'x \[um\],Heig.* is not understood as labels",
    ),
    "bits over": ("x [um],Height (nm)/LSB\n" + rows(), {}, "z_unit is missing"),
    "logarithms": ("x [um],log z [nm]\n" + rows(), {}, "z_unit is missing"),
    "a spectral density": ("x [um],PSD [nm]\n" + rows(), {}, "z_unit is missing"),
    "decibels": ("x [um],dB [nm]\n" + rows(), {}, "z_unit is missing"),
    "roots": ("x [um],Wurzel z [nm]\n" + rows(), {}, "z_unit is missing"),
    "numbers that were divided": ("x [um],z [nm] divided by ten\n" + rows(), {}, "z_unit is missing"),
    "a factor behind": ("x [um],Height [um] x 1000\n" + rows(), {}, "z_unit are missing"),
    "a factor in brackets": ("x [um],Height [um] (x1e-3)\n" + rows(), {}, "z_unit is missing"),
    "a count for positions": ("Units: nm\n" + rows(order="nz"), {}, "x_unit is missing: .* may count the values"),
    "rows with placeholders": ("x [um],z [um]\n0.1,---\n" + rows(), {}, "line 2: '0.1,---' looks like a row"),
    "a depth among words": ("x [um],Scan depth [nm]\n" + rows(z="nm"), {}, "profile_convention is missing"),
    "an inverted axis": ("x [um],-z [nm]\n" + rows(z="nm"), {}, "profile_convention is missing"),
    "depths, said above": ("Values are depths\nx [um],z [um]\n" + rows(), {}, "profile_convention is missing"),
    "a comma within quotes": ('Position [um],"Depth, nm"\n' + rows(z="nm"), {}, "z_unit is missing|profile_convention"),
    "a scan along a diagonal": ("x [um],y [um],z [nm]\n" + rows(order="xxz", z="nm"), {}, "columns is missing"),
    "a title that ends like a unit": ("Title,Profile CM\nx,z\n" + rows(), {}, "x_unit and z_unit are missing"),
    "a name that ends like a unit": ("File,Raw_CM\n" + rows(), {}, "x_unit and z_unit are missing"),
    "a title of one column": ("Topography by CM\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a range": ("Height range [um]\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "two ranges": ("Range X [mm],Range Z [mm]\n" + rows(), {}, "x_unit and z_unit are missing"),
    "a cutoff": ("Profile\nCutoff (mm)\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a tolerance": ("Height \u00b15 um\n" + rows(order="z"), {"scan_length": 1.0}, "z_unit is missing"),
    "a factor before": ("x [um],10*z [nm]\n" + rows(z="nm"), {}, "z_unit is missing"),
    "a square": ("x [um],z [nm]^2\n" + rows(z="nm"), {}, "z_unit is missing"),
    "two units in a label": ("x [um],Height [nm] (mm)\n" + rows(z="nm"), {}, "z_unit is missing"),
    "columns against labels": (
        "x [um],z [nm]\n" + rows(z="nm"),
        {"columns": "2,1"},
        "columns is '2,1', but",
    ),
    "a printed minus": ("x [um],\u2212z [nm]\n" + rows(z="nm"), {}, "profile_convention is missing"),
    "heights with a minus": ("x [um],-height [nm]\n" + rows(z="nm"), {}, "profile_convention is missing"),
    "downwards": ("Z axis points down\nx [um],z [um]\n" + rows(), {}, "profile_convention is missing"),
    "a count backwards": ("Units: nm\nx,z\n" + rows(order="nz", reverse=True), {}, "x_unit is missing: .* may count"),
    "a unit of data": ("Data unit: nm\nx,z\n" + rows(), {}, "x_unit and z_unit are missing"),
    "the user against the file": ("x [um],z [um]\n" + rows(), {"z_unit": "nm"}, "z_unit is nm, but .* names um"),
    "three columns": (rows(order="nxz"), UNITS, "columns is missing: .* has 3 columns"),
    "two of heights": ("Raw [um],Filtered [um]\n" + rows(order="zz"), {}, "columns is missing"),
    "heights first, no labels": (rows(order="zx"), UNITS, "columns, like 2,1"),
    "no positions": ("Height [um]\n" + rows(order="z"), {}, "scan_length is missing"),
    "an index for positions": ("Index,Height [um]\n" + rows(order="nz"), {}, "scan_length is missing"),
    "its own length": ("x [um],z [um]\n" + rows(), {"scan_length": 1.0}, "scan_length is 1.0; allowed: none"),
    "decimal or not": ("0,5\n1,7\n2,9\n" * 20, {}, "decimal is missing"),
    "thousands": ("1,234 5,678\n2,345 6,789\n" * 20, UNITS, "decimal is missing"),
    "depths": ("x [um],Depth [um]\n" + rows(), {}, "profile_convention is missing"),
    "a long gap": ("x [um],z [um]\n" + rows(keep=np.r_[:60, 100:COUNT]), {}, "x has a gap of .* of the scan"),
    "too few digits": ("x [um],z [um]\n" + rows(digits=2), {}, "x goes from"),
    "not measured": (
        "x [um],z [um]\n" + rows().replace("\n", "\n0.1,nan\n", 1),
        {},
        "line 3: height is nan; .* delete lines",
    ),
    "a short row of integers": (
        "x [um],z [nm]\n0,1\n1\n" + "".join(f"{i},{i * 7 % 11}\n" for i in range(2, 60)),
        {},
        "line 3: '1' is not 2 numbers",
    ),
    "a word for a value": (
        "x [um],z [um]\n" + rows() + "32,BAD\n",
        {},
        "line 202: '32,BAD' is not 2 numbers.* you may delete lines",
    ),
    "an empty cell": (
        "x [um],z [um]\n" + rows() + "32,\n",
        {},
        "line 202: '32,' is not 2 numbers.* you may delete lines",
    ),
    "commas for all": (
        "".join(f"{i / 2:.2f},{i * 7 % 11 / 100:.2f}\n" for i in range(60)).replace(".", ","),
        UNITS,
        "line 1: commas seem to stand for decimal points and between columns, too, in '0,00,0,00'",
    ),
    "labels for half": (
        "x [um],z [um]\n" + "".join(f"{i},5,{i * 7 % 11},1\n" for i in range(60)),
        {},
        "commas seem to stand for",
    ),
    "a period": ("x [um],z [um]\n" + rows(), {"period": 1e-3}, "period is 0.001; allowed: none"),
}


def write(folder, content):
    path = folder / "scan.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


INTEGERS = "".join(f"{i},{i * 7 % 11}\n" for i in range(60))
PADDED = "".join(f"{i:04},{i * 7 % 11:04}\n" for i in range(60))


@pytest.mark.parametrize(
    ("content", "options"),
    [
        ("Profile of sample A\n" + INTEGERS, {**UNITS, "decimal": "point"}),
        ("Sample A, 2024 May\n" + INTEGERS.replace("\n", ",1,2\n"), {**UNITS, "columns": "1,2"}),
        ("x [um],z [nm]\n" + PADDED, {}),
        (PADDED, {**UNITS, "decimal": "point"}),
    ],
)
def test_integers_between_commas_are_integers(tmp_path, content, options):
    scan = read_scan(write(tmp_path, content), num_points=60, detrend="none", window="none", **options)
    assert scan.indenter.heights.size == 60


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
    spacing = 1e-6 if name == "one a micrometre" else SPACING
    assert scan.period == pytest.approx(COUNT * spacing * length, rel=2e-5 if whole else 1e-4)
    got, expected = scan.indenter.heights / length, HEIGHTS.max() - HEIGHTS
    error = np.abs(got - expected).max()
    assert error < (5e-15 if whole else 0.1 * np.ptp(HEIGHTS)), name


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_the_remedy(tmp_path, name):
    content, options, named = REFUSED[name]
    with pytest.raises(ValueError, match=named):
        read_scan(write(tmp_path, content), **options)
