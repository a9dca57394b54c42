"""What stands between the program and a terminal: arguments in, text out.

May import: linecontact.solver.
"""
