"""What all figures share, and the figure of a single solution. A figure is drawn from what a stored file holds.

May import: linecontact.solver, terminal, files, scans.
"""
