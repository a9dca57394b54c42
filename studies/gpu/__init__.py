"""The study of the GPU: iterations and kernels beside the CPU's, and the same answers from both.

May import: linecontact.solver, linecontact.kernels, terminal, files, figures, runner.
"""
