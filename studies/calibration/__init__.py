"""The numbers in estimated errors, fitted to random scenes: `scenes` draws them, `fit` fits, `study` is the command.

May import: linecontact.solver, terminal, files, runner.
"""
