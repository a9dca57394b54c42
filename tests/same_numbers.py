"""Shows that a change of the code leaves its numbers alone: 200 random scenes, solved by two versions and compared.

    python tests/same_numbers.py record before.npz    (with the version before the change installed)
    python tests/same_numbers.py record after.npz     (with the version after it)
    python tests/same_numbers.py compare before.npz after.npz

The scenes go over all methods, precisions, indenters, grids, starts and accuracies. The same are expected to be: the
nodes in contact, the contact pressure to the last bit (the largest relative difference is printed), iterations,
transform pairs, the status, and the reason of a refusal or of an unfinished solve. The exit status is 1 if anything
but the words of a reason differs.
"""

import json
import os
import sys
import tempfile

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp()  # FFTW's stored plans would change the rounding

import numpy as np
from linecontact.solver import Layer, MeasuredIndenter, PowerIndenter, RoughIndenter, Scene, solve

METHODS = ("active-set", "mass-weighted-fire", "fire")
PRECISIONS = ("float64", "float32", "mixed")
COUNT = 200


def draw(number):
    """One scene as (arguments of `Scene`, options of `solve`); both may be refused."""
    rng = np.random.default_rng([2024, number])
    method = str(rng.choice(METHODS, p=(0.6, 0.2, 0.2)))
    log2_points = rng.uniform(2, 12) if method != "active-set" else rng.uniform(3, 15 if number % 20 else 18)
    n = int(2 ** round(log2_points)) if rng.random() < 0.5 else max(4, round(2**log2_points))
    options = {"method": method}
    precision = str(rng.choice(PRECISIONS, p=(0.5, 0.25, 0.25)))
    if number % 5 == 0:
        precision, options = "float64", {"accuracy": float(10 ** rng.uniform(-6, -1.3))}
        n = round(2 ** rng.uniform(9, 17)) // 4 * 4
    elif method != "active-set":
        options["max_iterations"] = int(rng.choice([50, 3000], p=(0.2, 0.8)))
    elif rng.random() < 0.1:
        options["max_iterations"] = 3
    if "method" in options:
        if rng.random() < 0.3:
            options["tolerance"] = float(10 ** rng.uniform(-13, -2))
        if rng.random() < 0.3:
            options["nested"] = bool(rng.integers(2))
        if rng.random() < 0.1:
            options["initial"] = 10 ** rng.uniform(-9, 0) * rng.standard_normal(n)
    if rng.random() < 0.3:
        options["backend"] = "numpy"
    nu = float(rng.choice([-0.5, 0.0, 0.25, 0.4, 0.49, 0.5])) if rng.random() < 0.8 else float(rng.uniform(-0.99, 0.5))
    thickness = float("inf") if rng.random() < 0.3 else float(10 ** rng.uniform(-6, 1))
    load = 10 ** rng.uniform(-6, -0.5)
    kind = rng.integers(4)
    if kind == 0:
        indenter = PowerIndenter(float(rng.choice([1.5, 2, 4, 3.3])), float(10 ** rng.uniform(-1, 1)))
    elif kind == 1:
        waves = max(2, round((n // 2 - 1) ** rng.uniform(0.3, 0.9)))
        indenter = RoughIndenter(float(rng.uniform(0.2, 1)), number, 0.5, 2 / waves, float(10 ** rng.uniform(-1, 1)))
    else:
        heights = np.cumsum(rng.standard_normal(n)) / n
        if rng.random() < 0.5:  # smooth
            modes = np.fft.rfft(heights)
            heights = np.fft.irfft(modes * np.exp(-np.arange(modes.size) / 4), n)
        if kind == 3 and n % 2 == 0:  # a scan joined to its mirror image
            heights[n // 2 :] = heights[: n // 2][::-1]
        indenter = MeasuredIndenter(heights, convention="gap")
        load *= 0.1
    layer = Layer(thickness, nu, float(rng.choice([1.0, 3.7e6])))
    scene = {"layer": layer, "indenter": indenter, "pressure": load * layer.contact_modulus, "num_points": n}
    return scene | {"precision": precision}, options


def outcome(number):
    """Facts of one scene, JSON-ready, and the contact pressure, shape (N,), empty for a refusal."""
    scene, options = draw(number)
    try:
        solution = solve(Scene(**scene), **options)
    except ValueError as error:
        return {"refused": str(error)}, np.zeros(0)
    o = solution.observables
    return {
        "status": str(solution.status),
        "reason": str(solution.reason or ""),
        "method": solution.method,
        "nodes": np.flatnonzero(solution.contact).tolist(),
        "iterations": solution.iterations,
        "transform_pairs": round(solution.transform_pairs, 9),
        "tolerance": solution.tolerance,
        "handed_over": solution.handed_over,
        "points": solution.scene.num_points,
        "area": o.contact_area_subgrid,
        "area_error": o.contact_area_error,
        "choices": [[c.what, c.chosen] for c in solution.choices],
    }, solution.contact_pressure


def record(path):
    """Solve every scene and store what came out."""
    facts, pressures = [], {}
    for number in range(COUNT):
        fact, pressures[f"pressure{number}"] = outcome(number)
        facts.append(fact)
        if number % 20 == 19:
            print(f"{number + 1} of {COUNT}", file=sys.stderr)
    np.savez_compressed(path, facts=json.dumps(facts), **pressures)


def compare(before, after):
    """Print every difference; 1 if there is one that counts."""
    old, new = np.load(before), np.load(after)
    bad, worst = 0, 0.0
    for number, (a, b) in enumerate(zip(json.loads(str(old["facts"])), json.loads(str(new["facts"])), strict=True)):
        p, q = old[f"pressure{number}"], new[f"pressure{number}"]
        different = {name for name in a.keys() | b.keys() if a.get(name) != b.get(name)}
        off = np.inf if p.shape != q.shape else float(np.abs(p - q).max() / np.abs(p).max()) if p.size else 0.0
        worst = max(worst, off)
        bad += bool(different - {"reason", "refused", "area_error", "choices"} or off > 1e-13)
        for name in sorted(different):
            print(f"scene {number}: {name}: {str(a.get(name))[:150]} -> {str(b.get(name))[:150]}")
        if off:
            print(f"scene {number}: pressure differs by {off:.1g}, method {a.get('method')}, {a.get('points')} points")
    print(f"{bad} of {COUNT} scenes differ; largest relative difference of the pressure {worst:.1g}")
    return int(bad > 0)


if __name__ == "__main__":
    command, *files = sys.argv[1:]
    sys.exit({"record": record, "compare": compare}[command](*files))
