"""What all figures share, and the figure of a single solution. A figure is always drawn from a stored file.

May import: linecontact.solver, files, scans.
"""
