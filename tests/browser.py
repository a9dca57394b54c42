"""A headless Chromium for tests, driven through its DevTools protocol, with every other host out of reach."""

import asyncio
import json
import re
import shutil
import subprocess
import tempfile
import time

from tornado.websocket import websocket_connect

PROGRAM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE = 60  # seconds for what takes one on an idle machine


class Browser:
    """One page. `requests` are the addresses that it asked for, `troubles` what its console complained of."""

    def __init__(self, width=1400, height=1100):
        self._loop = asyncio.new_event_loop()
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--remote-debugging-port=0"]
        options += ["--disable-background-networking", "--disable-component-update", f"--window-size={width},{height}"]
        options += ["--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--force-device-scale-factor=1"]
        self._process = subprocess.Popen(
            [PROGRAM, *options, f"--user-data-dir={self._profile.name}", "about:blank"],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
        )
        self._number, self.requests, self.troubles = 0, [], []
        self._session = None
        address = next(filter(None, (re.search(r"listening on (ws://\S+)", line) for line in self._process.stderr)))[1]
        self._socket = self._run(websocket_connect, address, max_message_size=2**26)
        (target,) = [t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        self._session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()
        self._process.terminate()
        self._process.communicate(timeout=PATIENCE)
        self._loop.run_until_complete(asyncio.sleep(0))
        self._loop.close()
        self._profile.cleanup()

    def call(self, method, **parameters):
        """Result of one call of the protocol; events that come before it are noted."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        to = {"sessionId": self._session} if self._session else {}
        self._run(self._socket.write_message, json.dumps(message | to))
        while True:
            found = json.loads(self._run(self._socket.read_message))
            if found.get("id") == self._number:
                assert "error" not in found, found
                return found["result"]
            self._note(found)

    def value(self, expression):
        """Value of an expression of JavaScript."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def open(self, address):
        self.call("Page.navigate", url=address)

    def wait(self, expression):
        """The expression's value, once that counts as true."""
        deadline = time.monotonic() + PATIENCE
        while not (found := self.value(expression)):
            assert time.monotonic() < deadline, expression
            time.sleep(0.02)
        return found

    def press_key_on_slider(self, name, key):
        """Press a key on the handle of a slider, as a user does who reached it by Tab."""
        self.wait(f"""(() => {{
            const find = (root) => [...root.querySelectorAll('*')].flatMap(
                (node) => [node, ...(node.shadowRoot ? find(node.shadowRoot) : [])])
            const title = Bokeh.documents[0].get_model_by_name('{name}').title
            const own = find(document).filter((node) => node.classList?.contains('bk-slider-title')
                && node.textContent.startsWith(title))
            const handle = own[0]?.getRootNode().querySelector('.noUi-handle')
            handle?.focus()
            return Boolean(handle)
        }})()""")
        for event in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=event, key=key, code=key)

    def _run(self, function, *arguments, **options):
        async def limited():
            return await asyncio.wait_for(function(*arguments, **options), PATIENCE)

        return self._loop.run_until_complete(limited())

    def _note(self, event):
        method, told = event.get("method"), event.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        if method == "Network.webSocketCreated":
            self.requests.append(told["url"])
        bad = told.get("type") in ("error", "warning") or told.get("entry", {}).get("level") in ("error", "warning")
        if method == "Runtime.exceptionThrown" or (method in ("Runtime.consoleAPICalled", "Log.entryAdded") and bad):
            self.troubles.append(told)
