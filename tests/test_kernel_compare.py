"""Comparing two measurements of the kernels: made-up ones, whose noise and whose changes are known."""

import copy
import json

import numpy as np
import pytest
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import study_files
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.kernel_benchmark import compare
from linecontact.studies.kernel_benchmark.benchmarks import BENCHMARKS

pytestmark = pytest.mark.once

KERNELS = tuple(name for name, one in BENCHMARKS.items() if one.group in ("kernels", "sequences"))
SIZES = tuple(2**k for k in range(10, 23, 2))
IDENTITY = {"source": "a" * 12, "processor": "one", "caches": "L1", "numpy": "2.0", "compiler": "cc", "chunk": "1024"}


def made(seed, slower=None, machine=1.0, repeat=0.04, process=0.01, common=0.005, kernels=KERNELS, sizes=SIZES):
    """A measurement with so much scatter of every repetition, of every size in a process, and of all sizes alike.

    slower: factors of some kernels' times.
    """
    rng, runs = np.random.default_rng(seed), []
    for kernel in kernels:
        for precision in ("float32", "float64"):
            shift = rng.normal(0, common)
            for size in sizes:
                place = shift + rng.normal(0, process)
                for number in range(3):
                    ratio = 1.05 * (slower or {}).get(kernel, 1.0) * np.exp(place + rng.normal(0, repeat))
                    c = machine * size * 1e-9 * np.exp(rng.normal(0, 0.3))  # a shared machine
                    names = {"benchmark": kernel, "precision": precision, "num_points": size, "repeat": number}
                    times = {"seconds.warp": c * ratio, "seconds.c": c, "ratio.warp": ratio, "ratio.c": 1.0}
                    runs.append(names | times | {"yardstick": "c", "provenance.commit": "abc"})
    about = {"complete": True, "failures": {}, "configuration": {"identity": dict(IDENTITY)}}
    return {"schema": 2, "kind": "kernels"} | about | {"runs": runs}


def write(path, content):
    path.write_text(json.dumps(content))
    return path


def run(tmp_path, old, new, *options):
    files = [str(write(tmp_path / f"{name}.json", one)) for name, one in (("old", old), ("new", new))]
    return cli.main(["study", "kernels", "--compare", *files, *options])


def test_nothing_changed_is_not_called_slower(tmp_path, capsys):
    """Ten pairs: no exit status, and marked rows below one in a hundred."""
    marked = 0
    for seed in range(10):
        assert run(tmp_path, made(seed), made(100 + seed)) == 0
        words = capsys.readouterr().out.split("rows, ")[1].split()
        marked += int(words[0])
    assert marked < 0.01 * 10 * len(KERNELS) * 2 * len(SIZES)


def test_a_tenth_more_of_one_kernel_is_found(tmp_path, capsys):
    found = 0
    for seed in range(10):
        found += run(tmp_path, made(seed), made(100 + seed, {"plain_sums": 1.1})) == 3
        last = capsys.readouterr().out.strip().splitlines()[-1]
        assert not any(f" {name} in" in last for name in KERNELS if name != "plain_sums")
    assert found >= 9
    assert run(tmp_path, made(1), made(101, {"plain_sums": 1.1}), "--threshold", "1.3") == 0
    assert run(tmp_path, made(1, {"plain_sums": 1.1}), made(101)) == 0  # faster


def test_one_kernel_at_one_size_can_be_slower_too(tmp_path):
    few = {"kernels": ("fire_step",), "sizes": (2**18,)}
    assert run(tmp_path, made(1, **few), made(2, {"fire_step": 1.5}, **few)) == 3
    assert [run(tmp_path, made(seed, **few), made(50 + seed, **few)) for seed in range(20)] == [0] * 20


