"""Files: solutions and studies as HDF5, and a safe way to read files of others.

May import: linecontact.solver, terminal.
"""
