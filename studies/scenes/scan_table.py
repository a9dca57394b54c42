"""A scan as it was understood, in its own units, with the layer beside it: so that a wrong unit is seen at once."""

from linecontact.solver import Scene
from linecontact.solver.units import SCENE

from ..terminal.tables import Whole
from ..terminal.units import UNITS


def table(scene: Scene, over: str = "") -> Whole:
    """Length, spacing, roughness and period of a scan, and the thickness of the layer.

    over: the number of the scene that varies, if one does.
    """
    about = scene.indenter.to_dict()
    own = about["profile_length_unit"]
    along = about.get("profile_x_unit", own)
    heights = about["profile_z_unit"]
    found = Whole(title=f"Scan {about['profile_file']}: {about['profile_values']} values", caption=_caption(about))
    found.add_column("quantity")
    found.add_column("value", justify="right", no_wrap=True)
    found.add_column("unit")

    def add(name: str, length: float, unit: str) -> None:
        size = 1.0 if unit == SCENE else UNITS[unit] / UNITS[own]
        found.add_row(name, f"{length / size:.7g}", "length" if unit == SCENE else unit)

    add("scan length", about["profile_scan_length"], along)
    add("spacing of the values", about["profile_spacing"], along)
    add("rms height about the mean line", about["profile_rms_height"], heights)
    found.add_row("rms slope", f"{about['profile_rms_slope']:.7g}", "-")
    add("period of the scene", scene.period, along)
    if over == "thickness":
        found.add_row("thickness of the layer", "varies", along)
    else:
        add("thickness of the layer", scene.layer.thickness, along)
    return found


def _caption(about: dict[str, str]) -> str:
    x = f"x in {about['profile_x_unit']}" if "profile_x_unit" in about else "no positions"
    return f"Read: {x}, z in {about['profile_z_unit']}, values taken as {about['profile_convention']}."
