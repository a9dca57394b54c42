"""The study of the price of speed in accuracy.

May import: linecontact.solver, terminal, files, figures, runner, iterations, peers, multilevel.
"""
