"""Every Fourier transform of the program, but for the checks that share no code with it: a faster one is put in here.

`planned` has the transforms that are planned once and done often, in the fastest of three ways: FFTW's real ones,
`half_length`, and `four_step` with `columns`, whose parts `sharing` divides between threads; `planner` makes their
buffers and plans. `plain` has those of plain arrays now and then, `wisdom` the plans that FFTW has measured, `fftw` the
library itself. `on_gpu` has those of a GPU, `backend` the interface of both for a method, `device` which devices there
are.

May import: arrays, checks, linecontact.kernels.
"""