def test_transforms_are_listed_and_not_judged(tmp_path, capsys):
    old, new = made(1, kernels=("real_pair",)), made(2, kernels=("real_pair",))
    for content in (old, new):
        for row in content["runs"]:
            row |= {"yardstick": "estimate", "seconds.estimate": row["seconds.c"], "ratio.estimate": 1.0}
            row |= {"seconds.numpy": row.pop("seconds.warp"), "ratio.numpy": row.pop("ratio.warp")}
            del row["seconds.c"], row["ratio.c"]
    assert run(tmp_path, old, new) == 0
    assert "14 rows" in capsys.readouterr().out


def test_a_slower_machine_changes_nothing_and_all_kernels_slower_is_found(tmp_path):
    assert run(tmp_path, made(1), made(2, machine=1.7)) == 0
    assert run(tmp_path, made(1), made(2, dict.fromkeys(KERNELS, 1.1))) == 3


def test_other_machines_and_versions_are_said_first(tmp_path, capsys):
    new = made(2)
    new["configuration"]["identity"] |= {"processor": "two", "numpy": "2.1", "source": "b" * 12}
    assert run(tmp_path, made(1), new) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Different processors: one; then two."
    assert lines[1] == "Different versions of numpy: 2.0; then 2.1."
    assert "no verdict" in lines[-1]
    assert lines[2] == "Source: aaaaaaaaaaaa (commit abc); then bbbbbbbbbbbb (commit abc)."
    assert run(tmp_path, made(1), made(2)) == 0
    assert capsys.readouterr().out.startswith("Source: aaaaaaaaaaaa")


def test_the_newest_of_a_folder_is_taken(tmp_path):
    content = made(1)
    for name in ("x", "y"):
        runs = content["runs"] if name == "y" else content["runs"][:3]
        (tmp_path / name).mkdir()
        study_files.save_study(
            tmp_path / name / "kernels.h5", StudyFile("kernels", content["configuration"], runs, complete=True)
        )
    assert len(compare.read(tmp_path).cells) == len(KERNELS) * 2 * len(SIZES)


def test_bad_files_are_refused(tmp_path, capsys):
    good = write(tmp_path / "good.json", made(1))
    (tmp_path / "broken.json").write_text('{"schema": 2, "ru')
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "empty").mkdir()
    write(tmp_path / "list.json", [1])
    write(tmp_path / "foreign.json", {"runs": []})
    write(tmp_path / "older.json", {**made(1), "schema": 1})
    write(tmp_path / "failed.json", {**made(1), "complete": False, "failures": {"a": "b"}})
    write(tmp_path / "none.json", {**made(1), "runs": []})
    write(tmp_path / "other.json", {**made(1), "runs": [{**row, "num_points": 77} for row in made(1)["runs"]]})
    zero = copy.deepcopy(made(1))
    zero["runs"][0]["seconds.warp"] = 0.0
    write(tmp_path / "zero.json", {**zero, "runs": zero["runs"][:1]})
    study_files.save_study(tmp_path / "other.h5", StudyFile("hertz", {}, [{"status": "converged"}]))
    names = sorted(path.name for path in tmp_path.iterdir() if path != good)
    assert len(names) == 11
    for name in (*names, "good.json", "missing.json", "missing.h5"):  # nothing is compared with itself
        assert cli.main(["study", "kernels", "--compare", str(good), str(tmp_path / name)]) == 2, name
        caught = capsys.readouterr()
        assert caught.out == ""
        assert caught.err.count("\n") == 1
        assert name in caught.err
        assert "allowed" in caught.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--threshold", "1.2"], "threshold is 1.2; allowed: with --compare"),
        (["--compare", "a", "b", "--json"], "--json is given; allowed: without --compare, which measures nothing"),
        (["--compare", "a", "b", "--repeats", "4"], "repeats is 4; allowed: without --compare, which measures nothing"),
        *((["--compare", "a", "b", "--threshold", given], "threshold is") for given in ("1", "nan", "11")),
    ],
)
def test_options_that_say_nothing_or_are_bad_are_refused(words, said, capsys):
    assert cli.main(["study", "kernels", *words]) == 2
    assert capsys.readouterr().err.startswith(f"linecontact: {said}")
