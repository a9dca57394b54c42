"""The kernels' benchmark on the smallest sizes: agreement, harness, JSON, comparison, figures; no time is judged."""

import copy
import json
from dataclasses import replace

import numpy as np
import pytest
from linecontact import kernels
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import records, study_files
from linecontact.studies.files.study_files import StudyFile
from linecontact.studies.kernel_benchmark import candidates, compare, figures, measure, report, study
from linecontact.studies.kernel_benchmark.specs import SPECS
from linecontact.studies.runner import drawing
from linecontact.studies.terminal import console
from running import run_plans

PRECISIONS = ("float32", "float64")
HAS_C = bool(candidates.compile_c()[0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A whole study at 2^10 points: every kernel in both precisions, and the iteration."""
    folder = tmp_path_factory.mktemp("kernels")
    tiny = study.Configuration((10,), (10,), 1e-4)
    assert run_plans(study.STUDY, [tiny.plan()], folder) == 0
    return folder


@pytest.fixture(scope="module")
def measured(folder):
    return report.to_json(study_files.load_study(folder / "kernels.h5"))


def test_every_kernel_has_a_spec_that_fits_it():
    loaded = candidates.load()
    from linecontact.studies.kernel_benchmark import elements

    assert tuple(SPECS) == kernels.KERNELS
    for name, spec in SPECS.items():
        for kernel in (loaded[name], getattr(elements, name)) if spec.c else (loaded[name],):
            assert [a.label for a in kernel.adj.args] == [a.name for a in spec.arrays]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("kernel", SPECS)
def test_all_variants_agree(kernel, precision):
    bench = candidates.Bench(kernel, precision, 2 * kernels.CHUNK)
    expected = set(candidates.VARIANTS) - (set() if HAS_C else {"c"})
    assert bench.candidates.keys() - {"copy"} == (expected if SPECS[kernel].c else expected - {"c", "warp-element"})
    before = [array.copy() for array in bench.arrays]
    bench.check()
    assert any((a != b).any() for a, b in zip(bench.arrays, before, strict=True))
    bench.restore()
    for array, values in zip(bench.arrays, before, strict=True):
        np.testing.assert_array_equal(array, values)


@pytest.mark.parametrize("kernel", ["fire_step", "plain_sums", "fire_control"])
def test_a_wrong_variant_is_an_error(kernel):
    bench = candidates.Bench(kernel, "float64", kernels.CHUNK)
    good = bench.candidates["warp-graph"]

    def wrong():
        good()
        bench.arrays[-1][0] += 1e-6

    bench.candidates["warp-graph"] = wrong
    with pytest.raises(RuntimeError, match="warp-graph and numpy disagree in 1 values"):
        bench.check()


def test_traffic_and_working_set():
    spec = SPECS["net_force"]  # four arrays, two sums per chunk
    assert spec.traffic(2**12, "float32") == spec.working_set(2**12, "float32") == 4 * 4 * 2**12 + 2 * 8 * 4
    assert SPECS["fire_step"].traffic(2**12, "float64") == 6 * 8 * 2**12  # two of four in place
    assert SPECS["fire_step"].working_set(2**12, "float64") == 4 * 8 * 2**12


def test_candidates_are_timed_in_turn():
    seen = []
    slow = {name: lambda name=name: seen.append(name) for name in "ab"}
    found = measure.time_in_turn(slow, lambda: seen.append("restore"), 0.0)
    assert {name: len(values) for name, values in found.items()} == {"a": 7, "b": 7}
    order = [name for i, name in enumerate(seen) if name != "restore" and seen[i - 1] == "restore"]
    rounds = [order[i : i + 2] for i in range(0, 16, 2)]  # the first finds out how often
    assert all(sorted(pair) == ["a", "b"] for pair in rounds)
    assert ["a", "b"] in rounds
    assert ["b", "a"] in rounds


def test_records(folder):
    file = study_files.load_study(folder / "kernels.h5")
    assert file.complete
    assert len(file.runs) == 2 * (len(kernels.KERNELS) - 1) + 1 + 2
    assert records.unit("seconds.copy.median") == "s"
    assert records.unit("bytes.traffic") == "byte"
    for run in report.loops(file):
        assert not HAS_C or report.over_c(run, "c") == 1
        for variant in (*candidates.VARIANTS[:4], "copy"):
            assert 0 < report.seconds(run, variant, "min") <= report.seconds(run, variant)


def test_json_schema(measured):
    assert json.loads(json.dumps(measured)) == measured
    assert measured["schema"] == 1
    assert {"processor", "numpy", "commit"} < set(measured["provenance"])
    assert measured["compiler"]
    for row in measured["results"]:
        assert set(row) == {"kernel", "precision", "log2_points", "variant", "seconds_median", "seconds_min"} | {
            "nanoseconds_per_point", "bytes", "bandwidth_gb_per_s", "copy_bandwidth_gb_per_s", "gflop_per_s",
        } | ({"over_c"} if HAS_C and row["kernel"] != "fire_control" else set())  # fmt: skip
        assert row["seconds_min"] <= row["seconds_median"] < 1
        assert row["bandwidth_gb_per_s"] == pytest.approx(row["bytes"] / row["seconds_median"] / 1e9)
        assert row["nanoseconds_per_point"] == pytest.approx(row["seconds_median"] / 2**10 * 1e9)
    assert len(measured["results"]) == 2 * (len(kernels.KERNELS) - 1) * (4 + HAS_C) + 3
    assert [row["precision"] for row in measured["iterations"]] == list(PRECISIONS)


def test_json_on_the_command_line(folder, capsys, monkeypatch):
    monkeypatch.setattr(study, "QUICK", study.Configuration((10,), (10,), 1e-4))
    assert cli.main(["study", "kernels", "--quick", "--json", "--folder", str(folder)]) == 0
    caught = capsys.readouterr()
    assert json.loads(caught.out)["kind"] == "kernels"
    assert "Finished before" in caught.err


def test_tables_fit_80_columns(folder, capsys):
    file = study_files.load_study(folder / "kernels.h5")
    for part in report.parts(file):
        if not isinstance(part, str):
            console.Output(width=80).print(part)
    shown = capsys.readouterr().out
    assert "…" not in shown
    assert all(name in shown for name, spec in SPECS.items() if spec.c)


@pytest.mark.parametrize(("found", "reason"), [(None, "no C compiler"), ("false", "C compiler false failed")])
def test_without_a_compiler(folder, monkeypatch, found, reason):
    """The C column is left out, and said so."""
    monkeypatch.setattr(candidates.shutil, "which", lambda _: found)
    libraries, why = candidates.compile_c.__wrapped__()
    assert not libraries
    assert why.startswith(reason)
    file = study_files.load_study(folder / "kernels.h5")
    for run in file.runs:
        run |= {name: np.nan for name in run if name.startswith(("seconds.c.", "over_c."))} | {"compiler": why}
    *_, last = report.parts(file)
    assert last == f"C: {why}; left out."
    assert all(row["variant"] != "c" for row in report.to_json(file)["results"])


def write(path, content):
    path.write_text(json.dumps(content))
    return path


def changed(measured, factor, variant="warp-graph", copies=1.0):
    new = copy.deepcopy(measured)
    for row in new["results"]:
        row["copy_bandwidth_gb_per_s"] *= copies
        if (row["kernel"], row["precision"], row["variant"]) == ("fire_step", "float64", variant):
            row["seconds_median"] *= factor
    return new


def test_a_made_up_ratio_is_found(measured, folder, tmp_path, capsys):
    old = folder / "kernels.h5"
    for factor, variant, copies, status in (
        (1.5, "warp-graph", 1.0, 3),
        (1.5, "warp-graph", 0.5, 0),  # the whole machine is slower
        (0.5, "warp-graph", 1.0, 0),
        (1.5, "numpy", 1.0, 0),
    ):
        new = write(tmp_path / "new.json", changed(measured, factor, variant, copies))
        assert cli.main(["study", "kernels", "--compare", str(old), str(new)]) == status
        rows = [line.split() for line in capsys.readouterr().out.splitlines() if "fire_step" in line]
        (row,) = (row for row in rows if row[1:4] == ["64", "2^10", variant])
        assert float(row[6]) == pytest.approx(factor, abs=0.01)
        assert float(row[7]) == pytest.approx(factor * copies, abs=0.01)
        expected = ["slower"] if (factor, copies) == (1.5, 1.0) else ["faster"] if factor == 0.5 else []
        assert row[8:] == expected
    new = write(tmp_path / "new.json", changed(measured, 1.5))
    assert compare.command(old, new, 1.6) == 0


def test_bad_files_are_refused(measured, tmp_path, capsys):
    good = write(tmp_path / "good.json", measured)
    (tmp_path / "broken.json").write_text('{"schema": 1, "res')
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    write(tmp_path / "list.json", [1])
    write(tmp_path / "foreign.json", {"results": []})
    write(tmp_path / "later.json", {**measured, "schema": 2})
    write(tmp_path / "none.json", {**measured, "results": []})
    write(tmp_path / "zero.json", changed(measured, 0.0))
    write(tmp_path / "other.json", {**measured, "results": [{**row, "log2_points": 11} for row in measured["results"]]})
    study_files.save_study(tmp_path / "other.h5", StudyFile("hertz", {}, [{"status": "converged"}]))
    names = [path.name for path in tmp_path.iterdir() if path != good]
    assert len(names) == 9
    for name in (*names, "missing.json", "missing.h5"):
        assert cli.main(["study", "kernels", "--compare", str(good), str(tmp_path / name)]) == 2, name
        caught = capsys.readouterr()
        assert caught.out == ""
        assert caught.err.count("\n") == 1
        assert name in caught.err
        assert "allowed" in caught.err
    assert cli.main(["study", "kernels", "--compare", str(good), str(good), "--threshold", "1"]) == 2
    assert "threshold is 1.0" in capsys.readouterr().err


def test_figures_come_from_the_file_alone(folder, tmp_path):
    (tmp_path / "kernels.h5").write_bytes((folder / "kernels.h5").read_bytes())
    drawn = drawing.draw(tmp_path / "kernels.h5")
    assert {p.name for p in drawn} == {f"kernels{s}.{e}" for s in ("", "-roofline") for e in ("png", "pdf")}
    file = study_files.load_study(tmp_path / "kernels.h5")
    panel = figures.bandwidth(file).axes[0]
    runs = [run for run in report.loops(file) if run["precision"] == "float32"]
    line = next(line for line in panel.get_lines() if str(line.get_label()).startswith("Warp, chunks, recorded"))
    assert line.get_ydata()[0] == pytest.approx(np.median([report.bandwidth(run, "warp-graph") for run in runs]))
    figures.plt.close("all")


def test_full_study_covers_what_it_should():
    full = study.Configuration()
    assert full.kernels == tuple(range(10, 23))
    tasks = full.plan().runs
    assert {task.kernel for task in tasks} == {*kernels.KERNELS, measure.ITERATION}
    assert replace(full, kernels=(10,)).plan().runs != tasks
