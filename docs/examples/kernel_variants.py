"""Variants of kernels, of a sequence and of a whole iteration, each measured beside the program's own:

    linecontact study kernels --variants docs/examples/kernel_variants.py --kernel restrict_to_free --size 2^18

A line that registers a variant, or a function that builds one, is all there is to it.
"""

from typing import Any

import warp as wp
from linecontact import kernels
from linecontact.kernels.warp_fire import CHUNK_LENGTH
from linecontact.studies.kernel_benchmark.variants import Arrays, Runs, launched, recompiled, replanned, variant

# The program's kernels with another number of points for each thread, and with each of the flags that were tried.
recompiled("fire_step", "chunk-256", chunk=256)
recompiled("fire_step", "chunk-4096", chunk=4096)
INTERLEAVE = "-mllvm -force-vector-interleave="
MORE = {
    "default": "",
    "interleave-1": f"{INTERLEAVE}1",
    "width-256-interleave-4": f"-mprefer-vector-width=256 {INTERLEAVE}4",
}
for name, more in MORE.items():
    recompiled("plain_sums", name, compiled_with=f"{kernels.flags()} {more}")
    recompiled("plain_move", name, compiled_with=f"{kernels.flags()} {more}")

# A whole iteration with transforms on two threads.
replanned("plain_iteration", "2-threads", threads=2)

# A kernel of one's own, here as it was before a choice became a factor. LLVM makes a masked store of the
# choice, which took 1.6 to 5 times as long on AMD's Zen 3 (docs/kernels.md). The flags are those of the program's own.
wp.set_module_options({"enable_backward": False, "cpu_compiler_flags": kernels.flags()})


@wp.kernel
def restrict_by_choice(force: wp.array[Any], field: wp.array[Any], squares: wp.array[wp.float64]):
    tid = wp.tid()
    start = tid * CHUNK_LENGTH
    total = field.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j
        x = wp.where(force[i] == field.dtype(0.0), field.dtype(0.0), field[i])
        field[i] = x
        total += x * x
    squares[tid] = wp.float64(total)


@variant("restrict_to_free")
def choice(a: Arrays) -> Runs:
    """The arrays are attributes; a launch is a kernel, its threads, the arrays that it reads and those it writes."""
    return launched([(restrict_by_choice, a.num_points // a.chunk, [a.force], [a.field, a.squares])])


@variant("mass_weighted_move")
def move_by_choice(a: Arrays) -> Runs:
    """A sequence: one kernel of one's own, two of the program's."""
    threads, shipped = a.num_points // a.chunk, kernels.load()
    return launched(
        [
            (restrict_by_choice, threads, [a.force], [a.acceleration, a.acceleration_sums]),
            (shipped["fire_control"], 1, [a.sums, a.acceleration_sums], [a.state]),
            (shipped["fire_step"], threads, [a.acceleration, a.h, a.state], [a.u, a.v]),
        ]
    )
