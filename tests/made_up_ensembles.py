"""Samples of an ensemble that cost nothing to solve, with a known mean; and a scene with a rough surface."""

import math

import numpy as np
from linecontact.solver import Layer, RoughIndenter, Scene
from linecontact.studies.multilevel import allocation
from linecontact.studies.multilevel.allocation import Wanted
from linecontact.studies.multilevel.samples import FOUNDATION

SIZES = (256, 512, 1024, 2048)
COSTS = {size: size / 256 for size in SIZES} | {FOUNDATION: 0.02}  # [s]
TRUTH = 1.7
"""Mean of the made-up observable on an infinitely fine grid."""


def made_up(seed, size, scatter=0.05, change=20.0, told=0.9):
    """kappa of a surface on a grid: a scatter of its own, and an error that falls like 1/N. On a foundation, which
    tells that share of the variance, it is something else, and not on a straight line with it.
    """
    own, error, other = np.random.default_rng(seed).standard_normal(3)
    if size == FOUNDATION:
        return 3 + np.exp(0.3 * (math.sqrt(told) * own + math.sqrt(1 - told) * other))
    return TRUTH + scatter * own + change * (1 + 0.5 * error) / size


def solved(batches, **options):
    return [
        {"status": "converged", "seed": seed, "num_points": size, "seconds.total": COSTS[size]}
        | {"kappa_subgrid": made_up(seed, size, **options), "contact_area_subgrid": 0.0}
        for batch in batches
        for seed in range(batch.first, batch.first + batch.count)
        for size in batch.sizes
    ]


def sampled(wanted, seed=0, sizes=SIZES, **options):
    """All rows and the last state of a made-up ensemble."""
    rows = []
    while (now := allocation.state(rows, sizes, wanted, seed)).batches:
        new = solved(now.batches, **options)
        assert not {(row["seed"], row["num_points"]) for row in new} & {(r["seed"], r["num_points"]) for r in rows}
        rows += new
    return rows, now


def wanted(error, relative=False, seconds=math.inf, most=10**9):
    return Wanted(("kappa",), error, relative, seconds, most)


SURFACE = RoughIndenter(0.8, 5, cut_off_ratio=1 / 8)
SCENE = Scene(Layer(0.1), SURFACE, 0.02, num_points=2**11)
