"""The scene on a grid: the discrete problem, and what is read from a solution of it.

`problem` is what the methods solve, `response` with `split` the layer's response in real space, `kept` what serves the
next solve on the same grid, `certificate` says how wrong a displacement is, `patches`, `layer_on_grid`, `edge_curves`,
`edges`, `heights`, `few_nodes`, `surroundings`, `loads`, `shares`, `gaps`, `unseen`, `contact` and `observables` say
how large the contact is.

May import: arrays, calibration, checks, display, transforms, layers, indenters, reference, scene, value,
linecontact.kernels.
"""
