"""The study of transform pairs and times over the number of grid points.

May import: linecontact.solver, terminal, files, figures, runner.
"""
