"""The kernels' benchmark on small sizes: agreement, variants of one's own, harness, keys, JSON, figures.

No time is judged.
"""

import itertools
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from linecontact import kernels
from linecontact.kernels import flags
from linecontact.studies.command_line import main as cli
from linecontact.studies.files import records, study_files
from linecontact.studies.kernel_benchmark import (
    c_code,
    cells,
    cores,
    figures,
    machine,
    measure,
    report,
    shipped,
    study,
    transforms,
    variants,
)
from linecontact.studies.kernel_benchmark.bench import Bench
from linecontact.studies.kernel_benchmark.benchmarks import BENCHMARKS
from linecontact.studies.runner import drawing
from linecontact.studies.runner.tasks import identity
from linecontact.studies.terminal import console
from running import run_plans

pytestmark = pytest.mark.once

EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "kernel_variants.py"
HAS_C = bool(c_code.compile_c().libraries)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A whole study at 2^10 points: every benchmark, transforms among them, in both precisions."""
    folder = tmp_path_factory.mktemp("kernels")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "_SECONDS", 1e-4)
        patch.setattr(measure, "_SPAN", 1e-6)
        patch.setattr(study, "_LEFT_OUT", ())
        patch.setattr(transforms, "MOST_SECONDS", 0.02)
        patch.setattr(machine, "compile_seconds", lambda: {"seconds.compile.cold": 4.0, "seconds.compile.warm": 0.1})
        plan = study.plan(study.Options(size=1024, repeats=2))
        assert run_plans(study.STUDY, [plan], folder) == 0
    return folder


def test_every_kernel_has_a_benchmark_that_fits_it():
    own = [name for name, one in BENCHMARKS.items() if one.group == "kernels"]
    assert sorted(own) == sorted(kernels.KERNELS)
    for name in own:
        assert [a.label for a in kernels.load()[name].adj.args] == [a.name for a in BENCHMARKS[name].arrays]
        assert BENCHMARKS[name].c or BENCHMARKS[name].c_whole


def test_every_sequence_is_measured_and_its_kernels_count():
    for name, lines in kernels.sequences.SEQUENCES.items():
        if len(lines) > 1:
            one = BENCHMARKS[name]
            assert [line.kernel for line in one.steps] == [text.split(":")[0] for text in lines]
            assert one.traffic(2**12, "float32") == sum(part.traffic(2**12, "float32") for part in one.parts)


def test_traffic_and_working_set():
    one = BENCHMARKS["net_force"]  # four arrays, four sums per chunk
    assert one.traffic(2**12, "float32") == one.working_set(2**12, "float32") == 4 * 4 * 2**12 + 4 * 8 * 4
    assert BENCHMARKS["fire_step"].traffic(2**12, "float64") == 6 * 8 * 2**12  # two of four in place
    assert BENCHMARKS["fire_step"].working_set(2**12, "float64") == 4 * 8 * 2**12


def test_variants_are_timed_in_turn():
    seen = []
    fast = {name: variants.repeated(lambda name=name: seen.append(name)) for name in "abc"}
    times, calls = measure.time_in_turn(fast, lambda: seen.append("restore"), 0.0, slow={"c"})
    assert {name: np.isnan(values).sum() for name, values in times.items()} == {"a": 0, "b": 0, "c": 5}
    assert all(1 <= count <= 300 for count in calls.values())
    order = re.findall(r"([ab])\1+", "".join(name for name in seen if name in "ab"))
    assert 3 < sum(a != b for a, b in itertools.pairwise(order)) < 2 * len(times["a"])  # it is not always the same


def test_records(folder):
    file = study_files.load_study(folder / "kernels.h5")
    assert file.complete
    found = cells.cells(file.runs)
    groups = {name: one.group for name, one in BENCHMARKS.items()}
    assert {key.benchmark for key in found} == set(groups)
    assert records.unit("seconds.warp") == "s"
    for key, cell in found.items():
        assert len(cell.runs) == 2
        if groups[key.benchmark] in ("kernels", "sequences"):
            assert {"warp", "numpy"} <= set(cell.variants)
            assert not HAS_C or cell.ratio("c") == 1
            assert cell.bandwidth("warp") > 0
        if groups[key.benchmark] == "transforms":
            assert {"estimate", "measure", "patient", "2-threads", "numpy"} <= set(cell.variants)
            assert cell.value("seconds.planning.measure") > 0


def test_other_source_or_another_machine_is_another_result(monkeypatch):
    options = study.Options(kernel="fire_step", size=1024)
    plan = study.plan(options)
    before = {machine.key(plan.configuration)} | {identity(task) for task in plan.tasks}
    for name, value in (("source", "0" * 12), ("processor", "another"), ("flags", "-O0")):
        changed = machine.identity() | {name: value}
        with monkeypatch.context() as patch:
            patch.setattr(machine, "identity", lambda changed=changed: changed)
            other = study.plan(options)
        assert not before & ({machine.key(other.configuration)} | {identity(task) for task in other.tasks})


def test_an_edit_changes_the_hash_of_the_source(monkeypatch):
    before = machine.source_hash()
    assert before == machine.source_hash()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda p: read(p) + (b"#" if p.name == "warp_fire.py" else b""))
    assert machine.source_hash() != before


@pytest.mark.parametrize("benchmark", ["restrict_to_free", "plain_sums", "fire_step", "mass_weighted_move"])
def test_the_documented_example(benchmark, own, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(study, "_SECONDS", 1e-4)
    monkeypatch.setattr(measure, "_SPAN", 1e-6)
    monkeypatch.chdir(EXAMPLE.parent)
    command = ["study", "kernels", "--variants", EXAMPLE.name, "--kernel", benchmark, "--size", "2^12"]
    assert cli.main([*command, "--folder", str(tmp_path), "--json"]) == 0
    rows = [run for run in json.loads(capsys.readouterr().out)["runs"] if run["benchmark"] == benchmark]
    assert len(rows) == 8
    names = {variant.name for variant in own[benchmark]}
    assert names
    for row in rows:
        assert all(row[f"seconds.{name}"] > 0 and row[f"ratio.{name}"] > 0 for name in names)
    assert cli.main([*command, "--folder", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "Finished before" in out
    assert all(name.replace("_", "-").split("-")[0] in out for name in names)
    (path,) = tmp_path.glob("*/kernels.h5")
    assert path.with_name("kernels-variants.png").exists()
    panel = figures.own_variants(study_files.load_study(path)).axes[0]
    (first, *_) = [cell for cell in cells.cells(rows).values() if cell.key.precision == "float32"]
    shown = {str(bars.get_label()): float(bars[0].get_ydata()[0]) for bars in panel.containers}
    assert shown == {name: pytest.approx(first.ratio(name)) for name in {"warp"} | names}


def test_a_whole_iteration_with_transforms_of_ones_own(own):
    variants.replanned("plain_iteration", "2-threads", threads=2)
    variants.recompiled("plain_iteration", "chunk-256", chunk=256)
    bench = Bench(BENCHMARKS["plain_iteration"], "float64", 2**12)
    assert {"2-threads", "chunk-256", "warp", "transforms"} <= set(bench.variants)
    bench.check()


def test_a_chunk_that_does_not_fit_is_left_out(own, tmp_path):
    variants.recompiled("fire_step", "long", chunk=4096)
    assert "long" not in Bench(BENCHMARKS["fire_step"], "float32", 1024).variants
    assert "long" in Bench(BENCHMARKS["fire_step"], "float32", 4096).variants
    (file := tmp_path / "none.py").touch()
    with pytest.raises(ValueError, match="size is 1024; allowed: multiples of 4096, for variant long of fire_step"):
        study.plan(study.Options(variants=file, size=2**10))
    study.plan(study.Options(variants=file))


def test_a_file_of_variants_chooses_the_benchmarks(own, tmp_path):
    (file := tmp_path / "mine.py").write_text(
        "from linecontact.studies.kernel_benchmark.variants import recompiled\n"
        "recompiled('fire_step', 'short', chunk=256)\n"
        "recompiled('plain_move', 'short', chunk=256)\n"
    )
    options = study.Options(variants=file, size=2**12)
    for kernel, expected in ((None, {"fire_step", "plain_move"}), ("sequences", {"plain_move"})):
        tasks = study.plan(replace(options, kernel=kernel)).tasks
        assert {task.benchmark for task in tasks} - {cells.MACHINE} == expected


def test_a_wrong_variant_is_told_and_not_timed(own, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(study, "_SECONDS", 1e-4)
    file = tmp_path / "mine.py"
    file.write_text(
        "from linecontact.studies.kernel_benchmark.variants import repeated, variant\n"
        "@variant('plain_sums')\n"
        "def mine(a):\n"
        "    return repeated(lambda: a.sums.fill(3))\n"
    )
    command = ["study", "kernels", "--variants", str(file), "--kernel", "plain_sums", "--size", "2^10"]
    assert cli.main([*command, "--folder", str(tmp_path)]) == 4
    caught = capsys.readouterr()
    text = "plain_sums in float32 on 1024 points: mine and numpy disagree in 4 of 4 values of sums: number 0 is 3.0"
    assert text in caught.err
    (file,) = tmp_path.glob("*/kernels.h5")
    assert len(study_files.load_study(file).failures) == 8  # and nothing is timed in later repetitions
    other = tmp_path / "other.h5"
    other.write_bytes(file.read_bytes())
    assert cli.main(["study", "kernels", "--compare", str(file), str(other)]) == 2
    assert "is of a study with 8 failed tasks" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "mine.py, which is not a file; allowed: an existing Python file that registers variants"),
        ("def", "SyntaxError"),
        ("1/0", "mine.py: line 2: ZeroDivisionError"),
        ("import sys; sys.exit(0)", "mine.py: line 2: SystemExit"),
        ("V.variant('fire')(lambda a: 0)", "benchmark is 'fire'; allowed: spectral_multiply"),
        ("V.recompiled('fire_step', 'x', chunk=1000)", "chunk is 1000; allowed: a power of two"),
        ("V.recompiled('fire_step', 'warp')", "variant of fire_step is 'warp'; allowed: a name that"),
        ("V.recompiled('plain_step', 'a b')", "variant is 'a b'; allowed: a name of letters, digits, _ and -"),
        ("V.replanned('fire_step', 'x')", "benchmark is 'fire_step'; allowed:"),
        ("V.replanned('plain_iteration', 'x', planning='hard')", "planning is 'hard'; allowed: estimate"),
        ("V.recompiled('plain_step', 'x')", "registers no variant of fire_step; allowed: --kernel plain_step"),
        ("", "registers no variant; allowed: a file that registers one"),
    ],
)
def test_bad_files_of_variants_are_refused(text, message, own, tmp_path, capsys):
    file = tmp_path / "mine.py"
    if text is not None:
        file.write_text("import linecontact.studies.kernel_benchmark.variants as V\n" + text)
    command = ["study", "kernels", "--variants", str(file), "--kernel", "fire_step", "--size", "2^10"]
    assert cli.main([*command, "--folder", str(tmp_path / "results")]) == 2
    caught = capsys.readouterr()
    assert caught.out == ""
    assert caught.err.count("\n") == 1
    assert message in caught.err
    assert "allowed" in caught.err


@pytest.mark.parametrize(
    "register",
    [
        lambda: variants.variant("fire_step", "mine")(lambda a: 1 / 0),
        lambda: variants.variant("fire_step", "mine")(lambda a: variants.repeated(lambda: 1 / 0)),
        lambda: variants.recompiled("fire_step", "mine", compiled_with="-no-such-flag"),
    ],
    ids=["built", "called", "flags"],
)
def test_a_variant_that_fails_is_named(register, own):
    register()
    with pytest.raises(ValueError, match=r"variant mine of fire_step fails .*; allowed: code that runs, flags"):
        Bench(BENCHMARKS["fire_step"], "float32", 1024).check()


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (["--size", "1000"], "size is 1000; allowed: an integer from 2^10"),
        (["--size", "1500"], "size is 1500; allowed: a multiple of 1024, or --kernel transforms"),
        (["--size", "2^30"], "allowed: an integer from 2^10 to 2^28"),
        (["--repeats", "1"], "repeats is 1; allowed: an integer from 2 to 100"),
        (["--workers", "2"], "workers is 2; allowed: 1, because"),
        (["--quick", "--size", "2^10"], "quick is True; allowed: without --size"),
        (["--kernel", "fire"], "allowed: kernels, sequences, iterations, transforms, roofs, spectral_multiply"),
    ],
)
def test_bad_options_are_refused(option, message, tmp_path, capsys):
    assert cli.main(["study", "kernels", *option, "--folder", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


def test_the_full_study_leaves_out_transforms_alone_and_repeats_everything_in_turn():
    tasks = study.plan(study.Options()).runs
    chosen = {task.benchmark for task in tasks} - {cells.MACHINE}
    assert chosen == {name for name, one in BENCHMARKS.items() if one.group != "transforms"}
    assert [task.repeat for task in tasks] == sorted(task.repeat for task in tasks)


def test_awkward_lengths_of_transforms(monkeypatch):
    monkeypatch.setattr(transforms, "MOST_SECONDS", 0.1)
    for name in ("real_pair", "rows_pair"):
        for n in (1031, 3**7, 5**5):
            Bench(BENCHMARKS[name], "float64", n).check()


def test_measured_plans_are_known_the_next_time_and_estimates_know_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    transforms.pyfftw.forget_wisdom()
    bench = Bench(BENCHMARKS["real_pair"], "float64", 1100, only={"estimate", "measure"})
    assert bench.notes["measure"]["measured"]
    assert not bench.notes["estimate"]["measured"]
    for wanted in ({"measure"}, {"estimate", "measure"}):
        again = Bench(BENCHMARKS["real_pair"], "float64", 1100, only=wanted)
        assert not any(notes["measured"] for notes in again.notes.values())
    seen = []
    plan = transforms._plan
    monkeypatch.setattr(transforms, "_plan", lambda *a: seen.append(transforms.pyfftw.export_wisdom()[0]) or plan(*a))
    Bench(BENCHMARKS["real_pair"], "float64", 1100, only={"estimate"})
    assert len(seen[0]) < 100 < len(transforms.pyfftw.export_wisdom()[0])


def test_the_report_says_what_it_is_of_and_its_tables_fit_80_columns(folder, capsys):
    file = study_files.load_study(folder / "kernels.h5")
    file.runs[0]["provenance.commit"] = "abc+dirty"
    text = "\n".join(part for part in report.parts(file) if isinstance(part, str))
    for part in report.parts(file):
        if not isinstance(part, str):
            console.Output(width=80).print(part)
    shown = capsys.readouterr().out
    assert "…" not in shown
    assert all(name.split("_")[0] in shown for name in BENCHMARKS)
    assert "commit abc, with changes that are not committed" in text
    assert flags() in text
    assert "Compiling all kernels takes 4.0 s once" in text


@pytest.mark.parametrize(("found", "reason"), [(None, "no C compiler"), ("false", "C compiler false failed")])
def test_without_a_compiler(monkeypatch, found, reason, tmp_path, capsys):
    """The ratios are to a copy then, and the report says why."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(c_code.shutil, "which", lambda _: found)
    without = c_code.compile_c.__wrapped__()
    assert not without.libraries
    assert without.compiler.startswith(reason)
    monkeypatch.setattr(shipped, "compile_c", lambda: without)
    times = measure.measure("fire_step", "float32", 1024, 1e-4, first=True)
    assert times["yardstick"] == "copy"
    monkeypatch.setattr(study, "compile_c", lambda: without)
    assert not any(BENCHMARKS[t.benchmark].group == "roofs" for t in study.plan(study.Options(quick=True)).runs[1:])
    assert cli.main(["study", "kernels", "--kernel", "roofs", "--folder", str(tmp_path)]) == 2
    assert "allowed without a C compiler" in capsys.readouterr().err
    assert times["ratio.warp"] > 0
    assert "seconds.c" not in times


