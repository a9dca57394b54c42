"""The command line, as a subprocess where that matters."""

import contextlib
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import linecontact
import numpy as np
import pytest
from linecontact.studies.command_line.main import main
from linecontact.studies.files import solution_files, study_files
from linecontact.studies.terminal import units

CLI = [sys.executable, "-m", "linecontact.studies"]


def run(*arguments, cwd=None, program=CLI):
    return subprocess.run([*program, *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=cwd)


def here(*arguments):
    """The same in this process, which has imported everything already: that takes longer than most commands."""
    with contextlib.redirect_stdout(io.StringIO()) as stdout, contextlib.redirect_stderr(io.StringIO()) as stderr:
        status = main([*map(str, arguments)])
    return subprocess.CompletedProcess(arguments, status, stdout.getvalue(), stderr.getvalue())


def test_solve_json():
    result = run("solve", "--num-points", 4096, "--thickness", 0.1, "--poisson-ratio", 0.25, "--json")
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("\n") == 1
    record = json.loads(result.stdout)
    assert (record["status"], record["method"], list(record["levels"])) == ("converged", "active-set", ["1024"])
    assert abs(record["contact_area"] - 0.094482408562) < 2 / 4096
    assert abs(record["contact_area_subgrid"] - 0.094482408562) < record["contact_area_error"] < 0.01 / 4096
    keys = "kappa_subgrid kappa_error kappa_ratio approach peak_pressure peak_pressure_error num_patches precision"
    assert {*keys.split(), "iterations", "transform_pairs", "version", "handed_over"} < set(record)
    assert {"setup", "solve", "total"} <= set(record["seconds"])
    names = "equilibrium_residual largest_residual tensile_violation penetration complementarity force_balance"
    assert set(record["certificate"]) == {*names.split(), "energy_error_bound"}
    assert record["certificate"]["equilibrium_residual"] <= 1e-8
    assert record["scene"]["num_points"] == 4096
    other = json.loads(here("solve", "--num-points", 2048, "--method", "fire", "--grids", "single", "--json").stdout)
    assert (other["method"], other["levels"]) == ("fire", {})
    assert abs(other["contact_area_subgrid"] - 0.100714056833) < 1e-6


def test_an_accuracy_is_bought_or_refused():
    record = json.loads(here("solve", "--thickness", 0.1, "--accuracy", 1e-6, "--json").stdout)
    assert abs(record["contact_area_subgrid"] / 0.094482408562 - 1) < 1e-6
    assert {"model", "grid"} <= set(record["choices"])
    short = here("solve", "--profile", "rough", "--cut-off-ratio", 1 / 16, "--num-points", 2048, "--accuracy", 1e-6)
    assert short.returncode == 3
    assert short.stderr.count("\n") == 1
    told = r"accuracy is 1e-06; allowed: above ([\d.e-]+), or a finer grid: num_points above 2048"
    known = re.search(told, short.stderr)
    assert f"(relative {known[1]})" in short.stdout
    assert "chosen for an accuracy of 1e-06" in short.stdout


def test_solve_table_save_and_plot(tmp_path):
    paths = {name: tmp_path / f"run.{name}" for name in ("h5", "csv", "png", "pdf")}
    words = ("solve", "--num-points", 256, "--save", paths["h5"], "--patches", paths["csv"], "--plot")
    said = [f"Data: {paths['h5']}", f"Patches: {paths['csv']}", f"Figures: {paths['png']}, {paths['pdf']}"]
    result = here(*words)
    assert "contact area" in result.stdout
    assert result.stdout.splitlines()[-3:] == said, result.stderr
    assert all(path.is_file() for path in paths.values())
    attributes = solution_files.load(paths["h5"]).results
    assert attributes["scene.thickness"] == "inf"
    assert attributes["certificate.equilibrium_residual"] <= 1e-8
    again = here(*words)
    assert again.returncode == 2
    assert "exists" in again.stderr
    as_json = here(*words, "--overwrite", "--json")
    assert as_json.stderr.splitlines() == said
    assert json.loads(as_json.stdout)["status"] == "converged"
    assert here("plot", paths["h5"]).stdout.split() == [str(paths["png"]), str(paths["pdf"])]
    assert min(paths["png"].stat().st_size, paths["pdf"].stat().st_size) > 5000


def test_a_scan_from_file_to_figure_in_one_command(tmp_path):
    x = np.arange(300)
    scan = np.stack([0.5 * x, np.sin(x / 20) + 0.1 * np.random.default_rng(0).standard_normal(300)], axis=1)
    np.savetxt(tmp_path / "scan.csv", scan, delimiter=",", header="x [um], z [nm]")
    words = "--profile file --length-unit um --pressure 1e-4 --contact-modulus 1 --plot --profile-file"
    words = ("solve", *words.split(), tmp_path / "scan.csv", "--save")  # the units stand in the header
    result = here(*words, tmp_path / "run.h5")
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "run.png").stat().st_size > 5000
    fields = solution_files.load(tmp_path / "run.h5")
    assert fields.results["scene.period"] == pytest.approx(300)
    assert fields.results["scene.num_points"] == 4096
    assert "mirror" in fields.results["scene.profile_steps"]
    assert fields.profile.max() < 5e-3  # nm to um
    assert "Profile: numbers of scan.csv" in result.stdout
    assert "Read: x in um, z in nm, values taken as heights" in result.stdout
    assert "1 line of header, x from column 1, z from column 2; positions even to " in result.stdout
    assert re.search(r"of their spacing, taken as even; .*tilt of \S+ \(dimensionless\) removed", result.stdout)
    (width,) = [line for line in result.stdout.splitlines() if "contact width" in line]
    assert width.split()[-2] == "um"
    again = here(*words, tmp_path / "run.png")
    assert again.returncode == 2
    assert "run.png exists" in again.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--layer file --stiffness-file k.txt --patches ./k.txt", "patches is k.txt, which is taken by stiffness_file"),
        ("--profile file --profile-file link/s.h5 --save s.h5", "save is s.h5, which is taken by profile_file"),
    ],
)
def test_a_file_is_not_written_over_another_one_of_the_same_command(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "k.txt").touch()
    (tmp_path / "s.h5").touch()
    assert main(["solve", *words.split(), "--overwrite"]) == 2
    assert capsys.readouterr().err == f"linecontact: {said}; allowed: another file\n"


