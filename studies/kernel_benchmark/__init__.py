"""The study of the times of kernels, sequences of them, iterations and transforms.

May import: linecontact.kernels, linecontact.solver, terminal, files, figures, runner.
"""
