"""How the Warp kernels are written and compiled.

Every array is one-dimensional and padded to a multiple of `CHUNK`; one thread works on one chunk. An inner loop whose
length is a compile-time power of two is what LLVM turns into vector code; a thread per element, a run-time bound or a
tail test stays scalar. The reassociation flags let it vectorise the sums as well.
"""

import platform

import warp as wp

# Left alone LLVM takes 512-bit vectors, which some processors split in two, and interleaves long loops too little: at
# 2^18 points `plain_step` took 20 % longer and most others 5 % (`linecontact study kernels`).
VECTORS = " -mprefer-vector-width=256 -mllvm -force-vector-interleave=4"

OPTIONS = {
    "enable_backward": False,
    "cpu_compiler_flags": (wp.config.cpu_compiler_flags or "")
    + " -mreassociate -fno-signed-zeros -ffp-contract=fast"
    + (VECTORS if platform.machine() in ("x86_64", "AMD64") else ""),
}
"""Options of every module of kernels. Its flags replace Warp's global string, so they are appended to that."""
