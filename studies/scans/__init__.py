"""Measured scans: from the file that an instrument wrote to an indenter.

`reading` is the way in; `columns` finds x and z in a file, `text` and `header` in a text; `preparation` makes h of it.

May import: linecontact.solver, terminal, files.
"""
