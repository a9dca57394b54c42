"""FIRE with an inertia of its own for each mode, so that the iterations do not grow with N.

Each mode gets the acceleration a = M^-1 F with M = K, so that all modes move at one pace. The wall lives in real space
and M^-1 in Fourier space; the order in which they act matters. Here it is a two-metric projection (D. P. Bertsekas,
SIAM J. Control Optim. 20, 221 (1982)):

    a = P M^-1 P r,   P = restriction to the free nodes.

Without the first P the wall's force leaks into the motion, without the second held nodes drift off the wall; either way
the fixed point is wrong. The mean mode has no stiffness and gets the softest mode's mass, min K.

The step. On the free nodes the spectrum of P M^-1 P K P is 1 but for a few outliers that the contact edges make; for an
incompressible thin layer one of them grows like a/d. dt_max = safety/sqrt(lambda_max), with lambda_max from a few power
iterations that are repeated as the contact changes.
"""

import math

import numpy as np

from ...kernels import Call, sequence
from .fire import begin_fire
from .fire_state import Fire, Operator
from .method import PATIENCE, MethodKind


class MassWeightedFire(Fire):
    """FIRE with M = K. It also stores the force and a vector for estimating lambda_max; `work` holds the acceleration.

    Once dt_max is safe by measurement, Bitzek's halving of dt at every turn only loses time: on 46 scenes n_min = 1 and
    f_dec = 0.8 needed 0.78 of the transforms of 5 and 0.5.
    """

    n_min, f_dec = 1, 0.8
    pairs_per_iteration = 2
    buffers = 10
    probe_every, probe_steps = 100, 6  # iterations between estimates of lambda_max, power iterations in each

    @property
    def patience(self) -> int | None:
        return PATIENCE  # the pace does not depend on N

    def _prepare(self, own_load: bool) -> None:
        self.force, self.probe, self.load = (self.transforms.buffer() for _ in range(3))
        self.load[:] = 1
        mass = self.problem.stiffness.copy()
        mass[0] = mass[1:].min()
        self._apply_inverse_mass = self._operator(self.force, 1 / mass)
        forward, probe, free = self.transforms.forward(self.probe), self.probe, self.work

        def keep() -> None:
            probe[:] = free  # it is free once the force is known

        self._probe_stiffness = forward, *self._apply_stiffness[1:], keep
        self._probe_inverse_mass = forward, *self._apply_inverse_mass[1:], keep
        self._squares = squares = self.transforms.sums(self.u.size)  # free for the probe, between two steps
        arrays = {"force": self.force, "load": self.load, "acceleration": self.work, "acceleration_sums": squares}
        arrays |= self._arrays()
        record = self.transforms.record
        self._find_force = record(sequence("find_force", arrays))
        self._move = record(sequence("mass_weighted_move", arrays))
        self._restrict = record([Call("restrict_to_free", (self.force,), (self.probe, squares))])

    @property
    def parts(self) -> Operator:
        return *self._apply_stiffness, self._find_force, *self._apply_inverse_mass, self._move

    def step(self) -> None:
        self._apply(self._apply_stiffness)
        self._find_force()
        if self.iteration % self.probe_every == 0:
            self._measure_stiffest()
        self._apply(self._apply_inverse_mass)
        self._move()
        self.after_step()

    def _measure_stiffest(self) -> None:
        """lambda_max of P M^-1 P K P on the present free nodes by power iterations on `probe`, kept for next time."""
        if not self.probe.any():
            self.transforms.put(self.probe, np.random.default_rng(0).standard_normal(self.num_points))
            self._apply(self._probe_inverse_mass)  # white noise is mostly stiff modes: smooth it
            self._project_probe()
        growth = 1.0
        for _ in range(self.probe_steps):
            self._apply(self._probe_stiffness)
            self._restrict()
            self._apply(self._probe_inverse_mass)
            growth = self._project_probe()
        if math.isfinite(growth):
            self._limit_step(max(growth, 1.0), 1.0)  # no mode is softer than its mass: a longer step gains nothing

    def _project_probe(self) -> float:
        """Restrict `probe` to the free nodes and scale it to norm 1; the norm before scaling."""
        self._restrict()
        norm = math.sqrt(self._squares.sum())
        if norm > 0:
            self.probe /= self.probe.dtype.type(norm)
        return norm


KIND = MethodKind(
    name="mass-weighted-fire",
    label="mass-weighted FIRE",
    begin=lambda problem, config: begin_fire(MassWeightedFire, problem, config),
    max_iterations=20_000,
    precisions=("float64", "float32", "mixed"),
    devices=("cpu", "cuda"),
    share=0.25,
)
