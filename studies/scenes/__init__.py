"""The options of a scene, and scenes made from them: what the commands that take a scene have in common.

May import: linecontact.solver, terminal, scans.
"""
