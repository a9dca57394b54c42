"""Measured scans: from the file that an instrument wrote to an indenter.

`reading` is the way in; `columns` finds positions and heights in a file of any kind, `text` in text of any kind;
`header` reads what a text says of its columns, `units` the units in it; `preparation` makes a scan periodic.

May import: linecontact.solver, terminal, files.
"""
