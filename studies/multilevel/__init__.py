"""Means over random surfaces to a standard error asked for, by multilevel Monte Carlo.

`samples` are results of single surfaces, on grids and on a `foundation`, `estimator` makes means and errors of
them, `allocation` plans the next solves, `tasks` solve, `report` and `figures` show the result, `study` is the
command.

May import: linecontact.solver, terminal, files, figures, runner, scenes.
"""
