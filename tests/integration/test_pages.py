"""The pages in a real browser: the one of a server, where a plant grows, and those that hold a plant."""

import os
import shutil
import subprocess
import tempfile
import unittest
import urllib.request
from pathlib import Path
from typing import List

from browser import PROGRAM, Browser
from support import GALLERY, REPOSITORY, SECONDS, program

import espalier
from espalier import Server


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
        self.assertIn('<script src="/espalier.js" data-page="server">', page)
        self.assertNotIn("https://", page)
        self.assertIn("default-src 'none'", policy)
        with urllib.request.urlopen(f"{address}/espalier.js", timeout=60) as answer:
            self.assertEqual(answer.headers["Content-Type"], "text/javascript; charset=utf-8")
            self.assertIn(b"Three.js Authors", answer.read())

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


@unittest.skipUnless(PROGRAM, "Chromium is not installed (Debian: chromium)")
class InABrowser(unittest.TestCase):
    def test_a_plant_grows_on_the_page(self) -> None:
        server, address = start()
        self.addCleanup(server.stop)
        with Browser(address) as page:
            page.wait_for('document.body.dataset.state === "connected"')
            self.assertIn("light-tree", page.evaluate('[...document.getElementById("gallery").options].map((o) => o.value)'))
            page.evaluate('document.getElementById("gallery").value = "branch-tiers"')
            page.evaluate('document.getElementById("seed").value = "7"')
            page.evaluate('document.getElementById("create").click()')
            page.wait_for('document.getElementById("plant").dataset.step === "0"')
            page.evaluate('document.getElementById("step").click()')
            page.wait_for('document.getElementById("plant").dataset.step === "1"')
            first = page.picture()
            page.wait_for('!document.getElementById("run").disabled')
            page.evaluate('document.getElementById("run").click()')
            page.wait_for('document.getElementById("state").textContent.includes("finished")')
            with server.connect() as client:
                made = client.simulation(client.simulations()[0]["simulation"])
                last = made.get("information")["information"]["step"]
                modules = made.get("statistics")["statistics"]["modules"]
            page.wait_for(f'document.getElementById("plant").dataset.step === "{last}"')
            # the newest step is on top of the table
            newest = page.evaluate('[...document.querySelector("#steps tr").children].map((cell) => cell.textContent)')
            self.assertEqual([newest[0], newest[1].replace(",", "")], [str(last), str(modules)])
            grown = page.picture()
            keep(first, "page-first")
            keep(grown, "page-grown")
            self.assertGreater(len(grown), len(first))
            page.drag(800, 350, 950, 300)
            turned = page.picture()
            keep(turned, "page-turned")
            self.assertNotEqual(turned, grown)

    def test_a_page_without_its_script_says_what_is_missing(self) -> None:
        web = REPOSITORY / "clients" / "web"
        with tempfile.TemporaryDirectory() as folder:
            page = (web / "page.html").read_text(encoding="utf-8")
            self.assertEqual(page.count('src="/espalier.js"'), 1)
            (Path(folder) / "page.html").write_text(page.replace('src="/espalier.js"', 'src="missing.js"'), encoding="utf-8")
            shutil.copy(web / "missing.js", folder)
            with Browser(f"file://{folder}/page.html") as shown:
                said = shown.wait_for('document.getElementById("message").textContent')
        self.assertIn("Install Node.js 18 or newer with npm", said)

    def test_shows_what_another_program_steps(self) -> None:
        server, address = start()
        self.addCleanup(server.stop)
        with server.connect() as client:
            weed = client.create(gallery="classic-weed")
            with Browser(f"{address}/#simulation={weed.identifier}") as page:
                page.wait_for('document.getElementById("plant").dataset.step === "0"')
                weed.step(2)
                page.wait_for('document.getElementById("plant").dataset.step === "2"')
                weed.reset()
                weed.step()
                page.wait_for('document.getElementById("plant").dataset.step === "1"')

    def test_says_what_is_wrong_with_a_model(self) -> None:
        server, address = start()
        self.addCleanup(server.stop)
        with Browser(address) as page:
            page.wait_for('document.body.dataset.state === "connected"')
            page.evaluate('const g = document.getElementById("gallery"); g.value = ""; g.dispatchEvent(new Event("change"))')
            self.assertFalse(page.evaluate('document.getElementById("source").hidden'))
            page.evaluate('document.getElementById("source").value = "Lsystem: 1\\nAxiom: A(\\nendlsystem\\n"')
            page.evaluate('document.getElementById("create").click()')
            said = page.wait_for('document.getElementById("message").textContent')
            self.assertRegex(said, r":2:\d+: error")
            keep(page.picture(), "page-error")

    def test_asks_for_the_token_of_a_server_that_wants_one(self) -> None:
        server, address = start("--token", "secret words")
        self.addCleanup(server.stop)
        with Browser(address) as page:
            page.wait_for('!document.getElementById("token-form").hidden')
            self.assertEqual(page.evaluate('document.getElementById("message").textContent'), "This server needs a token.")
            page.evaluate('document.getElementById("token").value = "wrong"')
            page.evaluate('document.querySelector("#token-form button").click()')
            page.wait_for('document.getElementById("message").textContent.includes("token")')
            page.evaluate('document.getElementById("token").value = "secret words"')
            page.evaluate('document.querySelector("#token-form button").click()')
            page.wait_for('document.body.dataset.state === "connected"')

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
