"""Arguments of any kind: each ends in a result or in one line, never in a traceback or a hang.

A short run with fixed seeds; longer ones were made.
"""

from fuzzing import fuzz
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.solver import checks
from linecontact.studies.command_line import main as cli
from linecontact.studies.command_line import solve
from linecontact.studies.runner import run
from linecontact.studies.scenes import kinds
from linecontact.studies.terminal.options import flag

KINDS = [solve.Options, *kinds.titled().values()]
FLAGS = [flag(name) for kind in KINDS for name in kind.__dataclass_fields__]
STUDY = ["--workers", "--memory", "--scheduler", "--folder", "--quick", "--overwrite"]
VALUES = st.one_of(
    st.sampled_from(
        [
            "nan",
            "-inf",
            "-0.0",
            "1e400",
            "5e-324",
            "1_0",
            "-1",
            "0",
            "16",
            "64",
            "0.5",
            "file",
            "rough",
            "mixed",
            "fire",
            "none",
            "/dev/zero",
            "tcp://[",
            "--",
            "=",
            "[/red]",
        ]
    ),
    st.sampled_from(["", "\n", "\x1b[31m", "\udc80", "9" * 400, "a" * 300]),
    st.floats().map(str),
    st.integers().map(str),
    st.text(st.characters(exclude_characters="\0"), max_size=8),
)


@settings(fuzz, max_examples=150)
@given(
    st.sampled_from(
        [["solve", "--num-points", "16"], ["study", "hertz"], ["study", "kernels"], ["plot"], ["export"], ["info"], []]
    ),
    st.lists(st.tuples(st.sampled_from(FLAGS + STUDY + ["--compare", "--threshold", "--csv"]), VALUES), max_size=3),
    st.lists(VALUES, max_size=1),
)
def test_any_arguments(tmp_path, monkeypatch, capfd, command, options, rest):
    """No solve is large, and no study is run."""
    real = solve.solve
    monkeypatch.chdir(tmp_path)

    def small(scene, **more):
        return real(scene, **more) if scene.num_points <= 64 else stop()

    monkeypatch.setattr(solve, "solve", small)
    monkeypatch.setattr(run, "_compute", lambda *_: stop())
    try:
        status = cli.main([*command, *(word for option in options for word in option), *rest])
    except SystemExit as stopped:
        status = stopped.code or 0
    said = capfd.readouterr().err
    assert status in (0, 2, 3)
    if status == 2:
        assert said.count("\n") == 1
        assert said.startswith("linecontact: ")
        assert "\x1b" not in said


def stop():
    checks.choice("solve", "large", ("not here",))  # as the program refuses anything
