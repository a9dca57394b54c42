"""The source of means, report and figures of the study rough.

May import: linecontact.solver, terminal, files, figures, runner, multilevel.
"""
