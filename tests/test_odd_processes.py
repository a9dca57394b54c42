"""Processes as they happen to be: with threads, forked, after a power cut, without streams, on full disks, or wrong."""

import functools
import itertools
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import linecontact
import numpy as np
import pytest
from linecontact import locks
from linecontact.kernels import derived
from linecontact.solver import MeasuredIndenter
from linecontact.solver.transforms import plain
from linecontact.studies.command_line import main
from linecontact.studies.curve import report
from linecontact.studies.explore.newest import Newest
from linecontact.studies.figures import solution
from linecontact.studies.files import hdf5, solution_files
from linecontact.studies.kernel_benchmark import c_code
from linecontact.studies.terminal import console
from linecontact.studies.terminal.text import BUG, is_refusal

CLI = [sys.executable, "-m", "linecontact.studies"]
SOLVE = [*CLI, "solve", "--num-points", "64", "--json"]
posix = pytest.mark.skipif(os.name != "posix", reason="as POSIX has it")


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)


def python(program, **environment):
    return run([sys.executable, "-W", "ignore", "-c", program], env={**os.environ, **environment})


FORK = """
import os, signal, threading, time
from linecontact import Layer, Scene, solve

def forked(work):
    child = os.fork()
    if not child:
        signal.alarm(60)
        os._exit(work() or 0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
"""
FORKS = """
os.chdir(os.environ["FOLDER"])
METHODS, ended = ("active-set", "mass-weighted-fire"), []
drawn = solve(Scene(num_points=256))

def draw():
    while not ended:
        drawn.plot("thread.png")
        time.sleep(0.01)

def work(start):
    i = start
    while not ended:
        i += 1
        scene = Scene(Layer(thickness=0.1 + i * 1e-4), num_points=2 ** (10 + i % 4))
        solve(scene, method=METHODS[i % 2], tolerance=1e-3)

def child(i):
    if i % 5 == 0:
        drawn.plot("child.png")
    solution = solve(Scene(Layer(thickness=0.3 + i * 1e-3), num_points=2 ** (10 + i % 4)), method=METHODS[i % 2])
    return solution.status != "converged"

solve(Scene(num_points=64), method="fire", tolerance=0.1)
for thread in (*(threading.Thread(target=work, args=(1000 * i,)) for i in range(2)), threading.Thread(target=draw)):
    thread.start()
for i in range(20):
    print(forked(lambda: child(i)))
ended.append(True)
"""


@posix
def test_children_of_a_process_that_is_solving_and_drawing_do_so_too(tmp_path):
    said = python(FORK + FORKS, FOLDER=str(tmp_path))
    assert said.stdout.split() == ["0"] * 20, said.stderr


def test_the_end_of_a_plan_waits_for_no_other_thread():
    """It may come with a collection of garbage, beside any lock; the plan goes with a later one."""
    pairs = [plain.Pair(64), plain.Pair(64)]
    for pair in pairs:
        pair.forward()
    with locks.PLANNING:
        thread = threading.Thread(target=lambda: pairs.pop().__dict__.clear())
        thread.start()
        thread.join(60)
        assert not thread.is_alive()
    assert len(plain.Plan._ended) == 1
    pairs.pop().__dict__.clear()
    assert not plain.Plan._ended


OWN_THREADS = """
import os
import pyfftw
from linecontact import Scene, solve

values = pyfftw.zeros_aligned(2**16)
pyfftw.FFTW(values, pyfftw.zeros_aligned(2**15 + 1, dtype=complex), threads=2)()
child = os.fork()
if not child:
    solve(Scene(num_points=64))
    try:
        solve(Scene(num_points=2**16), threads=2)
    except ValueError as error:
        os._exit(17 if "threads is 2; allowed: 1 in a process that was forked" in str(error) else 1)
    os._exit(2)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


COLD_FORK = """
import os, signal, threading, time
import linecontact

def work():
    import pyfftw
    linecontact.solve(linecontact.Scene(num_points=64))

thread = threading.Thread(target=work)
thread.start()
children = []
for i in range(12):
    time.sleep(0.03)
    children.append(os.fork())
    if not children[-1]:
        signal.alarm(60)
        solution = linecontact.solve(linecontact.Scene(num_points=64), method=("active-set", "fire")[i % 2])
        os._exit(solution.status != "converged")
print(*(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children))
"""


@posix
def test_children_of_a_process_whose_first_solve_is_under_way_solve_too():
    """What a thread imports at the fork would stay half imported."""
    said = python(COLD_FORK)
    assert said.stdout.split() == ["0"] * 12, said.stderr


SLOW_IMPORT = """
import sys
import numpy as np

class Slow:
    def find_spec(self, name, *_):
        if name == "numpy.random._pickle":
            begun.set()
            time.sleep(1.0)

begun = threading.Event()
sys.meta_path.insert(0, Slow())
threading.Thread(target=lambda: np.random).start()
begun.wait(1.0)
print(forked(lambda: solve(Scene(num_points=64), method="mass-weighted-fire") and 0))
"""


@posix
def test_children_find_no_half_imported_part_of_numpy():
    """NumPy imports some of its parts when they are asked for first."""
    assert python(FORK + SLOW_IMPORT).stdout == "0\n"


LATE_IMPORT = OWN_THREADS.replace("from linecontact import Scene, solve\n", "").replace(
    "    solve(Scene(num_points=64))", "    from linecontact import Scene, solve\n    solve(Scene(num_points=64))"
)


@pytest.mark.skipif(sys.platform != "linux", reason="Linux says that a process was forked")
@pytest.mark.parametrize("program", [OWN_THREADS, LATE_IMPORT], ids=["before", "late"])
def test_a_forked_process_waits_for_no_threads_of_the_user_s_own_transforms(program):
    """Also where it imports the package late."""
    assert python(program).stdout == "17\n"


OWN_PLANNING = """
import pyfftw
from linecontact.solver.transforms import plain

def refused():
    for _ in range(2):
        try:
            solve(Scene(num_points=64), method="fire")
        except ValueError as error:
            told = "forked while another of its threads planned" in str(error)
    return 17 if told else 1

plain._PATIENCE = 1.0
values = pyfftw.empty_aligned(2**18, dtype=complex)
plan = {"args": (values, values), "kwargs": {"flags": ["FFTW_PATIENT"]}, "daemon": True}
threading.Thread(target=pyfftw.FFTW, **plan).start()
time.sleep(0.3)
print(forked(refused), flush=True)
os._exit(0)
"""


@posix
def test_a_forked_process_does_not_wait_for_the_user_s_own_planning():
    assert python(FORK + OWN_PLANNING).stdout == "17\n"


WRITES = """
import os, threading
from linecontact.kernels import start_warp

before, count = os.fstat(2), 0
threads = [threading.Thread(target=start_warp) for _ in range(4)]
for thread in threads:
    thread.start()
while any(thread.is_alive() for thread in threads):
    os.write(2, b"line\\n")
    count += 1
