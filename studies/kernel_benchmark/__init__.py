"""The study of what kernels, sequences of them, iterations and transforms cost.

May import: linecontact.kernels, linecontact.solver, terminal, files, figures, runner.
"""
