"""Runs studies in tests: with other tasks than their own, and those of dummies as programs of their own."""

import hashlib
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace

import dummy_tasks
from linecontact.studies.files import study_files
from linecontact.studies.runner.run import run_study
from linecontact.studies.runner.study import Options

PATIENCE = 120  # seconds for what takes a second or two on an idle machine


def run_plans(study, plans, folder, **options):
    """Run a study with these plans instead of its own; returns the exit status."""
    return run_study(
        replace(study, plans=lambda _: plans), study.options(**{"folder": folder, "workers": 1, **options})
    )


def command(todo, folder, **options):
    """The study of these tasks in this process; returns the exit status."""
    return dummy_tasks.command([dummy_tasks.plan(todo)], Options(folder, **{"workers": 1, **options}))


def program(todo, folder, *options):
    """The same as a program of its own."""
    plans = todo if isinstance(todo, str) else f"[plan({todo})]"
    text = "import sys, dummy_tasks; sys.exit(dummy_tasks.main(*sys.argv[1:]))"
    workers = [] if "--workers" in options else ["--workers", "1"]
    return [sys.executable, "-c", text, plans, "--folder", str(folder), *workers, *options]


def finish(arguments, **options):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, **options)


def begin(arguments, **options):
    return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)


def wait_until(condition, process=None):
    """False if the process ended before."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        if process and process.poll() is not None:
            return False
        time.sleep(0.002)
    return True


def task_files(folder):
    """Name, content and time of every record there is; each must be whole."""
    files = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in (folder / "tasks").glob("*.json")}
    for content, _ in files.values():
        head, _, body = content.partition(b"\n")
        assert hashlib.sha256(body).hexdigest().encode() == head
    return files


def data(path):
    """Everything in a study's file but times."""
    file = study_files.load_study(path)
    assert file.complete
    names = sorted({name for run in file.runs for name in run if not name.startswith("seconds")})
    lines = {(line, name): v.tobytes() for line, columns in file.lines.items() for name, v in columns.items()}
    return {name: file.column(name).tobytes() for name in names}, lines, file.configuration


def begun():
    """How often each task was begun."""
    return Counter(number for number, _ in dummy_tasks.log())
