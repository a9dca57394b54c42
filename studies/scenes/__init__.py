"""The options of a scene, scenes made from them, and the table of a scan: what the commands that take a scene share.

May import: linecontact.solver, terminal, scans.
"""
