"""The options of a scene, scenes made from them, and the table of a scan: common parts of commands with a scene.

May import: linecontact.solver, terminal, scans.
"""
