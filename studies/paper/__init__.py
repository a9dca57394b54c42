"""The study of the whole published study: its four figures, its report and its statements.

May import: linecontact.solver, terminal, files, runner, power_profiles, rough_surfaces, hertz, sharp, blunt, rough.
"""
