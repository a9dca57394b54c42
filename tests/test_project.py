"""The project itself: style, types, the wheel, the README's example."""

import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("kernels", "solver", "studies")


def run(*command, **options):
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=600, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_style():
    run(sys.executable, "-m", "ruff", "check", ".", cwd=ROOT)
    run(sys.executable, "-m", "ruff", "format", "--check", ".", cwd=ROOT)


def test_types(tmp_path):
    """mypy sees the folders under their import name through links, as an installed package has them."""
    package = tmp_path / "linecontact"
    package.mkdir()
    for folder in FOLDERS:
        (package / folder).symlink_to(ROOT / folder, target_is_directory=True)
    packages = [word for folder in FOLDERS for word in ("-p", f"linecontact.{folder}")]
    options = ["--config-file", ROOT / "pyproject.toml", "--namespace-packages", "--explicit-package-bases"]
    environment = {**os.environ, "MYPYPATH": str(tmp_path)}
    run(sys.executable, "-m", "mypy", *options, *packages, cwd=tmp_path, env=environment)


def test_wheel(tmp_path):
    """A wheel, installed into a fresh environment that borrows only the dependencies, solves a scene."""
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", tmp_path, ROOT)
    (wheel,) = tmp_path.glob("linecontact-*.whl")
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


def test_readme_example(tmp_path):
    readme = (ROOT / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert blocks
    assert not re.search(r"@[A-Z]+@", readme)
    for image in re.findall(r"!\[[^]]*\]\(([^)]+)\)", readme):
        assert (ROOT / image).stat().st_size > 10_000
    for block in blocks:
        run(sys.executable, "-c", block, cwd=tmp_path)


def test_ci_runs_the_readme_command():
    readme, script = (ROOT / "README.md").read_text(), (ROOT / ".ci" / "run").read_text()
    (command,) = re.findall(r"^(python3 -m venv .*pytest.*)$", readme, re.MULTILINE)
    assert command in script.splitlines()


@pytest.mark.parametrize("folder", FOLDERS)
def test_imports_go_one_way(folder):
    above = {"kernels": ("solver", "studies"), "solver": ("studies",), "studies": ()}[folder]
    for file in (ROOT / folder).glob("*.py"):
        imports = [line for line in file.read_text().splitlines() if re.match(r"\s*(from|import) ", line)]
        for name in above:
            assert not [line for line in imports if re.search(rf"\b{name}\b", line)], file
