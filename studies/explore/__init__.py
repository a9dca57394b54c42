"""A page in the browser on which sliders move a scene, served on this machine only. Needs Bokeh, an optional extra.

`start` holds the choices at the start, `controls` are the sliders; `newest` does the newest event's work on a
thread, which is in `answers` and `curves`; `page` puts it on the screen with `panels` and `wording`; `server` answers.

May import: linecontact.solver, scans, figures, terminal.
"""
