"""What is measured on a solution: area, gradient, reduced pressure, coefficient, approach."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .closed_forms import kappa_half_space
from .scene import Scene
from .stiffness import foundation_modulus

Array64 = NDArray[np.float64]


@dataclass(frozen=True)
class Observables:
    """Dimensionless unless a unit is given.

    contact_area: a_r, nodes in contact over all nodes. A node more or less is 1/N.
    rms_gradient_contact: g_c, rms of h' over the contact.
    reduced_pressure: p* = p/(E* g_c); inf where the contact is one node, whose slope is 0.
    kappa: a_r/p*, nan for one node; kappa_ratio: kappa over kappa_inf(n) of the half-space.
    reduced_thickness: d/(a_r L).
    approach: rigid approach since first touch [length]: mean(u) + p/k_W; for a half-space mean(u), by convention.
    peak_pressure: largest contact pressure [pressure].
    """

    contact_area: float
    rms_gradient_contact: float
    reduced_pressure: float
    kappa: float
    kappa_ratio: float
    reduced_thickness: float
    approach: float
    peak_pressure: float


def observe(scene: Scene, displacement: Array64, contact_pressure: Array64, contact: NDArray[np.bool_]) -> Observables:
    """Observables of a displacement [length] and contact pressure [pressure], both shape (N,)."""
    slope = scene.indenter.slope(scene.num_points, scene.period)[contact]
    area = float(contact.mean())
    gradient = math.sqrt(float(slope @ slope) / slope.size) if slope.size else 0.0
    reduced = scene.pressure / scene.layer.contact_modulus / gradient if gradient else math.inf
    kappa = area / reduced if gradient else math.nan
    layer = scene.layer
    modulus = foundation_modulus(layer.thickness, layer.poisson_ratio) * layer.contact_modulus  # 0 for a half-space
    return Observables(
        contact_area=area,
        rms_gradient_contact=gradient,
        reduced_pressure=reduced,
        kappa=kappa,
        kappa_ratio=kappa / kappa_half_space(scene.indenter.exponent),
        reduced_thickness=layer.thickness / (area * scene.period) if area else math.inf,
        approach=float(displacement.mean()) + (scene.pressure / modulus if modulus else 0.0),
        peak_pressure=float(contact_pressure.max(initial=0.0)),
    )