def scan_words(folder, columns, header=""):
    """A command that solves the scene of a scan, without its load."""
    np.savetxt(folder / "scan.csv", np.random.default_rng(0).random((40, columns)).cumsum(axis=0), header=header)
    return ["solve", "--profile", "file", "--profile-file", str(folder / "scan.csv"), "--contact-modulus", "1"]


@pytest.mark.parametrize("columns", [1, 2])
def test_lengths_of_a_scan_s_scene_may_have_units(tmp_path, capsys, columns):
    words = [*scan_words(tmp_path, columns, "x [um], z [nm]" if columns == 2 else "z [nm]"), "--json"]
    words += ["--scan-length", "0.04 mm"] if columns == 1 else []
    found = []
    for thickness, unit in (("2mm", "m"), ("2 mm", "um"), ("2000", "um"), ("2000um", "inch")):
        assert main([*words, "--approach", "0.2nm", "--thickness", thickness, "--length-unit", unit]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert [record["scene"]["thickness"] for record in found] == pytest.approx([2e-3, 2e3, 2e3, 2e-3 / 0.0254])
    periods = [record["scene"]["period"] for record in found]
    assert periods == pytest.approx([1e-6 * periods[1], periods[1], periods[1], 1e-6 * periods[1] / 0.0254])
    assert columns == 2 or periods[1] == pytest.approx(80)
    areas = [record["contact_area_subgrid"] for record in found]
    assert areas == pytest.approx([areas[0]] * 4, rel=1e-8)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("200um", "m", 2e-4),
        ("3nm", "m", 3e-9),
        ("2.54cm", "inch", 1.0),
        ("2^-3 um", "nm", 125.0),
        ("0um", "m", 0.0),
    ],
)
def test_a_length_in_another_unit_is_the_number_with_its_digits(text, unit, value):
    assert units.read("thickness", text, units.Own(unit)) == value


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--thickness 200", "thickness is '200'; allowed: with its unit, like 200m, or --length-unit, that of all len"),
        ("--thickness 2^3", "thickness is '8'; allowed: with its unit, like 8m, or"),
        ("--scene-units --thickness 3", "length_unit is missing; allowed: the unit of the scene, where one of the"),
        ("--approach 2e-4", "approach is '0.0002'; allowed: with its unit, like 0.0002m"),
        ("--layer file --stiffness-file {table}", "table.txt; allowed: with --length-unit, the unit of 1/q\n"),
    ],
)
def test_a_length_of_a_scan_s_scene_is_not_guessed_to_be_in_metres(words, said, tmp_path, capsys):
    np.savetxt(tmp_path / "table.txt", np.outer(10.0 ** np.arange(-3, 9), (1, 0.5)))
    words = words.format(table=tmp_path / "table.txt").split()
    words += [] if "--approach" in words else ["--pressure", "1e-3"]
    words = [*scan_words(tmp_path, 2, "x [um], z [nm]"), *words]
    assert main(words) == 2
    assert said in capsys.readouterr().err
    assert main([*words, "--length-unit", "um", "--json"]) == 0
    nothing_to_guess = [*words[:7], "--thickness", "inf", "--approach", "0", "--json"]
    assert main(nothing_to_guess) == 0
    assert main([*nothing_to_guess, "--period", "1"]) == 2
    assert "period is 1.0; allowed: none with a file" in capsys.readouterr().err


