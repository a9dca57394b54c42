"""The scene on a grid: the discrete problem, and what is read from a solution of it.

`problem` is what the methods solve, `response` with `split` the layer's response in real space, `cached` keeps them for
the next solve on the same grid, and `certificate` says how wrong a displacement is. How large the contact is say `patches`,
`layer_on_grid`, `edge_curves`, `edges`, `few_nodes`, `surroundings`, `narrow`, `shares`, `unseen`, `contact` and
`observables`.

May import: arrays, calibration, checks, display, transforms, layers, indenters, reference, scene, value.
"""
