"""An installation: `self-test`, what --version says for reports, and the server under a service manager."""

import re
import socket
import subprocess
import sys
import tempfile
import unittest
import urllib.error
import urllib.request
from pathlib import Path
from typing import Dict, Tuple

from support import REPOSITORY, SECONDS, Process, Server, espalier, program

sys.path.insert(0, str(REPOSITORY / "tests" / "support"))

import generated_pages  # noqa: E402


def get(address: str, path: str) -> Tuple[int, Dict[str, str], bytes]:
    try:
        with urllib.request.urlopen(f"http://{address}{path}", timeout=SECONDS) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


class SelfTest(unittest.TestCase):
    def test_this_build_passes(self) -> None:
        lines = espalier("self-test").stdout.splitlines()
        self.assertEqual([line.split(":")[0] for line in lines[:-1]],
                         ["passed conformance", "passed bits", "passed light", "passed soil", "passed server", "passed page"])
        self.assertRegex(lines[-1], r"^6 passed, 0 failed in [\d.]+ s$")

    def test_an_incomplete_installation_is_seen(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            # a program without gallery and suite
            copy = Path(folder) / "espalier"
            copy.write_bytes(Path(program()).read_bytes())
            copy.chmod(0o755)
            done = subprocess.run([str(copy), "self-test"], capture_output=True, text=True, timeout=SECONDS, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed conformance: error: the suite is not beside this program", done.stdout)
        self.assertIn("failed bits: there is no gallery beside the program (share/espalier/gallery): install it whole", done.stdout)
        self.assertIn("4 passed, 2 failed", done.stdout)
        self.assertIn("espalier --version --verbose", done.stderr)

    def test_without_a_folder_for_files_it_says_so(self) -> None:
        done = espalier("self-test", status=1, TMPDIR="/proc")
        self.assertIn("set TMPDIR", done.stderr)

    def test_the_hashes_are_those_of_this_program(self) -> None:
        """A change that is not meant to change plants changes none of them."""
        text = generated_pages.HASHES.read_text(encoding="utf-8")
        self.assertEqual(len(re.findall(r"^ESPALIER_SELF_TEST_HASH", text, re.MULTILINE)), 10)
        self.assertEqual(text, generated_pages.with_hashes(text, program()), "run ./dev pages if the change of results is meant")


class Version(unittest.TestCase):
    def test_says_for_reports_what_may_matter(self) -> None:
        lines = espalier("--version", "--verbose").stdout.splitlines()
        self.assertEqual(lines[0], espalier("--version").stdout.strip())
        self.assertEqual([line.split()[0] for line in lines[1:]], ["protocol", "compiler", "C", "system", "processor", "vectors",
                                                                  "program", "gallery", "suite", "handbook"])
        self.assertIn(f"program     {Path(program()).resolve()}", lines)

    def test_the_order_of_both_words_does_not_matter(self) -> None:
        self.assertEqual(espalier("--verbose", "--version").stdout, espalier("--version", "--verbose").stdout)


class ServiceManager(unittest.TestCase):
    def messages(self, *arguments: str, watchdog: bool) -> "list[str]":
        """The messages of a server to the service manager until it has been stopped."""
        with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(f"{folder}/notify")
            manager.settimeout(SECONDS)
            more = {"NOTIFY_SOCKET": f"{folder}/notify", **({"WATCHDOG_USEC": "60000000"} if watchdog else {})}
            server = Process([program(), "serve", "--listen", "127.0.0.1:0", "--log-level", "off", *arguments], **more)
            self.addCleanup(server.stop)
            heard = [manager.recv(100).decode()]
            if watchdog:
                heard.append(manager.recv(100).decode())
            server.stop()
            while heard[-1] != "STOPPING=1":
                heard.append(manager.recv(100).decode())
        return heard

    def test_hears_that_the_server_is_ready_lives_and_ends(self) -> None:
        heard = self.messages(watchdog=True)
        self.assertEqual((heard[0], heard[1], heard[-1]), ("READY=1", "WATCHDOG=1", "STOPPING=1"))

    def test_that_wants_no_signs_of_life_hears_none(self) -> None:
        self.assertEqual(self.messages(watchdog=False), ["READY=1", "STOPPING=1"])

    def test_that_is_gone_does_no_harm(self) -> None:
        server = Process([program(), "serve", "--listen", "127.0.0.1:0", "--log-level", "off"], NOTIFY_SOCKET="/nowhere/socket")
        self.addCleanup(server.stop)
        self.assertTrue(server.address)


class Handbook(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_is_served_with_the_policy_of_each_page(self) -> None:
        site = self.folder / "site"
        (site / "docs").mkdir(parents=True)
        meta = '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; script-src \'sha256-x\'">'
        (site / "index.html").write_text(f"<html><head>{meta}</head>front</html>", encoding="utf-8")
        (site / "docs" / "page.html").write_text("<html>page</html>", encoding="utf-8")
        (site / "a.css").write_text("p {}", encoding="utf-8")
        (self.folder / "secret.txt").write_text("secret", encoding="utf-8")
        server = Server("--handbook", str(site))
        self.addCleanup(server.stop)
        status, headers, body = get(server.http, "/handbook/")
        self.assertEqual((status, body), (200, (site / "index.html").read_bytes()))
        self.assertEqual(headers["Content-Security-Policy"], "default-src 'none'; script-src 'sha256-x'; frame-ancestors 'none'")
        self.assertIn(b'url=/handbook/"', get(server.http, "/handbook")[2])
        # a page without a policy of its own has the server's
        status, headers, body = get(server.http, "/handbook/docs/page.html?q=1")
        self.assertEqual((status, body), (200, b"<html>page</html>"))
        self.assertIn("script-src 'self'", headers["Content-Security-Policy"])
        self.assertEqual(get(server.http, "/handbook/a.css")[1]["Content-Type"], "text/css; charset=utf-8")
        for path in ("/handbook/../secret.txt", "/handbook/%2e%2e/secret.txt", "/handbook/nothing.html"):
            self.assertEqual(get(server.http, path)[0], 404, path)

    def test_a_folder_that_is_none_is_an_error(self) -> None:
        done = espalier("serve", "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--handbook", str(self.folder), status=1)
        self.assertIn("there is no handbook in", done.stderr)
        self.assertIn("./dev docs", done.stderr)


if __name__ == "__main__":
    unittest.main()
