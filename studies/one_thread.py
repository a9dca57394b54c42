"""What makes linear algebra take one thread: variables of the environment, read when NumPy is loaded."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""By their names."""
