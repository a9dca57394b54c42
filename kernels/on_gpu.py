"""The Warp kernels on a GPU: compiled from the same source in the form that suits it, and launched on CuPy's arrays.

Nothing here is imported unless a GPU is asked for. A launch only puts the kernel into the queue of Warp's stream.
"""

import importlib
from collections.abc import Callable, Sequence
from typing import Any

from ..locks import once
from .compiled import GPU_BLOCK, MODULES, ON_CPU_ONLY, compile_modules, copy_module, start_warp
from .layout import FOLDED, PARTS
from .record import Call

CHUNK, LANES = 64, GPU_BLOCK
"""Points of a thread, and threads whose points take turns: of six pairs from 8 to 64 and from 32 to 256, measured on
one H100, the one with which every kernel reaches 0.9 of the copy bandwidth or more, in float32, too."""
SPAN = CHUNK * LANES
"""Points of so many threads, of which an array's length is a multiple."""


@once
def load() -> dict[str, Any]:
    """Compile every kernel for the GPU, or fetch it from Warp's kernel cache; Warp's kernels by name."""
    start_warp()
    copies = [copy_module(name, CHUNK, "", LANES) for name in MODULES if name not in ON_CPU_ONLY]
    return compile_modules([*copies, importlib.import_module(f"{__package__}.warp_folds")], "cuda")


def prepare(calls: Sequence[Call]) -> Callable[[], None]:
    """A function without arguments that launches `calls` in order; their arrays are CuPy's.

    Before FIRE's control step the chunks' sums are folded.
    """
    import cupy
    import warp as wp

    kernels, commands = load(), []

    def add(name: str, threads: int, inputs: Sequence[Any], outputs: Sequence[Any]) -> None:
        given = [[wp.array(array, copy=False) for array in arrays] for arrays in (inputs, outputs)]
        how = {"inputs": given[0], "outputs": given[1], "device": "cuda", "block_dim": GPU_BLOCK}
        command = wp.launch(kernels[name], dim=threads, record_cmd=True, **how)
        commands.append((command, given))  # the queue holds the arrays' addresses only

    for call in calls:
        if call.kernel == "fire_control":
            folded = cupy.zeros((PARTS + 1) * FOLDED)
            add("fold_sums", folded.size * GPU_BLOCK, call.inputs, [folded])
            add("fire_control", 1, cupy.split(folded, [PARTS * FOLDED]), call.outputs)
        else:
            add(call.kernel, call.inputs[0].size // CHUNK, call.inputs, call.outputs)

    def launch() -> None:
        for command, _ in commands:
            command.launch()

    return launch
