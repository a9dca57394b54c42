"""`linecontact explore` as a program: whom it answers, what it serves, how it ends, and its page in a real browser."""

import contextlib
import http.client
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from urllib.parse import urlsplit

import browser
import pytest
from bokeh.client import pull_session
from bokeh.util.token import generate_jwt_token
from linecontact.solver import Layer, Scene, solve
from linecontact.studies.command_line import main
from test_explore import resident, write_scan

pytestmark = pytest.mark.once

CLI = [sys.executable, "-m", "linecontact.studies", "explore"]
PATIENCE = 60  # seconds for what takes one or two on an idle machine


class Server:
    """The program, on a port that is free."""

    def __init__(self, *options, **environment):
        words = [*CLI, "--port", "0", *map(str, options)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        interrupted = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.default_int_handler)}
        self.process = subprocess.Popen(words, env={**os.environ, **environment}, **pipes, **interrupted)
        self.address = (self.process.stdout.readline().split() or [""])[0]
        self.port = urlsplit(self.address).port

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate(timeout=PATIENCE)

    def end(self, sign=signal.SIGINT):
        """Exit status and standard error after a signal."""
        self.process.send_signal(sign)
        _, stderr = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, stderr

    def ask(self, path="/", **headers):
        """Status and body of an answer; headers replace those of a client on this machine."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        named = {"Host": f"127.0.0.1:{self.port}"} | {name.replace("_", "-"): v for name, v in headers.items()}
        connection.putrequest("GET", path, skip_host=True)
        for name, value in named.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        found = answer.status, b"" if answer.status == 101 else answer.read()
        connection.close()
        return found


class Client:
    """A page of the server without a browser."""

    def __init__(self, server, **arguments):
        self._session = pull_session(url=server.address, arguments=arguments)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._session.close()

    def move(self, name, position):
        """Move a slider."""
        self._session.document.get_model_by_name(name).value = position

    def text(self, name):
        """What a part of the page says, as far as the server's messages were read."""
        part = self._session.document.get_model_by_name(name)
        return part.text if name == "note" else part.value

    def settle(self, holds="a_r ="):
        """The answer to the newest event, once it holds this text; reads the server's messages until then."""

        def settled():
            return holds in self.text("answer") and not self.text("status")

        connection = self._session._connection
        limit = connection.io_loop.call_later(PATIENCE, connection._socket.close)
        connection._loop_until(lambda: settled() or not connection.connected)
        connection.io_loop.remove_timeout(limit)
        assert settled(), self.text("answer")
        return self.text("answer")


@pytest.fixture(scope="module")
def server():
    with Server("--thickness", 0.1, "--num-points", 1024, BOKEH_RESOURCES="cdn", BOKEH_ALLOW_WS_ORIGIN="*") as program:
        yield program


def test_a_slider_changes_the_area_through_the_server(server):
    with Client(server) as client:
        expected = solve(Scene(Layer(0.1), num_points=1024)).observables.contact_area_subgrid
        assert f"a_r = {expected:.6g}" in client.settle()
        client.move("thickness", -3)
        expected = solve(Scene(Layer(1e-3), num_points=1024)).observables.contact_area_subgrid
        assert f"a_r = {expected:.6g}" in client.settle(holds="d/L = 0.001,")
        query = dict(pair.split("=") for pair in urlsplit(client.text("link")).query.split("&"))
    with Client(server, **query) as again:
        assert f"a_r = {expected:.6g}" in again.settle()


def test_a_bad_link_is_said_on_the_page(server):
    with Client(server, poisson_ratio="7") as client:
        assert "d/L = 0.1," in client.settle()
        assert "poisson_ratio is 7" in client.text("note")


def test_the_page_names_no_other_host(server):
    status, page = server.ask()
    assert status == 200
    assert b"default-src 'self'" in page
    assert not re.findall(rb"""(?:src|href)=["'](?!/static/|data:)""", page)
    assert not re.findall(rb"//(?!127\.0\.0\.1|www\.w3\.org)[a-z0-9-]+\.[a-z]{2,}", page)


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {"Host": "example.org"}),
        ("/", {"Host": "127.0.0.1.example.org"}),
        ("/", {"Host": "["}),
        ("/", {"Origin": "http://example.org"}),
        ("/", {"Origin": "null"}),
        ("/autoload.js", {}),
        ("/metadata", {}),
        ("/../pyproject.toml", {}),
    ],
)
def test_whoever_is_not_meant_is_refused(server, path, headers):
    status, text = server.ask(path, **headers)
    assert status in (400, 403)
    assert status == 400 or b"this machine" in text


def test_only_scripts_are_served_as_files(server):
    assert server.ask("/static/js/bokeh.min.js")[0] == 200
    for path in ("../../server/server.py", "%2e%2e/%2e%2e/__init__.py", "/etc/passwd", "%00", "%ff"):
        assert server.ask(f"/static/{path}")[0] in (403, 404)


def test_a_websocket_of_a_foreign_origin_or_without_a_token_is_refused(server):
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13"}
    upgrade |= {"Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ=="}
    known = {"Sec_WebSocket_Protocol": f"bokeh, {generate_jwt_token('a' * 44)}"}
    origin = f"http://127.0.0.1:{server.port}"
    assert server.ask("/ws", **upgrade, **known, Origin="http://example.org")[0] == 403
    assert server.ask("/ws", **upgrade, **known, Origin=origin)[0] == 101
    for said in ("", "bokeh", "bokeh, x", "bokeh, \xff", known["Sec_WebSocket_Protocol"].replace("bokeh", "x")):
        assert server.ask("/ws", **upgrade, Sec_WebSocket_Protocol=said, Origin=origin)[0] == 403


def test_other_machines_cannot_connect(server):
    own = {entry[4][0] for entry in socket.getaddrinfo(socket.gethostname(), server.port, socket.AF_INET)}
    for address in own - {"127.0.0.1"}:
        with pytest.raises(OSError):  # noqa: PT011
            socket.create_connection((address, server.port), timeout=PATIENCE)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_the_midst_of_a_request_ends_it_with_one_line(sign):
    """Of many refused requests, one is being answered when it comes."""

    def ask():
        with contextlib.suppress(OSError, http.client.HTTPException):
            while True:
                program.ask(Host="evil.example")

    with Server("--num-points", 256) as program:
        asking = [threading.Thread(target=ask) for _ in range(4)]
        for thread in asking:
            thread.start()
        time.sleep(0.2)
        assert program.end(sign) == (130, "linecontact: interrupted\n")
        for thread in asking:
            thread.join(PATIENCE)


def bad(*options, program=CLI, **environment):
    """The one line on standard error of a command that cannot be done."""
    words = [*program, *map(str, options)]
    result = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, env={**os.environ, **environment})
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("linecontact: ")
    return result.stderr


def test_what_cannot_be_served_is_one_line_and_status_2(server, tmp_path):
    assert f"port is {server.port}, which another program has" in bad("--port", server.port, "--num-points", 256)
    said = bad("--port", 0, "--browser", "--num-points", 256, PATH=str(tmp_path), BROWSER=str(tmp_path / "none"))
    assert "--browser is given, but none could be opened; allowed: without it, and http://127.0.0.1:" in said
    program = "import sys; sys.modules['bokeh'] = None; from linecontact.studies.__main__ import main; sys.exit(main())"
    assert "pip install -e '.[explore]'" in bad("explore", program=[sys.executable, "-c", program])


def test_bad_input_is_one_line_and_status_2(tmp_path, capsys):
    scan = write_scan(tmp_path)
    for said, *words in (
        ("port is 65536; allowed: an integer from 0 to 65535", "--port", 65536),
        ("num_points is 1024", "--profile", "rough", "--num-points", 1024),
        ("contact_modulus (or youngs_modulus) and pressure are missing", "--profile", "file", "--profile-file", scan),
        ("accuracy is 0.01", "--accuracy", 0.01),
    ):
        assert main.main(["explore", *map(str, words)]) == 2
        line = capsys.readouterr().err
        assert said in line
        assert line.count("\n") == 1


def test_a_scan_that_went_away_is_told_and_nothing_is_lost(tmp_path):
    file = write_scan(tmp_path)
    words = ["--profile", "file", "--profile-file", file, "--contact-modulus", 1e9, "--pressure", 5e4]
    with Server(*words, "--thickness", "1um", "--num-points", 1024) as program:
        with Client(program) as client:
            assert "[um]" in client.settle()
            assert not client.text("note")
            file.unlink()
            for position in (-1, -0.5):
                client.move("thickness", position)
                client.settle(holds=f"d [um] = {10**position:.3g}")
            assert "no longer there" in client.text("note")
        status, said = program.end()
        assert status == 130
        assert said == f"linecontact: scan {file} is no longer there since it was read\nlinecontact: interrupted\n"


needs_browser = pytest.mark.skipif(browser.PROGRAM is None, reason="no Chromium")
_ANSWER = "Bokeh.documents[0].get_model_by_name('answer').value"


@contextlib.contextmanager
def opened(server):
    """The page in a browser, once it shows an answer; in the end the browser has nothing to complain of."""
    with browser.Browser() as page:
        page.open(server.address)
        page.wait("typeof Bokeh !== 'undefined' && Bokeh.documents.length > 0")
        page.wait(f"{_ANSWER}.includes('a_r =')")
        yield page
        assert not page.troubles


_BOXES = """(() => {
    const find = (root) => [...root.querySelectorAll('*')].flatMap(
        (node) => [node, ...(node.shadowRoot ? find(node.shadowRoot) : [])])
    return find(document).filter((node) => node.matches('input[type=text], textarea'))
})()"""


