"""How the Warp kernels are written and compiled.

Every array is one-dimensional and padded to a multiple of `CHUNK`; one thread works on one chunk. An inner loop whose
length is a compile-time power of two is what LLVM turns into vector code; a thread per element, a run-time bound or a
tail test stays scalar. The reassociation flags let it vectorise the sums as well. On a GPU the points of `LANES`
threads take turns instead (`on_gpu`); on the CPU that is one thread.

How wide vectors and how much interleaving are best depends on the kernel and on the processor: on an AMD Zen 3, with
16 vector registers, `plain_sums` takes 0.65 of the time without interleaving, and all other kernels are best left
alone; with 32 registers of 512 bits narrower vectors and more interleaving can be better. So the first process on a
processor tries `CANDIDATES` on some kernels of each module and keeps what it found beside Warp's compiled kernels. The
variable LINECONTACT_KERNEL_FLAGS, the name of one of them, chooses for all modules instead.
"""

import functools
import hashlib
import json
import logging
import os
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from .layout import CHUNK, TOUCHING
from .module_copies import copy_module
from .processor import instructions, processor
from .recording import record_launches

_logger = logging.getLogger("linecontact.kernels")

VARIABLE = "LINECONTACT_KERNEL_FLAGS"

_INTERLEAVE = "-mllvm -force-vector-interleave="
CANDIDATES = {
    "default": "",
    "interleave-1": f"{_INTERLEAVE}1",
    "width-256-interleave-4": f"-mprefer-vector-width=256 {_INTERLEAVE}4",
}
"""Flags to choose from, by name; a width is tried where there are wider vectors, which some processors split in two."""

_TRIED = {
    "warp_sums": (("plain_sums", "net_force"), tuple(CANDIDATES)),
    "warp_fire": (("plain_step", "restrict_to_free"), ("default", "width-256-interleave-4")),
}
"""By module, the kernels that are timed and the candidates for them. The rest is compiled like `warp_fire`."""

_POINTS = 16 * CHUNK  # in the second-level cache, where the code counts and not the memory
_GAIN = 0.97  # of the default's time that another candidate must stay below
_REALS = (np.float32, np.float64)
_CALLS, _ROUNDS = 10, 20


def base() -> str:
    """The flags that all candidates have: Warp's own, and what sums need to become vector code."""
    import warp as wp

    return f"{wp.config.cpu_compiler_flags or ''} -mreassociate -fno-signed-zeros -ffp-contract=fast".strip()


@functools.cache
def flags() -> dict[str, str]:
    """The compiler's flags for the kernels, all of them, by module. Raises `ValueError` for a bad `VARIABLE`."""
    found = {module: " ".join([base(), CANDIDATES[name]]).strip() for module, name in chosen().items()}
    return found | dict.fromkeys(("warp_fields", "warp_columns"), found["warp_fire"])


_lock = threading.RLock()


@functools.cache
def chosen() -> dict[str, str]:
    """Names of the candidates that are best on this processor by module, or what the user set. Raises `ValueError`."""
    name = os.environ.get(VARIABLE, "")
    if name and name not in CANDIDATES:
        raise ValueError(f"{VARIABLE} is {name!r}; allowed: {', '.join(CANDIDATES)}")
    with _lock:  # of several threads one finds out
        return dict.fromkeys(_TRIED, name) if name else _known() or _find()


def _file() -> Path:
    """Where the choice for this processor is kept: with the kernels that Warp has compiled."""
    import warp as wp

    sources = [Path(__file__).with_name(f"{module}.py").read_text() for module in _TRIED]
    what = [processor(), wp.get_cpu_kernel_cache_key(cpu_compiler_flags=base()), base(), CANDIDATES, _TRIED, sources]
    key = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:16]
    return Path(str(wp.config.kernel_cache_dir)) / f"linecontact-flags-{key}.json"


def _known() -> dict[str, str]:
    """The choice that an earlier process made; empty if there is none, or none that can be read."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        names = json.loads(_file().read_text())["chosen"]
        found = {module: names[module] for module in _TRIED}
        return found if set(found.values()) <= CANDIDATES.keys() else {}
    return {}


def _find() -> dict[str, str]:
    """Time the candidates and keep the choice; where another process was faster, its choice."""
    wide = "avx512f" in instructions()
    found, measured = dict.fromkeys(_TRIED, "default"), {}
    for module, (kernels, candidates) in _TRIED.items():
        names = [name for name in candidates if wide or "width" not in name]
        if len(names) > 1:
            measured[module] = relative = _relative_times(module, kernels, names)
            best = min(relative, key=lambda name: relative[name])
            found[module] = best if relative[best] < _GAIN else "default"
    with suppress(OSError):  # without a cache it is found again next time
        path = _file()
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            new = Path(folder) / path.name
            new.write_text(json.dumps({"chosen": found, "time over default's": measured}))
            if not _known():
                new.replace(path)
    return _known() or found


def _relative_times(module: str, kernels: Sequence[str], names: Sequence[str]) -> dict[str, float]:
    """Geometric means of some kernels' times over those with the first candidate, by candidate."""
    _logger.warning("linecontact: choosing the compiler's flags for this processor, once; this takes some seconds")
    probes = [_probes(module, kernels, " ".join([base(), CANDIDATES[name]]).strip()) for name in names]
    least = np.full((len(probes), len(probes[0])), np.inf)
    for _ in range(_ROUNDS):  # in turn, so that whatever else the machine does slows all of them
        least = np.minimum(least, [[_seconds(run) for run in runs] for runs in probes])
    return dict(zip(names, np.exp(np.log(least / least[0]).mean(axis=1)).tolist(), strict=True))


def _probes(name: str, kernels: Sequence[str], compiled_with: str) -> list[Callable[[], Any]]:
    """Some kernels of a module in both precisions, compiled with these flags and recorded, each several times."""
    import warp as wp

    module, rng = copy_module(name, CHUNK, compiled_with), np.random.default_rng(0)
    pairs = [(vars(module)[kernel], real) for kernel in kernels for real in _REALS]
    arguments = [[_argument(a, real, rng) for a in kernel.adj.args] for kernel, real in pairs]
    for (kernel, _), given in zip(pairs, arguments, strict=True):
        wp.overload(kernel, [wp.array(dtype=array.dtype) for array in given])
    wp.load_module(module, device="cpu")
    launches = [(kernel, _POINTS // CHUNK, given, ()) for (kernel, _), given in zip(pairs, arguments, strict=True)]
    probes = [record_launches([launch], _CALLS) for launch in launches]
    for probe in probes:
        probe()
    return probes


def _argument(argument: Any, real: type, rng: np.random.Generator) -> Any:
    """An array for a kernel's argument, with values like the solver's."""
    import warp as wp

    if argument.label.endswith("_sums") or argument.label in ("state", "squares"):
        return wp.zeros(_POINTS // CHUNK + 32, dtype=wp.float64, device="cpu")
    values = rng.standard_normal(_POINTS)
    if argument.label in ("v", "velocity"):
        values[rng.random(_POINTS) < 0.3] = TOUCHING
    return wp.array(values.astype(real), device="cpu")


def _seconds(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin
