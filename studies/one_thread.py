"""Linear algebra on one thread: variables of the environment, read when NumPy is loaded.

Where it is loaded already, in Python, `linecontact.solver.arrays.on_one_thread` does it for a solve. This module has
to be imported before NumPy, and so imports nothing.
"""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""By their names."""
