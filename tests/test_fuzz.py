"""Arguments and texts from anywhere: each ends in a result or in one line, never in a traceback, a hang or a crash."""

from fuzzing import fuzz
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.studies import cli
from linecontact.studies.runner import run
from linecontact.studies.terminal import console


def test_text_is_shown_as_it_is(capfd):
    console.Output().print("[red]a[/blue] :smile: \x1b[31m\udc80")
    assert capfd.readouterr().out == "[red]a[/blue] :smile: \\x1b[31m\\udc80\n"


def test_too_little_memory_is_one_line(capfd):
    def greedy():
        raise MemoryError("8 EiB")

    assert console.guard(greedy) == 2
    assert capfd.readouterr().err.count("\n") == 1


def test_a_refusal_is_all_there_is_to_say(capfd):
    assert cli.main(["study", "peers", "--workers", "0"]) == 2
    assert capfd.readouterr().err.count("\n") == 1


FLAGS = [f"--{name.replace('_', '-')}" for name in cli.Solve.__dataclass_fields__]
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
        [["solve", "--num-points", "16"], ["study", "hertz"], ["study", "kernels"], ["plot"], ["info"], []]
    ),
    st.lists(st.tuples(st.sampled_from(FLAGS + STUDY + ["--compare", "--threshold"]), VALUES), max_size=3),
    st.lists(VALUES, max_size=1),
)
def test_any_arguments(tmp_path, monkeypatch, capfd, command, options, rest):
    """No solve is large, and no study is run."""
    real = cli.solve
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "solve", lambda scene, **more: real(scene, **more) if scene.num_points <= 64 else stop())
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
    raise ValueError("not here")
