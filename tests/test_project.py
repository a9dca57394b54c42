"""The project itself: style, types, the wheel, the versions that it runs with."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.once

ROOT = Path(__file__).parent.parent
FOLDERS = ("kernels", "solver", "studies")


def run(*command, **options):
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=600, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_style():
    run(sys.executable, "-m", "ruff", "check", ".", cwd=ROOT)
    run(sys.executable, "-m", "ruff", "format", "--check", ".", cwd=ROOT)


def test_types(tmp_path, request):
    """mypy sees the folders under their import name through links, as an installed package has them.

    What it knows of files that have not changed since is kept with what pytest keeps.
    """
    package = tmp_path / "linecontact"
    package.mkdir()
    for folder in FOLDERS:
        (package / folder).symlink_to(ROOT / folder, target_is_directory=True)
    for file in (ROOT / "api").glob("*.py"):
        (package / file.name).symlink_to(file)
    options = ["--config-file", ROOT / "pyproject.toml", "--namespace-packages", "--explicit-package-bases"]
    options += ["--cache-dir", request.config.cache.mkdir("mypy")]
    environment = {**os.environ, "MYPYPATH": str(tmp_path)}
    run(sys.executable, "-m", "mypy", *options, "-p", "linecontact", cwd=tmp_path, env=environment)


def test_wheel(tmp_path):
    """A wheel, installed into a fresh environment that borrows only the dependencies, solves a scene."""
    shutil.rmtree(ROOT / "build", ignore_errors=True)  # setuptools would take modules from it that are gone
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", tmp_path, ROOT)
    (wheel,) = tmp_path.glob("linecontact-*.whl")
    modules = {f"linecontact/{file.relative_to(ROOT)}" for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")}
    modules |= {f"linecontact/{file.name}" for file in (ROOT / "api").glob("*.py")}
    with zipfile.ZipFile(wheel) as archive:
        assert {name for name in archive.namelist() if name.endswith(".py")} == modules
    environment = tmp_path / "venv"
    venv.create(environment)
    python = environment / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel)
    site = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    here = Path(run(sys.executable, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    (site / "dependencies.pth").write_text(f"{here}\n")  # its own .pth files, the editable install's too, are not read
    where = run(python, "-c", "import linecontact.solver as s; print(s.__file__)", cwd=tmp_path)
    assert str(environment) in where
    out = run(environment / "bin" / "linecontact", "solve", "--num-points", "64", "--json", cwd=tmp_path)
    assert '"status": "converged"' in out


def test_ci_runs_the_readme_command():
    """The commands that test, as the README has them, in its order."""
    readme, script = (ROOT / "README.md").read_text(), (ROOT / ".ci" / "run").read_text()
    readme_commands, commands = (
        re.findall(r"^(python3 -m venv .*pytest.*)$", t, re.MULTILINE) for t in (readme, script)
    )
    assert commands
    assert commands == [f"{command} || exit" for command in readme_commands]


def requirements(*extras):
    """Of the package and some extras, as name and lower bound."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    more = [line for extra in extras for line in project["optional-dependencies"][extra]]
    return dict(line.split(">=") for line in project["dependencies"] + more)


def pins(file):
    """Versions by name; a name can have several, for different Pythons."""
    found = {}
    for name, version in re.findall(r"^([\w-]+)==([\w.]+)", (ROOT / file).read_text(), re.MULTILINE):
        found.setdefault(name, []).append(version)
    return found


def test_the_lowest_versions_are_those_of_the_bounds():
    lowest = pins("tests/lowest.txt")
    for name, bound in requirements("test").items():
        assert lowest[name] == [bound]


def test_the_lock_file_holds_every_dependency_within_its_bounds():
    locked = pins("requirements-dev.lock")
    for name, bound in requirements("test", "docs").items():
        for version in locked[name]:
            assert [int(n) for n in version.split(".")] >= [int(n) for n in bound.split(".")], name
    text = (ROOT / "requirements-dev.lock").read_text()
    assert "://" not in text  # of no one's registry
    entries = [entry for entry in re.split(r"^(?=\w)", text, flags=re.MULTILINE) if "==" in entry]
    assert len(entries) == sum(map(len, locked.values()))
    assert all("--hash=sha256:" in entry for entry in entries)
