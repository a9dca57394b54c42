"""A curve: one number of a scene varied, every value solved and certified, a row of a table each.

`number` is the number that may vary and how far, `even_areas` finds loads that suit the area, `tasks` are the solves,
`report` and `figures` show them, `study` is the command.

May import: linecontact.solver, terminal, files, figures, runner, scans, scenes.
"""