after = os.fstat(2)
print(count, (before.st_dev, before.st_ino) == (after.st_dev, after.st_ino))
"""


def test_standard_error_loses_nothing_while_threads_start_warp_and_is_as_before():
    said = python(WRITES)
    count, same = said.stdout.split()
    assert same == "True"
    assert said.stderr == "line\n" * int(count)


DAMAGES = {
    "truncated": lambda content: content[: len(content) // 2],
    "one bit": lambda content: content[:-1] + bytes([content[-1] ^ 1]) if content else b"x",
}
LOAD = (
    "import linecontact.kernels as k; k.load(); import linecontact as l; print(l.solve(l.Scene(num_points=64)).status)"
)


@pytest.fixture(scope="module")
def kernel_cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kernels")
    assert python(LOAD, WARP_CACHE_PATH=str(folder)).stdout == "converged\n"
    return folder


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_cache_is_made_again_once(kernel_cache, damage):
    files = [file for file in kernel_cache.rglob("*") if file.suffix in (".o", ".meta", ".cpp")]
    whole = {file: file.read_bytes() for file in files}
    assert len(files) == 12
    for file, content in whole.items():
        file.write_bytes(DAMAGES[damage](content))
    for said in ("linecontact: compiling kernels for this processor, once; this takes some seconds\n", ""):
        again = python(LOAD, WARP_CACHE_PATH=str(kernel_cache))
        assert (again.stdout, again.stderr) == ("converged\n", said)
    assert all(derived.is_whole(file) for file in files if file.suffix != ".cpp")


@pytest.mark.parametrize("make", [os.mkdir, pytest.param(getattr(os, "mkfifo", None), marks=posix)])
def test_no_file_in_a_derived_file_s_place_is_taken_away(kernel_cache, make):
    python(LOAD, WARP_CACHE_PATH=str(kernel_cache))  # seals
    kept = {".o": 0, ".meta": 1, ".sha256": 2}
    modules = sorted(folder for folder in kernel_cache.rglob("*linecontact*") if folder.is_dir())
    for file in [file for i, folder in enumerate(modules) for file in folder.iterdir() if kept.get(file.suffix) == i]:
        file.unlink()
        make(file)
        if file.is_dir():
            (file / "inside").touch()
    for _ in range(2):
        again = python(LOAD, WARP_CACHE_PATH=str(kernel_cache))
        assert again.stdout == "converged\n", again.stderr
    assert again.stderr == ""


def test_a_file_in_a_module_s_place_is_taken_away(kernel_cache):
    for folder in [folder for folder in kernel_cache.rglob("*linecontact*") if folder.is_dir()]:
        shutil.rmtree(folder)
        folder.write_bytes(b"x")
    again = python(LOAD, WARP_CACHE_PATH=str(kernel_cache))
    assert (again.stdout, again.stderr.count("\n")) == ("converged\n", 1)


@pytest.mark.parametrize("damage", ["one bit", "folder"])
def test_a_damaged_library_of_c_is_made_again(tmp_path, monkeypatch, damage):
    """A process that loads one may end at once, so it is not loaded."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    if not c_code.compile_c.__wrapped__().libraries:
        pytest.skip("no C compiler")
    for library in tmp_path.rglob("*.so"):
        content = library.read_bytes()
        library.unlink()  # this process has loaded it
        if damage == "folder":
            library.mkdir()
        else:
            library.write_bytes(DAMAGES[damage](content))
        assert not derived.is_whole(library)
    count = "from linecontact.studies.kernel_benchmark.c_code import compile_c; print(len(compile_c().libraries))"
    assert python(count, XDG_CACHE_HOME=str(tmp_path)).stdout == f"{len(c_code.BUILDS)}\n"
    assert all(derived.is_whole(library) for library in tmp_path.rglob("*.so"))


@posix
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("words", ["solve --num-points 64 --save run.h5", "--version"])
def test_closed_streams(tmp_path, words, closed):
    ended = run(["sh", "-c", f'"$0" -m linecontact.studies {words} {closed}', sys.executable], cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "run.h5").exists() == ("save" in words)
    assert bool(ended.stdout) == (">&-" not in closed.split())
    refused = run(["sh", "-c", f'"$0" -m linecontact.studies plot nothing.h5 {closed}', sys.executable], cwd=tmp_path)
    assert refused.returncode == 2


@posix
@pytest.mark.parametrize("name", ["ü.csv", os.fsdecode(b"b\xffd.csv")])
@pytest.mark.parametrize(
    "locale", [{"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}]
)
def test_a_terminal_that_knows_few_characters(tmp_path, name, locale):
    rows = "".join(f"{i},{math.sin(i / 9):.4f}\n" for i in range(64))
    (tmp_path / name).write_text("x [um],z [um]\n" + rows)
    words = [*CLI, *["solve", "--profile", "file", "--thickness", "1mm", "--contact-modulus", "1e6", "--plot"]]
    words += ["--profile-file", name, "--save", name[:-4] + ".h5"]
    environment = {**os.environ, **locale}
    for status, more in ((0, "--pressure 200"), (2, "--pressure 200"), (2, "--pressure -1 --overwrite")):
        options = {"cwd": tmp_path, "env": environment, "timeout": 300}
        ended = subprocess.run([*words, *more.split()], capture_output=True, **options)
        assert ended.returncode == status, ended.stderr
        assert b"Traceback" not in ended.stderr
        assert ended.stdout.isascii()
    assert len(list(tmp_path.iterdir())) == 4


SMALL_FILES = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (2**15, 2**15))
from linecontact.studies.__main__ import main
sys.exit(main())
"""


@posix
def test_a_full_disk_behind_the_kernel_cache_is_named(tmp_path):
    """A limit on files stands for it; a bytecode file that it cuts short would break the next program."""
    words = [sys.executable, "-c", SMALL_FILES, "solve", "--num-points", "2^14"]
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    cold = run([*words, "--method", "fire", "--tolerance", "0.1"], env=environment)
    assert cold.returncode == 2
    told = rf"linecontact: Warp's kernel cache {tmp_path}"
    assert cold.stderr.splitlines()[-1].startswith(told)
    assert "WARP_CACHE_PATH" in cold.stderr


def test_a_folder_that_is_gone_is_named(tmp_path):
    """Where a name is relative to it."""
    words = "solve --profile file --profile-file scan.csv --pressure 1 --patches p.csv"
    ended = run(["sh", "-c", f'rmdir "$PWD" && "$0" -m linecontact.studies {words}', sys.executable], cwd=tmp_path)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1), ended.stderr
    assert "is gone" in ended.stderr


@pytest.fixture
def ctrl_c():
    """Raises KeyboardInterrupt, which it perhaps does not in the background of a script."""
    ignored = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, ignored)


def refused(make):
    with pytest.raises(ValueError, match=r".") as caught:
        make()
    return is_refusal(caught.value)


def test_only_what_we_raise_ourselves_is_bad_input():
    assert refused(lambda: linecontact.Layer(thickness=-1))
    assert refused(lambda: MeasuredIndenter([[1]], convention="gap"))
    for bug in (lambda: math.log(0), lambda: float("x"), lambda: int("9" * 5000), lambda: max([]), lambda: [].index(1)):
        assert not refused(bug)
        with pytest.raises(ValueError, match=r".") as caught:
            console.guard(bug)
        assert caught.value.__notes__ == [BUG]


BROKEN = """
import math, sys
from linecontact.solver import TabulatedLayer
from linecontact.solver.solve import solve_to_tolerance
from linecontact.studies.curve import number
number.check = number.put = TabulatedLayer.__post_init__ = lambda *_: math.log(0)
solve_to_tolerance.__globals__["_reachable"] = lambda *_: math.log(0)
from linecontact.studies.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    "words",
    ["solve --num-points 64", "solve --layer file --stiffness-file k.txt", "curve --over pressure --from 1e-3 --to 1"],
)
def test_a_bug_is_a_traceback_and_status_1(tmp_path, words):
    (tmp_path / "k.txt").write_text("".join(f"{q} {q}\n" for q in range(1, 9)))
    ended = run([sys.executable, "-c", BROKEN, *words.split()], cwd=tmp_path)
    assert ended.returncode == 1
    assert ended.stderr.startswith("Traceback")
    assert ended.stderr.endswith(f"{BUG}\n")
    assert "a bug, please report" in BUG


