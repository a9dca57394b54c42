"""Between the program and a terminal: arguments in; progress, tables, errors and exit statuses out.

May import: linecontact.kernels, linecontact.solver.
"""
