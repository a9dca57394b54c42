"""The scene on a grid: the discrete problem, and what is read from a solution of it.

`problem` is solved by the methods. It carries `layer_on_grid`, which has the response in real space by `split`, and
`indenter_on_grid`; `cached` keeps both for the next solve on the same grid. `prolong` begins a finer grid.
`certificate` says how wrong a displacement is. `patches`, `edge_curves`, `edges`, `few_nodes`, `narrow`,
`shares`, `unseen`, `contact` and `observables` say how large the contact is, and `errors` how well that is
known.

May import: arrays, calibration, checks, display, transforms, layers, indenters, reference, scene, value,
linecontact.kernels.
"""
