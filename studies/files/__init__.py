"""Files: solutions and studies as HDF5, and a safe way to read what others wrote.

May import: linecontact.solver, terminal.
"""
