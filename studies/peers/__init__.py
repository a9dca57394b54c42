"""The study of the two nearest peers on the same scenes.

May import: linecontact.solver, terminal, files, figures, runner.
"""
