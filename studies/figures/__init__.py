"""Common parts of all figures, and the figure of a solution. A figure is drawn from the contents of a stored file.

May import: linecontact.solver, terminal, files, scans.
"""