def test_vectors_are_found_in_the_object_code():
    if not (shutil.which("objdump") and kernels.instructions().startswith("avx")):
        pytest.skip("no objdump, or a processor without AVX")
    widths = machine.vector_widths()
    assert len(widths) == 2 * len(kernels.KERNELS) - 1  # the one of FIRE's control is float64
    for (kernel, _), bits in widths.items():
        assert bits in (256, 512) or kernel == "fire_control"


def test_two_cores_are_measured_where_there_are_two():
    times = measure.measure("fire_step", "float32", 2**14, 1e-4, first=True)
    assert (times["ratio.two_cores"] > 0) == (len(cores.CORES) > 1)


def test_figures_come_from_the_file_alone(folder, tmp_path):
    (tmp_path / "kernels.h5").write_bytes((folder / "kernels.h5").read_bytes())
    drawn = drawing.draw(tmp_path / "kernels.h5")
    assert {p.name for p in drawn} == {f"kernels{s}.{e}" for s in ("", "-roofline") for e in ("png", "pdf")}
    file = study_files.load_study(tmp_path / "kernels.h5")
    panel = figures.bandwidth(file).axes[0]
    own = [c for c in cells.cells(file.runs).values() if c.benchmark.group == "kernels" and c.value("flops") > 0]
    own = [cell.bandwidth("warp") for cell in own if cell.key.precision == "float32"]
    line = next(line for line in panel.get_lines() if str(line.get_label()).startswith("Warp, as the program"))
    assert line.get_ydata()[0] == pytest.approx(np.median(own))
    file.runs = [run for run in file.runs if run["benchmark"].endswith("_pair")]
    study_files.save_study(tmp_path / "transforms.h5", file)
    (drawn,) = figures.draw(tmp_path / "transforms.h5").values()
    assert [axes.get_title() for axes in drawn.axes[:2]] == ["real pair", "rows pair"]
