"""The studies, by the names that the command line knows, and the modules that they are in.

Such a module offers `Options`, a dataclass of what the study can be asked for, and `command(options)`, which runs it
and returns the exit status. Only the module of the study that is asked for is imported.
"""

STUDIES: dict[str, str] = {
    "hertz": "linecontact.studies.hertz",
    "sharp": "linecontact.studies.sharp",
    "blunt": "linecontact.studies.blunt",
    "rough": "linecontact.studies.rough",
    "paper": "linecontact.studies.paper",
    "iterations": "linecontact.studies.iterations",
    "edge-curve": "linecontact.studies.edge_curve",
    "kernels": "linecontact.studies.kernels",
    "peers": "linecontact.studies.peers",
    "tradeoff": "linecontact.studies.tradeoff",
    "extremes": "linecontact.studies.extremes",
    "soak": "linecontact.studies.soak",
}
"""One line for each."""