def test_the_unit_of_a_scene_is_that_of_numbers_in_scene_units(tmp_path, capsys):
    words = [*scan_words(tmp_path, 1), "--scene-units", "--pressure", "1e-3", "--json"]
    length = ["--scan-length", "1.5mm"]
    assert main([*words, *length]) == 2
    assert "scan_length is '1.5mm'; allowed: a number alone, the lengths of this scene have" in capsys.readouterr().err
    scenes = []
    for more in (
        [*length, "--length-unit", "um", "--thickness", "2mm"],
        ["--scan-length", "1500", "--thickness", "2000"],
    ):
        assert main([*words, *more]) == 0
        scenes.append(json.loads(capsys.readouterr().out)["scene"])
    assert [(scene["period"], scene["thickness"]) for scene in scenes] == [pytest.approx((3000, 2000))] * 2
    assert [scene["profile_length_unit"] for scene in scenes] == ["um", "the scene's"]


@pytest.mark.parametrize(
    ("thickness", "allowed"),
    [
        ("0,1mm", "a number with a decimal point, like 0.1mm"),
        ("2furlongs", "a number, or a length with its unit, like 50um"),
        ("1e305m", "a number of 4.9e-324 to 1.8e+308 in size, in nm"),
    ],
)
def test_a_length_of_a_scan_is_a_number_or_has_a_unit_and_is_not_too_large(tmp_path, capsys, thickness, allowed):
    more = ["--pressure", "1", "--length-unit", "nm", "--thickness", thickness]
    assert main([*scan_words(tmp_path, 2, "x [um], z [nm]"), *more]) == 2
    assert capsys.readouterr().err == f"linecontact: thickness is {thickness!r}; allowed: {allowed}\n"


def test_a_scan_is_not_pressed_by_defaults(tmp_path):
    words = [*scan_words(tmp_path, 1, "Height [um]")[:-2], "--scan-length", "0.1mm"]
    both = "contact_modulus (or youngs_modulus) and pressure (or approach) are"
    for more, missing in (((), both), (("--youngs-modulus", 1), "pressure (or approach) is")):
        refused = here(*words, *more)
        assert refused.returncode == 2
        assert refused.stderr.startswith(f"linecontact: {missing} missing; allowed: ")
    assert here(*words, "--youngs-modulus", 1, "--pressure", 1e-3, "--json").returncode == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["solve", "--exponent", "0.5"], "exponent is 0.5"),
        (["solve", "--thickness", "0"], "thickness is 0.0"),
        (["solve", "--thickness", "2^-2000"], "thickness is '2^-2000'; allowed: a number of 4.9e-324 to 1.8e+308 in s"),
        (["solve", "--thickness", "-2^2"], "thickness is -4.0; allowed: "),
        (
            ["solve", "--period", "1um"],
            "period is '1um'; allowed: a number alone, the lengths of this scene have no unit",
        ),
        (["solve", "--thickness", "2furlongs"], "thickness is '2furlongs'; allowed: a number\n"),
        (["solve", "--thickness", "0,1"], "thickness is '0,1'; allowed: a number with a decimal point, like 0.1\n"),
        (["solve", "--patches", "run.png"], "patches is run.png; allowed: a name for comma-separated values"),
        (["solve", "--tolerance", "1e-15"], "tolerance is 1e-15; allowed: 1e-14 to 0.5\n"),
        (["solve", "--scene-units"], "--scene-units is given; allowed: only with --profile file, not power"),
        (["solve", "--profile", "rough", "--num-points", "4096"], "dx/lambda_s is 1"),
        (["solve", "--profile", "file"], "profile_file is missing"),
        (["solve", "--profile", "file", "--profile-file", "no.txt"], "no.txt: this is not a file"),
        (["solve", "--plot"], "--plot is given without --save; allowed: both"),
        (["solve", "--save", "x.txt"], "file x.txt would hold HDF5; allowed: a name that ends in .h5 or .hdf5\n"),
        (["solve", "--profile-file", __file__], "allowed: only with --profile file, not power"),
        (["solve", "--hurst", "0.8"], "hurst is 0.8; allowed: only with --profile rough, not power"),
        (["solve", "--save", "/dev/null", "--overwrite"], "not a regular file"),
        (["solve", "--save", "/nowhere/at/all.h5"], "does not exist"),
        (["curve", "--folder", ""], "folder is ''; allowed: a path\n"),
        (["plot", "missing.h5"], "missing.h5 does not exist"),
        (["plot", __file__], "not one of linecontact's HDF5 files; allowed: one that it wrote"),
        (["study", "hertz", "--workers", "0"], "workers is 0"),
        (["solve", "--pressure", "a'b"], 'linecontact: pressure is "a\'b"; allowed: a number alone, or each'),
        (["solve", "--youngs-modulus", "1MPa"], "pressure (or approach) is missing; allowed: where lengths or"),
        (["ensemble", "--observable"], "has no value; allowed: kappa, contact-area, peak-pressure, approach, mean-"),
        (["curve", "--values"], "values has no value; allowed: numbers separated by commas"),
        (["stdy"], "command is 'stdy', perhaps meant as study; allowed: solve, curve, ensemble, explore, stu"),
        (["study", "hertz", "--quik"], "option --quik is unknown, perhaps meant as --quick"),
    ],
)
def test_bad_input_is_one_line_and_status_2(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = here(*arguments)
    assert result.returncode == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("linecontact: ")
    assert "Traceback" not in result.stderr
    assert not result.stdout


@pytest.mark.parametrize("words", ["", "stdy", "solve --colour red", "solve --exponent 0.5", "plot missing.h5"])
def test_bad_input_ends_a_process_the_same_way(words, tmp_path, monkeypatch):
    """It looks at the names of options before it imports anything."""
    monkeypatch.chdir(tmp_path)
    result, expected = run(*words.split()), here(*words.split())
    assert (result.returncode, result.stdout, result.stderr) == (2, "", expected.stderr)


def test_iteration_limit_is_status_3_with_the_partial_result(tmp_path):
    file = tmp_path / "run.h5"
    result = run("solve", "--num-points", 1024, "--max-iterations", 2, "--json", "--save", file)
    assert result.returncode == 3
    assert json.loads(result.stdout)["status"] == "iteration limit"
    assert "max_iterations is reached after 2" in result.stderr
    assert solution_files.load(file).results["status"] == "iteration limit"


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("sign", "ctrl_c"),
    [
        (signal.SIGINT, signal.SIG_DFL),
        (signal.SIGTERM, signal.SIG_DFL),
        (signal.SIGTERM, signal.SIG_IGN),  # a shell's background jobs ignore it
    ],
)
def test_ctrl_c_is_status_130_with_the_partial_result(tmp_path, sign, ctrl_c):
    file = tmp_path / "run.h5"
    arguments = ["solve", "--num-points", str(2**18), "--method", "fire", "--tolerance", "1e-13", "--save", str(file)]
    program = (
        "import sys\n"
        "from linecontact.studies import __main__ as entry\n"
        "from linecontact.studies.terminal import console\n"
        "console.Bar.every = 0.1\n"
        "sys.exit(entry.main())"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, ctrl_c),
    )
    first = process.stderr.readline()  # a line of progress: the solve, which takes minutes, is under way
    assert b"residual" in first
    process.send_signal(sign)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert solution_files.load(file).results["status"] == "interrupted"


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_full_disk_keeps_the_result_and_leaves_no_file(tmp_path):
    own = "export PYTHONDONTWRITEBYTECODE=1 GIT_OPTIONAL_LOCKS=0"  # files that would be cut off and stay
    program = ["/bin/sh", "-c", f'{own}; ulimit -f 8; exec "$@"', "sh", *CLI]
    result = run("solve", "--num-points", 4096, "--json", "--save", tmp_path / "run.h5", program=program)
    assert result.returncode == 2
    assert json.loads(result.stdout)["status"] == "converged"
    assert result.stderr.startswith(f"linecontact: file {tmp_path / 'run.h5'} could not be written")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    "sign", [signal.SIGKILL, *(pytest.param(sign, marks=pytest.mark.slow) for sign in (signal.SIGINT, signal.SIGTERM))]
)
def test_a_killed_study_continues(tmp_path, sign):
    """As a command at first, then as a module."""
    command = [*CLI, "study", "hertz", "--quick", "--folder", str(tmp_path), "--workers", "2"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True)
    file, tasks = tmp_path / "hertz.h5", tmp_path / "tasks"
    while not list(tasks.glob("*.json")):
        assert process.poll() is None
        time.sleep(0.02)
    # a terminal and a scheduler signal the workers, too
    process.send_signal(sign) if sign == signal.SIGKILL else os.killpg(process.pid, sign)
    _, stderr = process.communicate(timeout=60)  # the pipes close only when the workers have ended, too
    assert b"Traceback" not in stderr
    assert b"died" not in stderr
    assert b"resource_tracker" not in stderr or sign == signal.SIGKILL
    assert process.returncode == (-9 if sign == signal.SIGKILL else 130)
    kept = {path: path.stat().st_mtime_ns for path in tasks.glob("*.json")}
    assert 1 <= len(kept) < 43
    result = run("--quick", "--folder", tmp_path, program=[sys.executable, "-m", "linecontact.studies.hertz"])
    assert result.returncode == 0, result.stderr
    assert "6/6" in result.stdout
    assert f"{len(kept)} of 43 tasks {'is' if len(kept) == 1 else 'are'} done" in result.stderr
    assert all(path.stat().st_mtime_ns == written for path, written in kept.items())  # not computed again
    finished = study_files.load_study(file)
    assert finished.complete
    assert len(finished.runs) == 37
    again = here("study", "hertz", "--quick", "--folder", tmp_path)
    assert "nothing computed" in again.stdout
    other = here("study", "hertz", "--folder", tmp_path)
    assert other.returncode == 2
    assert "made with other options" in other.stderr


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_a_reader_that_goes_away_is_no_traceback():
    for form in (["--json"], [], ["--help"]):
        command = [*CLI, "solve", "--num-points", "64", *form]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.close()
            stderr = process.stderr.read()
        assert process.returncode == 141
        assert not stderr


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_without_a_reader_of_messages_the_status_is_the_same():
    for words, status in ((["--pressure", "-1"], 2), (["--num-points", "4096", "--max-iterations", "1"], 3)):
        command = [*CLI, "solve", *words]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            process.stderr.close()
        assert process.returncode == status, words


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
def test_a_full_disk_behind_the_output_is_one_line():
    for arguments in (["solve", "--num-points", "64"], ["solve", "--num-points", "64", "--json"]):
        with open("/dev/full", "w") as full:
            result = subprocess.run([*CLI, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
        assert result.returncode == 2
        said = result.stderr.splitlines()[-1]  # after the progress, where the machine is busy
        assert said == "linecontact: standard output could not be written (No space left on device)"


def test_info_and_version():
    result = run("info")
    assert result.returncode == 0, result.stderr
    for word in ("version", "warp-lang", "FFTW wisdom", "kernel cache", "kernel flags", "cpu"):
        assert word in result.stdout
    assert run("--version").stdout == f"linecontact {linecontact.__version__}\n"


def test_gaps_between_two_nodes_are_in_the_table():
    words = ("--profile", "rough", "--cut-off-ratio", 0.125, "--num-points", "2^9", "--thickness", 0.05, "--pressure")
    assert "gaps and patches that no node shows" in here("solve", *words, 1.6).stdout
    assert "gaps and patches that no node shows" not in here("solve", *words, 0.1).stdout


def test_iterations_study(tmp_path):
    """The number of FIRE's iterations grows with the root of that of the points, unless masses are weighted."""
    assert here("study", "iterations", "--quick", "--folder", tmp_path).returncode == 0
    assert (tmp_path / "iterations.png").exists()
    study = study_files.load_study(tmp_path / "iterations.h5")
    assert study.complete
    counts = {m: study.column("iterations")[study.column("method") == m] for m in ("fire", "mass-weighted-fire")}
    assert counts["fire"][-1] > 1.5 * counts["fire"][0]  # sqrt(4) = 2 expected from 2^12 to 2^14
    assert counts["mass-weighted-fire"][-1] < 1.34 * counts["mass-weighted-fire"][0]


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="sees Linux' processes only")
def test_ctrl_c_during_imports_is_one_line():
    command = [sys.executable, "-m", "linecontact.studies", "solve"]
    handled = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, **handled) as process:
        while "_multiarray_umath" not in Path(f"/proc/{process.pid}/maps").read_text():
            assert process.poll() is None
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        assert process.communicate()[1] == "linecontact: interrupted\n"
    assert process.returncode == 130


@pytest.mark.parametrize(
    "lines",
    [
        [
            "from linecontact.studies.command_line import main",
            "def interrupted(): raise KeyboardInterrupt",
            "main.prepare = lambda: interrupted",
        ],
        [
            "import atexit, signal",
            "signal.signal(signal.SIGINT, signal.default_int_handler)",
            "atexit.register(signal.raise_signal, signal.SIGINT)",
        ],
    ],
)
def test_ctrl_c_outside_of_a_command_is_one_line(lines):
    """Before it, and when it has ended."""
    program = "\n".join([*lines, "from linecontact.studies import __main__ as entry", "entry.main()"])
    result = run("--version", program=[sys.executable, "-c", program])
    assert (result.returncode, result.stderr) == (130, "linecontact: interrupted\n")
