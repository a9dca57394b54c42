"""How the Warp kernels are written and compiled.

Every array is one-dimensional and padded to a multiple of `CHUNK`; one thread works on one chunk. An inner loop whose
length is a compile-time power of two is what LLVM turns into vector code; a thread per element, a run-time bound or a
tail test stays scalar. The reassociation flags let it vectorise the sums as well.

How wide the vectors are best and how far loops are best interleaved depends on the processor: a kernel with four sums
takes half the time without interleaving where there are 16 vector registers, and a fifth more where there are 32. So
the first process on a processor tries `CANDIDATES` on some of the kernels and keeps what it found beside Warp's
compiled kernels. The variable LINECONTACT_KERNEL_FLAGS, the name of one of them, chooses instead.
"""

import functools
import hashlib
import json
import logging
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from .layout import CHUNK, TOUCHING
from .processor import instructions, processor

_logger = logging.getLogger("linecontact.kernels")

VARIABLE = "LINECONTACT_KERNEL_FLAGS"

_INTERLEAVE = "-mllvm -force-vector-interleave="
CANDIDATES = {
    "default": "",
    "interleave-1": f"{_INTERLEAVE}1",
    "width-256-interleave-4": f"-mprefer-vector-width=256 {_INTERLEAVE}4",
}
"""Flags to choose from, by name; the last where there are wider vectors, which some processors split in two."""

_TRIED = ("plain_sums", "plain_step")  # those whose times depend on it most
_POINTS = 16 * CHUNK  # in the second-level cache, where the code counts and not the memory
_GAIN = 0.97  # of the default's time that another candidate must stay below
_REALS = (np.float32, np.float64)
_CALLS, _ROUNDS = 10, 20


def base() -> str:
    """The flags that all candidates have: Warp's own, and what sums need to become vector code."""
    import warp as wp

    return f"{wp.config.cpu_compiler_flags or ''} -mreassociate -fno-signed-zeros -ffp-contract=fast"


@functools.cache
def flags() -> str:
    """The compiler's flags for the kernels, all of them. Raises `ValueError` for a bad `VARIABLE`."""
    return " ".join([base(), CANDIDATES[chosen()]]).strip()


@functools.cache
def chosen() -> str:
    """Name of the candidate that is best on this processor, or that the user has set. Raises `ValueError`."""
    name = os.environ.get(VARIABLE, "")
    if name and name not in CANDIDATES:
        raise ValueError(f"{VARIABLE} is {name!r}; allowed: {', '.join(CANDIDATES)}")
    return name or _known() or _find()


def _file() -> Path:
    """Where the choice for this processor is kept: with the kernels that Warp has compiled."""
    import warp as wp

    what = [processor(), wp.get_cpu_kernel_cache_key(cpu_compiler_flags=base()), base(), *CANDIDATES.values()]
    key = hashlib.sha256("\n".join(what).encode()).hexdigest()[:16]
    return Path(str(wp.config.kernel_cache_dir)) / f"linecontact-flags-{key}.json"


def _known() -> str:
    """The choice that an earlier process made; empty if there is none, or none that can be read."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        name = json.loads(_file().read_text())["chosen"]
        return name if name in CANDIDATES else ""
    return ""


def _find() -> str:
    """Time the candidates and keep the choice; where another process was faster, its choice."""
    _logger.warning("linecontact: choosing the compiler's flags for this processor, once; this takes some seconds")
    names = [name for name in CANDIDATES if "width" not in name or "avx512f" in instructions()]
    probes = _probes([" ".join([base(), CANDIDATES[name]]).strip() for name in names])
    least = np.full((len(probes), len(probes[0])), np.inf)
    for _ in range(_ROUNDS):  # in turn, so that whatever else the machine does slows all of them
        least = np.minimum(least, [[_seconds(run) for run in runs] for runs in probes])
    relative = dict(zip(names, np.exp(np.log(least / least[0]).mean(axis=1)).tolist(), strict=True))
    best = min(relative, key=lambda name: relative[name])
    best = best if relative[best] < _GAIN else "default"
    with suppress(OSError):  # without a cache it is found again next time
        path = _file()
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            new = Path(folder) / path.name
            new.write_text(json.dumps({"chosen": best, "time over default's": relative}))
            os.link(new, path)  # fails if it is there
    return _known() or best


def _probes(compiled_with: Sequence[str]) -> list[list[Callable[[], Any]]]:
    """For each of these flags some kernels in both precisions, recorded, each several times."""
    import warp as wp

    from .compiled import copy_module

    modules, rng = [copy_module("warp_fire", CHUNK, flags) for flags in compiled_with], np.random.default_rng(0)
    kernels = [[vars(module)[name] for name in _TRIED for _ in _REALS] for module in modules]
    arguments = [
        [_argument(a, real, rng) for a in vars(modules[0])[name].adj.args] for name in _TRIED for real in _REALS
    ]
    for kernel, given in [pair for own in kernels for pair in zip(own, arguments, strict=True)]:
        wp.overload(kernel, [wp.array(dtype=array.dtype) for array in given])
    for module in modules:
        wp.load_module(module, device="cpu")
    return [[_recorded(kernel, given) for kernel, given in zip(own, arguments, strict=True)] for own in kernels]


def _recorded(kernel: Any, arguments: list[Any]) -> Callable[[], Any]:
    import warp as wp

    with wp.ScopedCapture(device="cpu") as capture:
        for _ in range(_CALLS):
            wp.launch(kernel, dim=_POINTS // CHUNK, inputs=arguments, device="cpu")
    wp.capture_launch(capture.graph)
    return functools.partial(wp.capture_launch, capture.graph)


def _argument(argument: Any, real: type, rng: np.random.Generator) -> Any:
    """An array for a kernel's argument, with values like the solver's."""
    import warp as wp

    if argument.label.endswith("_sums") or argument.label == "state":
        return wp.zeros(_POINTS // CHUNK + 32, dtype=wp.float64, device="cpu")
    values = rng.standard_normal(_POINTS)
    if argument.label in ("v", "velocity"):
        values[rng.random(_POINTS) < 0.3] = TOUCHING
    return wp.array(values.astype(real), device="cpu")


def _seconds(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin
