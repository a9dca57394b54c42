"""The two nearest peers, tamaas and ContactMechanics, as functions of our scene; and the yardstick for every solver.

Both are optional (pip install tamaas ContactMechanics). Neither has a layer in line contact of its own: both are given
the scene's heights and the layer's stiffness. Both run the Polonsky-Keer conjugate gradients that they offer for a
prescribed mean pressure, on one thread (measured, ContactMechanics' other solver, Bugnicourt's, takes as long or up to
four times longer here).

Their tolerances mean different things. Common to them is the rms gap inside the contact over that of the heights
(`gap_rms`), recomputed from the pressure alone.
"""

import importlib.util
import math
import time
from dataclasses import dataclass
from importlib.metadata import version
from types import SimpleNamespace

import numpy as np
from linecontact.solver import Scene
from linecontact.solver.arrays import Array64
from linecontact.solver.grid.layer_on_grid import half_spectrum
from linecontact.solver.methods import Progress

PEERS = ("tamaas", "ContactMechanics")
OURS = "linecontact"
"""Names of the solvers in the records."""

_LOOSEST, _TIGHTEST = 1e-4, 1e-12  # tolerances that are tried
_MAX_ITERATIONS = 20_000


@dataclass(frozen=True)
class PeerResult:
    """The result of a peer, and the time it took."""

    contact_pressure: Array64
    """Shape (N,) [pressure]."""
    seconds: float
    """Time of solving, without set-up [s]."""
    setup_seconds: float
    """Time of making the model, the heights and the stiffness, without imports [s]."""
    iterations: float
    """NaN where unknown."""
    version: str
    """Version of the peer."""


def available() -> tuple[str, ...]:
    """Names of the peers that are installed."""
    return tuple(peer for peer in PEERS if importlib.util.find_spec(peer))


def solve(peer: str, scene: Scene, tolerance: float, progress: Progress | None = None) -> PeerResult:
    """Solve a scene with a peer of `PEERS`, on one thread, from its own cold start.

    tolerance: the peer's own, dimensionless. tamaas: its error of complementarity; ContactMechanics: largest gap inside
    the contact over the rms height. progress: called with (iteration, nan).

    The result may be short of the tolerance: see `gap_rms`. Raises `ValueError` for a peer that is unknown or missing.
    """
    if peer not in available():
        raise ValueError(f"peer is {peer!r}; allowed: {', '.join(PEERS)}, with `pip install tamaas ContactMechanics`")
    return {"tamaas": _tamaas, "ContactMechanics": _contact_mechanics}[peer](scene, tolerance, progress)


def _stiffness(scene: Scene) -> Array64:
    """K(q_k), shape (N//2 + 1,) [pressure/length]."""
    layer = scene.layer
    k = half_spectrum(layer, scene.num_points, scene.period)
    return k * (layer.contact_modulus / scene.period)


class _Count:
    """Counts its calls, and reports the count about ten times a second."""

    def __init__(self, progress: Progress | None) -> None:
        self.calls, self._progress, self._said = 0, progress, time.monotonic()

    def __call__(self, *_: object, **__: object) -> None:
        self.calls += 1
        if self._progress and time.monotonic() - self._said > 0.1:
            self._said = time.monotonic()
            self._progress(self.calls, math.nan)


def _tamaas(scene: Scene, tolerance: float, progress: Progress | None) -> PeerResult:
    import tamaas

    class Nothing(tamaas.Functional):  # type: ignore[misc]
        """Adds nothing to the minimised energy, but is asked for its gradient every iteration; Ctrl-C gets in there."""

        def computeF(self, *_: object) -> float:  # noqa: N802
            return 0.0

        def computeGradF(self, *_: object) -> None:  # noqa: N802
            count()

    count = _Count(progress)
    tamaas.initialize(1)
    tamaas.set_log_level(tamaas.LogLevel.error)
    begin = time.perf_counter()
    model = tamaas.Model(tamaas.model_type.basic_1d, [scene.period], [scene.num_points])
    model.E, model.nu = scene.layer.contact_modulus, 0.0
    solver, nothing = tamaas.PolonskyKeerRey(model, -scene.profile, tolerance), Nothing()
    solver.addFunctionalTerm(nothing)
    solver.max_iter = _MAX_ITERATIONS
    compliance = 1 / _stiffness(scene)[1:]
    for name in model.operators:
        if name.lower().endswith("neumann"):
            np.asarray(model.operators[name]["influence"]).reshape(-1)[1:] = compliance
    ready = time.perf_counter()
    solver.solve(scene.pressure)
    end = time.perf_counter()
    pressure = np.array(model.traction, dtype=np.float64).reshape(-1)
    return PeerResult(pressure, end - ready, ready - begin, count.calls - 1, version("tamaas"))


def _contact_mechanics(scene: Scene, tolerance: float, progress: Progress | None) -> PeerResult:
    import ContactMechanics
    from SurfaceTopography import UniformLineScan

    class Given(ContactMechanics.PeriodicFFTElasticHalfSpace):  # type: ignore[misc]
        def _compute_greens_function(self) -> Array64:
            k = _stiffness(scene)
            k[0] = k[1]  # as the library has it; the mean pressure is prescribed
            return 1 / k

    begin = time.perf_counter()
    heights = scene.profile
    substrate = Given(scene.num_points, scene.layer.contact_modulus, scene.period)
    surface = UniformLineScan(-heights, physical_sizes=scene.period, periodic=True)
    system = ContactMechanics.make_system(substrate=substrate, surface=surface)
    ready = time.perf_counter()
    result = system.minimize_proxy(
        external_force=scene.pressure * scene.period,
        pentol=tolerance * float(heights.std()),
        thermotol=1.0,  # else the offset's change decides, and the gap comes out far smaller than asked
        maxiter=_MAX_ITERATIONS,
        logger=SimpleNamespace(st=_Count(progress), pr=lambda _: None),  # its callback would take time of its own
    )
    end = time.perf_counter()
    pressure = np.maximum(np.asarray(result.jac).reshape(-1), 0.0) / substrate.area_per_pt
    return PeerResult(pressure, end - ready, ready - begin, result.nit, version("ContactMechanics"))


def gap_rms(scene: Scene, contact_pressure: Array64) -> float:
    """Rms gap inside the contact over the rms height, of any solver's contact pressure, shape (N,) [pressure].

    Recomputed with numpy.fft from the pressure alone: gap = heights + displacement under it, up to the rigid approach,
    which makes the gap's mean, weighted by the pressure, 0. Dimensionless; inf without a contact. Raises `ValueError`.
    """
    pressure = np.asarray(contact_pressure, dtype=np.float64)
    if pressure.shape != (scene.num_points,) or not np.isfinite(pressure).all():
        raise ValueError(
            f"contact_pressure has shape {pressure.shape}; allowed: {scene.num_points} finite numbers, the scene's grid"
        )
    contact, heights = pressure > 0, scene.profile
    if not contact.any():
        return math.inf
    modes = np.fft.rfft(pressure)  # not through the solver's own transforms, whose errors it is to show, too
    modes[0] = 0
    modes[1:] /= _stiffness(scene)[1:]
    gap = (heights + np.fft.irfft(modes, scene.num_points))[contact]
    gap -= np.average(gap, weights=pressure[contact])
    return float(np.sqrt(np.mean(gap**2)) / heights.std())


def at_gap(peer: str, scene: Scene, limit: float, progress: Progress | None = None) -> tuple[PeerResult, float]:
    """A peer's result at the loosest tolerance with a `gap_rms` within `limit`, and that tolerance (dimensionless).

    Tolerances a factor of 2 apart are tried; if none will do, the result is that at the tightest one.
    """

    def attempt(tolerance: float) -> tuple[PeerResult, bool]:
        result = solve(peer, scene, tolerance, progress)
        return result, gap_rms(scene, result.contact_pressure) <= limit

    tolerance = 2 * limit
    result, met = attempt(tolerance)
    while met and 2 * tolerance <= _LOOSEST:
        looser, still = attempt(2 * tolerance)
        if not still:
            return result, tolerance
        result, tolerance = looser, 2 * tolerance
    while not met and tolerance / 2 >= _TIGHTEST:
        tolerance /= 2
        result, met = attempt(tolerance)
    return result, tolerance
