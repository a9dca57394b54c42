"""Who imports whom, read from the source of all folders and sub-folders: from upper floors to lower, in no circle.

Imports inside functions count like all others. A sub-folder of solver/ or studies/ says in the docstring of its
`__init__` what it may import, in a sentence of its own, on new lines:

    May import: linecontact.kernels, linecontact.solver, terminal, files.

Names are folders of the project (`linecontact.kernels`), or neighbours of the sub-folder: other sub-folders, or single
modules. The `__init__` of the folder above may always be imported.
"""

import ast
import functools
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("kernels", "solver", "studies")
FORBIDDEN = {"kernels": ("solver", "studies"), "solver": ("studies",), "studies": ()}


def read_modules(root):
    """Source trees of all modules by their names; a package has the name of its folder."""
    modules = {}
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*.py")):
            parts = file.relative_to(root).with_suffix("").parts
            name = ".".join(("linecontact", *(parts[:-1] if parts[-1] == "__init__" else parts)))
            modules[name] = ast.parse(file.read_text())
    return modules


def packages(root):
    """Names of all folders that hold an `__init__`."""
    files = (file.relative_to(root).parent.parts for folder in FOLDERS for file in (root / folder).rglob("__init__.py"))
    return {".".join(("linecontact", *parts)) for parts in files}


def imported(module, tree, modules, is_package):
    """Names of the project's modules that one of them imports, anywhere in its source."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                parts = alias.name.split(".")
                prefixes = [".".join(parts[:k]) for k in range(len(parts), 0, -1)]
                found |= {next((name for name in prefixes if name in modules), module)}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = module.split(".")[: len(module.split(".")) - node.level + is_package]
                base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                found |= {name for name in [inner if inner in modules else base] if name in modules}
    return found - {module}


def read(root):
    """Source trees of all modules, the names of the folders among them, and what each module imports of the project."""
    modules, folders = read_modules(root), packages(root)
    return modules, folders, {name: imported(name, tree, modules, name in folders) for name, tree in modules.items()}


@functools.cache
def read_project():
    """The same of this project; it takes more than a second."""
    return read(ROOT)


def circle(graph):
    """Some path that comes back to its start, or an empty list."""
    state, path = {}, []

    def visit(name):
        state[name] = "open"
        path.append(name)
        for other in sorted(graph.get(name, ())):
            if state.get(other) == "open":
                return [*path[path.index(other) :], other]
            if other not in state and (found := visit(other)):
                return found
        state[name] = "closed"
        path.pop()
        return []

    return next((found for name in sorted(graph) if name not in state and (found := visit(name))), [])


def permissions(package, modules):
    """What a sub-folder may import, as full names; None if it does not say."""
    line = re.search(r"^May import: (.+?)\.$", ast.get_docstring(modules[package]) or "", re.MULTILINE | re.DOTALL)
    if line is None:
        return None
    above = package.rpartition(".")[0]
    names = [name.strip() for name in line[1].split(",")]
    return {name if name.startswith("linecontact.") else f"{above}.{name}" for name in names}


def inside(name, folder):
    return name == folder or name.startswith(f"{folder}.")


def forbidden_imports(modules, folders, graph):
    """A line on every import that a sub-folder's `__init__` does not allow."""
    lines = []
    for package in sorted(folders):
        if package.count(".") < 2:
            continue
        allowed = permissions(package, modules)
        if allowed is None:
            if inside(package, "linecontact.studies"):
                lines.append(f"{package} does not say what it may import")
            continue
        lines += [f"{package} may import {name}, which does not exist" for name in sorted(allowed - modules.keys())]
        for module in sorted(name for name in graph if inside(name, package)):
            for other in sorted(graph[module]):
                ancestor = inside(package, other)
                if not ancestor and not any(inside(other, name) for name in (package, *allowed)):
                    lines.append(f"{module} imports {other}")
    return lines


@pytest.mark.parametrize("folder", FOLDERS)
def test_folders_import_one_way(folder):
    _, _, graph = read_project()
    own = {name: others for name, others in graph.items() if inside(name, f"linecontact.{folder}")}
    assert len(own) > 3
    for above in FORBIDDEN[folder]:
        assert not [name for name, others in own.items() if any(inside(o, f"linecontact.{above}") for o in others)]


def test_no_modules_import_each_other_in_a_circle():
    _, _, graph = read_project()
    assert not circle(graph)


def test_sub_folders_import_what_they_say():
    assert not forbidden_imports(*read_project())


def test_sub_folders_allow_no_circle():
    modules, folders, _ = read_project()
    allowed = {name: permissions(name, modules) or set() for name in folders if name.count(".") > 1}
    assert allowed
    assert not circle(allowed)


# that the reading finds what there is to find


@pytest.fixture
def project(tmp_path):
    """Two rooms, of which the upper imports the lower, and the list above them."""
    files = {
        "kernels/__init__.py": "",
        "solver/__init__.py": "from linecontact import kernels\n",
        "studies/__init__.py": "",
        "studies/low/__init__.py": '"""A room.\n\nMay import: linecontact.solver.\n"""\n',
        "studies/low/a.py": "from .. import STUDIES\nfrom . import b\n",
        "studies/low/b.py": "from linecontact.solver import solve\n",
        "studies/high/__init__.py": '"""A room.\n\nMay import: low.\n"""\n',
        "studies/high/a.py": "from ..low import a\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("def later():\n    from ..high import a\n", "linecontact.studies.low.b imports linecontact.studies.high.a"),
        ("import linecontact.kernels\n", "linecontact.studies.low.b imports linecontact.kernels"),
        ("from linecontact.studies.high import a\n", "linecontact.studies.low.b imports linecontact.studies.high.a"),
    ],
)
def test_a_forbidden_import_is_found(project, line, found):
    (project / "studies/low/b.py").write_text(line)
    modules, folders, graph = read(project)
    assert forbidden_imports(modules, folders, graph) == [found]
    assert bool(circle(graph)) == ("high" in line)


def test_a_sub_folder_that_says_nothing_is_found(project):
    (project / "studies/low/__init__.py").write_text('"""A room."""\n')
    assert forbidden_imports(*read(project)) == ["linecontact.studies.low does not say what it may import"]
    (project / "studies/low/__init__.py").write_text('"""A room.\n\nMay import: linecontact.solver, cellar.\n"""\n')
    assert forbidden_imports(*read(project)) == [
        "linecontact.studies.low may import linecontact.studies.cellar, which does not exist"
    ]
