"""What the study rough takes its means, report and figures from.

May import: linecontact.solver, terminal, files, figures, runner, multilevel.
"""
