"""Runs studies: the form of a study, its tasks, where they run, and their records.

May import: linecontact.solver, one_thread, terminal, files, figures.
"""
