"""The study of every kernel's time, beside C and NumPy.

May import: linecontact.kernels, linecontact.solver, terminal, files, figures, runner.
"""
