"""The area-pressure relation over the load: power profiles and rough surfaces, on the half-space and on layers.

`tasks` are the solves, `analysis` reads numbers off them, `findings` judges statements, `report` and
`figures` show them, `study` is the command.

May import: linecontact.solver, terminal, files, figures, runner, rough_surfaces, power_profiles, paper.
"""
