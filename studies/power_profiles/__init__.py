"""The common part of the studies hertz, sharp and blunt: tasks, report and figures of one power profile.

May import: linecontact.solver, terminal, files, figures, runner.
"""
