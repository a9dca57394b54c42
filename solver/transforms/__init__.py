"""Every Fourier transform of the program, but for the checks that share no code with it: a faster one is put in here.

`planned` has the transforms that are planned once and done often, `plain` those of plain arrays now and then, `wisdom`
what FFTW has learnt of this machine, `fftw` the library itself. `on_gpu` has those of a GPU, `place` what a method asks
of either, `device` which devices there are.

May import: arrays, checks, linecontact.kernels.
"""
