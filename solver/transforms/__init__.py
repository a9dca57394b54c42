"""Every Fourier transform of the program, but for the checks that share no code with it: a faster one is put in here.

`planned` has the transforms that are planned once and done often, in the faster of two ways: FFTW's real ones and those
of `four_step`. `backend` has the buffers, plans and kernels of both, and the interface for a method; `on_gpu` the same
on a GPU. `plain` has FFTW itself and transforms of plain arrays now and then, `wisdom` the plans that FFTW has
measured, `device` the devices, threads and planning efforts there are.

May import: arrays, checks, linecontact.kernels.
"""
