"""The study that measures the universal edge curve.

May import: linecontact.solver, terminal, files, figures, runner.
"""
