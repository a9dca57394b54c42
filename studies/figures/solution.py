"""The figure of a single solution."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ..files import solution_files
from .style import COLOURS


def draw(path: Path) -> dict[str, Figure]:
    """Profile, displaced surface and contact pressure over x; the contact region enlarged."""
    fields, attributes = solution_files.load_solution(path)
    x, pressure = fields["x"], fields["contact_pressure"]
    figure, panels = plt.subplots(2, 1, figsize=(5.2, 4.6), sharex=True)
    panels[0].plot(x, fields["profile"], color="k", lw=0.9, label="indenter $h$")
    panels[0].plot(x, fields["displacement"], color=COLOURS[0], lw=0.9, label="surface $u$")
    panels[0].set(ylabel="height [length]", title=_title(attributes))
    panels[0].legend(fontsize=8)
    panels[1].plot(x, pressure, color=COLOURS[3], lw=0.9)
    panels[1].set(xlabel="$x$ [length]", ylabel="contact pressure [pressure]")
    touching = np.flatnonzero(pressure > 0)
    if touching.size:
        left, right = x[touching[0]], x[touching[-1]]
        margin = 0.5 * (right - left) + 4 * (x[1] - x[0])
        window = (max(x[0], left - margin), min(x[-1], right + margin))
        inside = (x >= window[0]) & (x <= window[1])
        heights = np.concatenate([fields["profile"][inside], fields["displacement"][inside]])
        room = 0.05 * float(np.ptp(heights)) or 1.0
        panels[0].set(xlim=window, ylim=(heights.min() - room, heights.max() + room))
    return {"": figure}


def _title(attributes: dict[str, Any]) -> str:
    ratio = attributes.get("scene.poisson_ratio")  # not every layer has one
    layer = f"d = {float(attributes['scene.thickness']):.4g} [length]" + (
        f", nu = {ratio:g}" if ratio is not None else ""
    )
    return f"{layer}, a_r = {attributes['contact_area_subgrid']:.6g}, {attributes['status']}"