@pytest.mark.parametrize(("bug", "ours"), [(KeyError, True), (ValueError, True), (AssertionError, False)])
def test_a_bug_beside_a_result_is_no_damaged_file(tmp_path, monkeypatch, bug, ours):
    """While a command draws its own result, any error is; beside a file, one that no content leads to."""

    def broken(*_):
        raise bug

    path = str(tmp_path / "run.h5")
    make = [*SOLVE[len(CLI) :], "--save", path, "--overwrite"]
    assert main.main(make) == 0
    if not ours:
        monkeypatch.setattr(hdf5, "_written", set())
    for module, name in ((solution, "figure"), (solution_files, "_patches")):
        with monkeypatch.context() as patched:
            patched.setattr(module, name, broken)
            with pytest.raises(bug) as caught:
                main.main([*make, "--plot"] if ours else ["plot", path])
            assert BUG in caught.value.__notes__
    assert main.main(["plot", path]) == 0


def test_a_bug_beside_a_study_is_no_damaged_file(tmp_path, monkeypatch, capsys):
    def broken(*_):
        raise KeyError

    words = "curve --over pressure --from 1e-3 --to 1e-2 --num-points 64 --points 2 --workers 1 --folder"
    study = [*words.split(), str(tmp_path)]
    monkeypatch.setattr(report, "means", broken)
    with pytest.raises(KeyError):
        main.main(study)
    assert main.main(study) == 2  # all of it was there: the file, or a bug
    assert "this is a bug, please report it" in capsys.readouterr().err


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_takes_any_residual(capsys, monkeypatch, terminal):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(console, "errors", type(console.errors)(stderr=True, highlight=False, force_terminal=terminal))
    monkeypatch.setattr(console.Bar, "every", -1.0)
    odd = [math.inf, math.nan, -math.inf, 0.0, -0.0, -1.0, 5e-324, 1e-8, 1e308, 3.0]
    for first, tolerance in itertools.product(odd, (1e-14, 0.5, 10.0)):
        with console.solve_progress(tolerance) as report:
            for i, residual in enumerate([first, *odd, *reversed(odd)]):
                report(i, residual)
    assert BUG not in capsys.readouterr().err


def test_no_columns_are_as_many_as_there_are_where_nothing_is_known():
    """Rich takes the variable as it is, and would print nothing."""
    told = [run(SOLVE[:-1], env={**os.environ, "COLUMNS": columns}).stdout for columns in ("80", "0")]
    head = [text.splitlines()[:6] for text in told]
    assert head[0] == head[1]
    assert head[0]


def test_numpy_s_errors_are_the_user_s_own():
    """They are no errors of a solve, and as they were afterwards."""
    with np.errstate(all="raise"):
        before = np.geterr()
        rough = linecontact.RoughIndenter(hurst=0.3, cut_off_ratio=0.01)
        linecontact.solve(linecontact.Scene(linecontact.Layer(1e-3), rough, pressure=0.5, num_points=2**14))
        assert np.geterr() == before


def test_progress_that_fails_is_told_once_and_ends_nothing(capsys):
    with console.Bar("work") as bar:
        for share in (lambda: (math.nan, ""), lambda: (math.inf, ""), lambda: (math.log(0), ""), lambda: 1 / 0):
            bar.show(share)
    assert capsys.readouterr().err.count("a bug, please report it: no progress is shown") == 1


@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-2}])
@pytest.mark.parametrize("error", [ZeroDivisionError, StopIteration])
def test_a_callback_of_the_user_s_own_may_end_a_solve(monkeypatch, error, options):
    def fail(*_):
        raise error

    monkeypatch.setattr("linecontact.solver.methods.method.time.monotonic", iter(range(100)).__next__)
    rough = linecontact.Scene(indenter=linecontact.RoughIndenter(cut_off_ratio=1 / 64), num_points=2**12)
    with pytest.raises(error):
        linecontact.solve(rough, progress=fail, **options)


@pytest.mark.parametrize("ended", [True, False])
def test_work_for_a_page_that_is_closed_is_no_traceback(capsys, ended):
    def work(_):
        if ended:
            newest._ended = True
        raise AttributeError("the document is gone")

    newest = Newest(work)
    if not ended:
        newest.told = 0.0
    newest.ask(None)
    newest._thread.join(1.0)
    assert newest._thread.is_alive() != ended
    newest.end(10.0)
    assert ("AttributeError" in capsys.readouterr().err) != ended


