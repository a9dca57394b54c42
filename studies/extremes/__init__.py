"""The map of extreme scenes, and the soak: random scenes for hours.

May import: linecontact.solver, terminal, files, figures, runner.
"""
