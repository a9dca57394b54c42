"""What the terminal shows and says: progress, tables, errors, exit statuses.

May import: linecontact.solver.
"""
