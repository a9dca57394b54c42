"""The study of what speed costs in accuracy.

May import: linecontact.solver, terminal, files, figures, runner, iterations, peers, multilevel.
"""
