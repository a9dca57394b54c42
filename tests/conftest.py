"""What tests share: one thread for linear algebra, where the dummies of a study log, and a folder for a study."""

import gc
import os
from pathlib import Path

import pytest
from linecontact.studies.one_thread import ONE_THREAD

# Tests run side by side, and so do the studies in them. Threads of several of them on the same cores wait for each
# other, and their number may change the last bit. To be set before NumPy is loaded.
os.environ.update(ONE_THREAD)
# Tests start some 150 programs. Without stored bytecode each of them compiles this package again, in half a second.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# A tenth of the time in which figures are drawn goes by in looking for garbage.
gc.set_threshold(100_000)


@pytest.fixture
def dummies(tmp_path, monkeypatch):
    """Where the dummies log, for this process and its children; and what children import."""
    (tmp_path / "dummies").mkdir()
    monkeypatch.setenv("DUMMY_FOLDER", str(tmp_path / "dummies"))
    path = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path))


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "study"


@pytest.fixture
def own(monkeypatch):
    """No variants of one's own but those that the test registers."""
    from linecontact.studies.kernel_benchmark import variants

    monkeypatch.setattr(variants, "OWN", {})
    variants._run_file.cache_clear()
    return variants.OWN


@pytest.fixture
def wisdom_cache(tmp_path, monkeypatch):
    """An empty cache folder, and a process that has not looked for wisdom yet."""
    import pyfftw
    from linecontact.solver.grid import cached
    from linecontact.solver.transforms import wisdom

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(wisdom, "_loaded", False)
    pyfftw.forget_wisdom()
    cached.forget()
    yield tmp_path
    pyfftw.forget_wisdom()