@pytest.mark.parametrize("name", ["start", "stop"])
def test_ctrl_c_while_a_bar_begins_or_ends_leaves_the_cursor(capsys, monkeypatch, ctrl_c, name):
    """After the begin, and before the end."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(console, "errors", type(console.errors)(stderr=True, highlight=False, force_terminal=True))
    begin, end, stopped = console.Progress.start, console.Bar.end, []

    def interrupted():
        if not stopped:
            stopped.append(True)
            signal.raise_signal(signal.SIGINT)
        end()

    def command():
        with console.Bar("work"):
            return 0

    if name == "start":
        monkeypatch.setattr(console.Progress, "start", lambda bar: (begin(bar), signal.raise_signal(signal.SIGINT)))
    else:
        monkeypatch.setattr(console.Bar, "end", interrupted)
    assert console.guard(command) == 130
    said = capsys.readouterr().err
    assert said.rfind("\x1b[?25h") > said.rfind("\x1b[?25l") >= 0
    assert not console.Bar.shown


@pytest.mark.parametrize("pause", [0.0, 0.3])
def test_what_ctrl_c_waits_for_is_said_where_it_takes_longer(monkeypatch, capsys, ctrl_c, pause):
    def command():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            time.sleep(pause)
            raise

    monkeypatch.setattr(console, "_SOON", 0.1)
    assert console.guard(command) == 130
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    first = f"{console._WAIT}\n" * (pause > 0)
    assert " ".join(capsys.readouterr().err.split()) == " ".join(f"{first}linecontact: interrupted".split())


@posix
def test_ctrl_c_in_the_last_moment_of_a_command_leaves_no_alarm(monkeypatch, ctrl_c):
    """It comes while the command's own handlers are taken away."""

    def late(*given):
        monkeypatch.undo()
        signal.raise_signal(signal.SIGINT)
        return signal.signal(*given)

    def command():
        monkeypatch.setattr(signal, "signal", late)
        return 0

    before = signal.getsignal(signal.SIGALRM), sys.unraisablehook
    assert console.guard(command) == 130
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0
    assert before == (signal.getsignal(signal.SIGALRM), sys.unraisablehook)


@posix
def test_workers_go_on_where_the_caller_ignores_ctrl_c(tmp_path):
    """As in a script's background, where Ctrl-C is meant for another program."""
    command = [sys.executable, "-m", "linecontact.studies", "curve", "--num-points", "2^10", "--points", "6"]
    ignore = functools.partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
    with subprocess.Popen([*command, "--workers", "2", "--folder", str(tmp_path)], preexec_fn=ignore) as process:
        while not [*tmp_path.rglob("tasks/*")] and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0


LOST = """
import signal, sys, time
from linecontact.studies.terminal.console import guard

class Odd:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a script's background ignores it

def command():
    odd = Odd()
    del odd
    time.sleep(30)
    return 0

sys.exit(guard(command))
"""


@posix
def test_an_interruption_where_no_error_can_leave_is_made_again():
    """Python ignores an error in `__del__` and in callbacks of weak references."""
    said = python(LOST)
    assert (said.returncode, said.stderr) == (130, "linecontact: interrupted\n")


@posix
def test_a_fork_that_an_interruption_cuts_off_gives_its_locks_back():
    """It waits for another thread's lock when Ctrl-C comes."""
    held, free = threading.Event(), threading.Event()

    def hold():
        with locks.COMPILING:
            held.set()
            free.wait(60)

    other = threading.Thread(target=hold)
    other.start()
    held.wait(60)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with pytest.raises(KeyboardInterrupt):
            locks._take()
    finally:
        signal.signal(signal.SIGALRM, before)
    locks._give_back()
    free.set()
    other.join()
    taken = []

    def take():
        for lock in locks._ALL:
            taken.append(lock.acquire(timeout=5))
            lock.release()

    another = threading.Thread(target=take)
    another.start()
    another.join()
    assert taken == [True] * len(locks._ALL)
