"""The scene on a grid: the discrete problem, and what is read from a solution of it.

`problem` is solved by the methods; `response` with `split` is the layer's response in real space, and `cached` keeps
them for the next solve on the same grid. `certificate` says how wrong a displacement is. `patches`, `layer_on_grid`,
`edge_curves`, `edges`, `few_nodes`, `surroundings`, `narrow`, `shares`, `unseen`, `contact` and `observables` say how
large the contact is.

May import: arrays, calibration, checks, display, transforms, layers, indenters, reference, scene, value.
"""
