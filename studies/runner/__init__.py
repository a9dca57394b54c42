"""Runs studies: what a study must offer, its tasks, where they run, and what becomes of their records.

May import: linecontact.solver, one_thread, terminal, files, figures.
"""
