"""How a scene is solved: which model and method, in which precision, on which grids, and the ways out if that fails.

A solve to a residual (`solve`), to an accuracy or to an approach goes over the grids by one loop (`grids`), has the
result certified or another method try (`run`), and makes the solution (`finish`).

May import: arrays, calibration, checks, display, endings, layers, indenters, scene, reference, transforms, grid,
methods, solution, linecontact.kernels.
"""
