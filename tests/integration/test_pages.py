"""The pages in a real browser: the one of a server, where a plant grows, and those that hold a plant."""

import gzip
import os
import shutil
import subprocess
import tempfile
import unittest
import urllib.error
import urllib.request
from email.message import Message
from pathlib import Path
from typing import List, Tuple

from browser import PROGRAM, Browser
from support import GALLERY, REPOSITORY, SECONDS, program

import espalier
from espalier import Server

WEB = REPOSITORY / "clients" / "web"
PLAYWRIGHT = WEB / "node_modules" / "playwright-core"


def keep(picture: bytes, name: str) -> None:
    """Writes a picture for people when ESPALIER_PICTURES names a folder."""
    folder = os.environ.get("ESPALIER_PICTURES")
    if folder:
        Path(folder, f"{name}.png").write_bytes(picture)


def start(*arguments: str) -> "tuple[Server, str]":
    """A server with an HTTP side, and the address of its page."""
    server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off", "--http", "127.0.0.1:0", *arguments])
    assert server._process.stdout is not None
    return server, server._process.stdout.readline().decode().strip().replace("http on ", "http://")


class Pages(unittest.TestCase):
    def test_a_server_gives_its_page_and_tells_browsers_to_load_nothing_else(self) -> None:
        server, address = start()
        self.addCleanup(server.stop)
        with urllib.request.urlopen(f"{address}/", timeout=60) as answer:
            page, policy = answer.read().decode("utf-8"), answer.headers["Content-Security-Policy"]
        self.assertIn('<script src="/studio.js">', page)
        self.assertNotIn("https://", page)
        self.assertIn("default-src 'none'", policy)
        for path, kind, content in (("studio.js", "text/javascript", b"Three.js Authors"), ("studio.css", "text/css", b"#plant")):
            with urllib.request.urlopen(f"{address}/{path}", timeout=60) as answer:
                self.assertEqual(answer.headers["Content-Type"], f"{kind}; charset=utf-8")
                self.assertIn(content, answer.read())

    def test_the_script_is_sent_compressed_and_only_once(self) -> None:
        server, address = start()
        self.addCleanup(server.stop)

        def script(**headers: str) -> Tuple[int, Message, bytes]:
            names = {name.replace("_", "-"): value for name, value in headers.items()}
            try:
                with urllib.request.urlopen(urllib.request.Request(f"{address}/studio.js", headers=names), timeout=60) as answer:
                    return answer.status, answer.headers, answer.read()
            except urllib.error.HTTPError as answer:
                with answer:
                    return answer.code, answer.headers, answer.read()

        _, headers, plain = script()
        self.assertNotIn("Content-Encoding", headers)
        self.assertEqual(headers["Cache-Control"], "no-cache")
        _, headers, packed = script(Accept_Encoding="gzip, br")
        self.assertEqual(headers["Content-Encoding"], "gzip")
        self.assertEqual(gzip.decompress(packed), plain)
        self.assertLess(len(packed), len(plain) // 2)
        status, _, nothing = script(Accept_Encoding="gzip", If_None_Match=headers["ETag"])
        self.assertEqual((status, nothing), (304, b""))
        self.assertEqual(script(If_None_Match='W/"1"')[0], 200)

    @unittest.skipUnless(shutil.which("cmake"), "there is no cmake")
    def test_the_pages_are_built_without_node_and_say_what_is_missing(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for command in (["cmake", "-S", str(REPOSITORY), "-B", folder, "-G", "Ninja", "-DESPALIER_WEB=OFF", "-DESPALIER_TESTS=OFF"],
                            ["cmake", "--build", folder, "--target", "espalier_web"]):
                done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            library = next(Path(folder).rglob("libespalier_web.a")).read_bytes()
        self.assertIn((REPOSITORY / "clients" / "web" / "missing.js").read_bytes(), library)
        self.assertNotIn(b"Three.js Authors", library)


# of the tests of the studio, those that take no minutes in a browser without a graphics card
SHORT = (
    "panel|message|menu|specifications|same shape|set of them|control point|surface file|environment of a document|sliders are|a colour|differences leave|a frame that changes|a segment that goes|a gallery model grows|a slider that|"
    "a model is written|no letter|a server with a token|axe finds|full turn|archive has|film has|camera sees|has a view is shown|a held frame|first hello|no page had")


@unittest.skipUnless(PROGRAM, "Chromium is not installed (Debian: chromium)")
class InABrowser(unittest.TestCase):
    @unittest.skipUnless(PLAYWRIGHT.is_dir(), "the packages of clients/web are not there (./dev build fetches them)")
    def test_the_studio(self) -> None:
        self.run_studio(["--test-name-pattern", SHORT, "test/files.test.js", "test/plants.test.js", "test/studio.test.js"], 420)

    @unittest.skipUnless(PLAYWRIGHT.is_dir(), "the packages of clients/web are not there (./dev build fetches them)")
    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "hovers and drags take minutes: ./dev test --all long")
    def test_long_the_whole_studio(self) -> None:
        self.run_studio(sorted(str(path.relative_to(WEB)) for path in (WEB / "test").glob("*.test.js")), 3600)

    def run_studio(self, tests: List[str], seconds: int) -> None:
        variables = {**os.environ, "ESPALIER_PROGRAM": program(), "ESPALIER_CHROMIUM": str(PROGRAM)}
        # a browser without a graphics card stalls once in some runs: a mistake fails twice
        for _ in range(2):
            tested = subprocess.run(["timeout", str(seconds), "node", "--test", *tests], cwd=WEB, text=True, capture_output=True,
                                    check=False, stdin=subprocess.DEVNULL, env=variables)
            if tested.returncode == 0:
                break
        self.assertEqual(tested.returncode, 0, tested.stdout[-8000:] + tested.stderr[-2000:])
        self.assertRegex(tested.stdout, r"(?m)^# pass [1-9]")

    @unittest.skipUnless(PLAYWRIGHT.is_dir(), "the packages of clients/web are not there (./dev build fetches them)")
    def test_the_types_of_the_studio_fit(self) -> None:
        for command in (["node", "../typescript/generate.js"], ["node", "node_modules/typescript/bin/tsc"]):
            done = subprocess.run(command, cwd=WEB, text=True, capture_output=True, check=False, timeout=10 * SECONDS)
            self.assertEqual((done.returncode, done.stdout), (0, ""), done.stdout)

    def test_a_page_without_its_script_says_what_is_missing(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            page = (WEB / "page.html").read_text(encoding="utf-8")
            self.assertEqual(page.count('src="/studio.js"'), 1)
            (Path(folder) / "page.html").write_text(page.replace('src="/studio.js"', 'src="missing.js"'), encoding="utf-8")
            shutil.copy(WEB / "missing.js", folder)
            with Browser(f"file://{folder}/page.html") as shown:
                said = shown.wait_for('document.getElementById("message").textContent')
        self.assertIn("Install Node.js 18 or newer with npm", said)

    def test_a_page_of_the_package_shows_its_plant_without_any_network(self) -> None:
        with espalier.local(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"]) as client:
            tiers = client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}], seed=7)
            snapshots: List[bytes] = []
            for _ in range(4):
                tiers.step()
                snapshots.append(tiers.save())
            os.environ.setdefault("ESPALIER_PROGRAM", program())
            view = tiers.view(snapshots)
        with tempfile.TemporaryDirectory() as folder:
            view.save(Path(folder) / "plant.html")
            # a missing proxy: every request of the page would fail
            with Browser(f"file://{folder}/plant.html", "--proxy-server=127.0.0.1:1") as page:
                page.wait_for('document.getElementById("plant")?.dataset.state === "shown"')
                self.assertEqual(page.evaluate('performance.getEntriesByType("resource").length'), 0)
                shown = page.picture()
                keep(shown, "view")
                page.drag(600, 350, 750, 300)
                turned = page.picture()
                keep(turned, "view-turned")
                self.assertNotEqual(turned, shown)
                # the slider goes back to the first frame
                page.evaluate('const s = document.querySelector("input[type=range]"); s.value = 0; s.dispatchEvent(new Event("input"))')
                self.assertIn("1 of 4", page.evaluate("document.body.innerText"))
                self.assertNotEqual(page.picture(), turned)


if __name__ == "__main__":
    unittest.main()
