"""The study that measures the curves of contact edges.

May import: linecontact.solver, terminal, files, figures, runner.
"""