@needs_browser
def test_the_page_in_a_browser(server):
    with opened(server) as page:
        before = page.value(_ANSWER)
        page.wait(f"{_BOXES}.length === 5 && {_BOXES}.every((box) => box.readOnly)")
        page.value("Bokeh.documents[0].get_model_by_name('thickness').value = -3")
        after = page.wait(f"{_ANSWER}.includes('d/L = 0.001,') && {_ANSWER}")
        areas = [float(re.search(r"a_r = ([\d.e-]+)", text)[1]) for text in (before, after)]
        assert areas[0] > 2 * areas[1]
        page.press_key_on_slider("thickness", "ArrowRight")
        page.wait(f"!{_ANSWER}.includes('d/L = 0.001,') && {_ANSWER}.includes('a_r =')")
        asked = [urlsplit(address) for address in page.requests if not address.startswith(("data:", "blob:"))]
        assert {one.netloc for one in asked} == {f"127.0.0.1:{server.port}"}
        assert any(one.scheme == "ws" for one in asked)


_TICKS = """((low, high) => {
    const walk = (view) => [view, ...(view.child_views ?? []).flatMap(walk)]
    const figures = Object.values(Bokeh.index).flatMap(walk).filter((view) => view.model.type === 'Figure')
    const axis = figures[3].model.left[0]
    return axis.formatter.doFormat(axis.ticker.get_ticks(low, high, null, 0).major, {})
})"""


@needs_browser
def test_a_logarithmic_axis_has_ticks_everywhere(server):
    with opened(server) as page:
        for low, high, ticks in (
            (3e-4, 0.03, "5e-4 0.001 0.002 0.005 0.01 0.02"),
            (3e-5, 0.3, "1e-4 0.001 0.01 0.1"),
            (1e-9, 10, "1e-8 1e-6 1e-4 0.01 1"),
            (0.113, 0.121, "0.114 0.116 0.118 0.12"),
        ):
            found = page.value(f"{_TICKS}({low}, {high})")
            assert " ".join(map(str.strip, found)) == ticks
            assert {len(text) for text in found} == {8}  # of one width: others would have the page laid out anew


_HOOK = """(() => {
    const walk = (view) => [view, ...(view.child_views ?? []).flatMap(walk)]
    const figures = Object.values(Bokeh.index).flatMap(walk).filter((view) => view.model.type === 'Figure')
    window.painted = []
    for (const [place, figure] of figures.entries()) {
        const paint = figure._actual_paint.bind(figure)
        figure._actual_paint = () => { paint(); setTimeout(() => { window.painted[place] = performance.now() }) }
    }
    return figures.length
})()"""
_MOVE = """new Promise((resolve) => {
    const page = Bokeh.documents[0], said = page.get_model_by_name('answer').properties.value.change
    const begin = performance.now()
    const seen = () => {
        said.disconnect(seen)
        const arrived = performance.now() - begin
        const last = (figures) => Math.max(...figures) - begin
        setTimeout(() => resolve([arrived, last(window.painted.slice(0, 2)), last(window.painted.slice(2))]), 280)
    }
    said.connect(seen)
    page.get_model_by_name('pressure').value = %f
})"""


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("profile", ["power", "rough"])
def test_time_from_a_slider_to_the_screen(profile):
    with Server("--num-points", 2**14, "--profile", profile) as program, opened(program) as page:
        page.wait("Bokeh.documents[0].get_model_by_name('status').value === ''")
        assert page.value(_HOOK) == 4
        page.value("new Promise((resolve) => setTimeout(resolve, 4000))")  # both curves
        times = []
        for place in range(43):
            times.append(page.value(_MOVE % (-3 + 1.5 * (place * 0.618 % 1))))
            page.value("new Promise((resolve) => setTimeout(resolve, 700))")  # the curves about the scene
        times = times[3:]
        stages = "answer in the page", "answer painted", "point on the curves painted"
        for what, of in zip(stages, zip(*times, strict=True), strict=True):
            print(f"{profile}, {what}: median {sorted(of)[20]:.0f} ms, nine of ten within {sorted(of)[36]:.0f} ms")
            assert all(0 < time < 1e5 for time in of)
        assert all(arrived < painted < after for arrived, painted, after in times)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="sees Linux' memory only")
def test_memory_of_the_program_stays_flat_over_ten_thousand_events():
    with Server("--num-points", 1024) as program, Client(program) as client:

        def move(count):
            for place in range(count):
                load = -5 + 4 * (place * 0.618 % 1)
                client.move("pressure", load)
                if place % 10 == 9:
                    client.settle(holds=f"p/E* = {10**load:.3g},")

        move(500)
        before = resident(program.process.pid)
        move(10_000)
        grown = resident(program.process.pid) - before
        print(f"{before / 2**20:.1f} MiB before, {grown / 2**20:.1f} MiB more after 10 000 events")
        assert grown < 30 * 2**20
