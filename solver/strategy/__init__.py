"""How a scene is solved: which model and method, in which precision, on which grids, and what if that fails.

`to_tolerance` and `to_accuracy` are the two ways through. Both go over the grids by one loop (`grids`), have the result
certified or another method try (`certification`), and make the solution from what was found (`report`).

May import: arrays, calibration, checks, display, endings, layers, indenters, scene, reference, transforms, grid,
methods, solution, one_thread, linecontact.kernels.
"""
