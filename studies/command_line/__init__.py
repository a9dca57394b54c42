"""The commands, a file for each: solve, explore, study, plot, export, info; and `main` for all. `curve` and `ensemble`
are studies.

Such a file offers `Options`, a dataclass of what the command can be asked for, and `command(options)`, which does it
and returns the exit status. `main` looks for mistyped options before it imports any of them.

May import: linecontact.kernels, linecontact.solver, terminal, files, figures, runner, scans, scenes, explore.
"""
