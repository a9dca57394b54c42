"""The studies. Four are scripts that run by themselves: hertz.py, sharp.py, blunt.py and rough.py.

Every other study is a folder of its own, with its tasks, its report and its figures. Their common code is in terminal/,
files/, figures/ and runner/. To add a study, write a module that offers STUDY (`runner.study.Study`), Options and
command, and add its line to `STUDIES`.
"""

PUBLISHED = (
    'Yunong Zhou and Jing Yang, "How Thickness Affects the Area-Pressure Relation in Line Contacts", Tribology '
    "Letters, issue 4/2022"
)
"""The published study: the source of every number that is called published."""

STUDIES = {
    "hertz": "linecontact.studies.hertz",
    "sharp": "linecontact.studies.sharp",
    "blunt": "linecontact.studies.blunt",
    "rough": "linecontact.studies.rough",
    "paper": "linecontact.studies.paper.study",
    "iterations": "linecontact.studies.iterations.study",
    "edge-curve": "linecontact.studies.edge_curve.study",
    "kernels": "linecontact.studies.kernel_benchmark.study",
    "gpu": "linecontact.studies.gpu.study",
    "peers": "linecontact.studies.peers.study",
    "tradeoff": "linecontact.studies.tradeoff.study",
    "extremes": "linecontact.studies.extremes.study",
    "soak": "linecontact.studies.extremes.soak",
    "pressure": "linecontact.studies.pressure.study",
    "calibration": "linecontact.studies.calibration.study",
    "curve": "linecontact.studies.curve.study",
    "ensemble": "linecontact.studies.multilevel.study",
}
"""Every study by its name, with the module that offers it; a module is imported only when its study is needed."""
