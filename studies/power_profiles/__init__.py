"""What the studies hertz, sharp and blunt have in common: tasks, report and figures of one power profile.

May import: linecontact.solver, terminal, files, figures, runner.
"""
