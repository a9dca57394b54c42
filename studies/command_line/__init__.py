"""The commands, a file for each: solve, explore, study, plot, export, info; and `main` for all. `curve` and `ensemble`
are studies.

Such a file offers `Options`, a dataclass of the options of the command, and `command(options)`, which does it
and returns the exit status. `main` looks for mistyped options before it imports any of them.

May import: linecontact.kernels, linecontact.solver, terminal, files, figures, runner, scans, scenes, explore.
"""
