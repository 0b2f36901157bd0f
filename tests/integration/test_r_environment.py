"""The R page: its script as it is, against the real server; the R package as people get it."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
import warnings
from pathlib import Path

from support import EXAMPLES, GALLERY, REPOSITORY, SECONDS, program, python, stdio, strings

from espalier import Server


@unittest.skipUnless(shutil.which("Rscript"), "R is not installed (Debian: r-base-core)")
class REnvironment(unittest.TestCase):
    def test_a_tree_grows_by_the_light_that_r_answers(self) -> None:
        server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"])
        self.addCleanup(server.stop)
        host, port = server.address.split(":")
        script = subprocess.Popen(["Rscript", str(REPOSITORY / "clients" / "r" / "inst" / "light.R"), host, port],
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert script.stderr is not None
        self.assertEqual(script.stderr.readline().strip(), "r-light is offered")
        with server.connect(timeout=60) as client:
            simulation = client.create(gallery="light-tree", environment=[{"type": "offered", "name": "r-light"}], seed=7)
            grown = [made.statistics for made in simulation.steps()]
            self.assertTrue(all(made["answers"] == made["queries"] for made in grown))
            # in full light every bud makes three: 3^7 = 2187 in the last step
            self.assertEqual([made["queries"] for made in grown[:5]], [1, 3, 9, 27, 81])
            self.assertLess(grown[-1]["queries"], 3 ** 7)
            bare = client.create("Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> FF\nendlsystem\n",
                                 environment=[{"type": "offered", "name": "r-light"}])
            self.assertTrue(bare.step(2).finished)
        server.stop()
        self.assertEqual(script.communicate(timeout=SECONDS)[0], "")
        self.assertEqual(script.returncode, 0)

    def test_the_program_of_the_page_is_a_ceiling(self) -> None:
        page = (REPOSITORY / "docs" / "howto" / "own-environment-r.md").read_text(encoding="utf-8")
        text, = re.findall(r"```r\nlibrary\(espalier\)\n(.*?)```", page, re.DOTALL)
        server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"])
        self.addCleanup(server.stop)
        source = f'source("{REPOSITORY}/clients/r/R/espalier.R")\n' + text.replace("127.0.0.1:4321", server.address)
        script = subprocess.Popen(["Rscript", "-e", source], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert script.stderr is not None
        self.assertEqual(script.stderr.readline().strip(), "ceiling is offered")
        with server.connect(timeout=60) as client:
            tree = client.create(gallery="light-tree", environment=[{"type": "offered", "name": "ceiling"}], seed=7)
            tree.run()
            same = strings("light-tree", "--seed", "7", "--environment", stdio(python(EXAMPLES / "ceiling.py")))
            self.assertEqual(tree.string(), same[-1])
        server.stop()
        script.communicate(timeout=SECONDS)

    def test_a_warning_of_the_function_is_a_note(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        function = 'function(queries) { warning("the \\"well\\"\\nis dry"); queries$y }'
        source = f'source("{REPOSITORY}/clients/r/R/espalier.R")\nattach_environment("well", "{server.address}", {function})'
        script = subprocess.Popen(["Rscript", "-e", source], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert script.stderr is not None
        self.assertEqual(script.stderr.readline().strip(), "well is offered")
        with server.connect(timeout=60) as client, warnings.catch_warnings(record=True) as seen:
            warnings.simplefilter("always")
            plant = client.create("Lsystem: 1\nderivation length: 2\nAxiom: F(2)?E(1)\nF(x) --> F(x)\nendlsystem\n",
                                  environment=[{"type": "offered", "name": "well"}])
            plant.run()
            self.assertIn("E(2)", plant.string())
        self.assertEqual([str(one.message) for one in seen], ["the 'well' is dry"])
        server.stop()
        self.assertEqual(script.communicate(timeout=SECONDS), ("", ""))

    def test_without_a_server_it_says_what_to_start(self) -> None:
        source = f'source("{REPOSITORY}/clients/r/R/espalier.R")\nattach_environment("ceiling", "127.0.0.1:1", function(queries) queries$x)'
        done = subprocess.run(["Rscript", "-e", source], capture_output=True, text=True, timeout=SECONDS, check=False)
        self.assertEqual((done.returncode, done.stderr), (1, "Error: nothing answers at 127.0.0.1:1: start the server "
                                                             "(espalier serve --listen 127.0.0.1:1), or correct the address\nExecution halted\n"))

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes half a minute: ./dev test --all long")
    def test_long_the_package_is_checked_installed_and_used(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "library").mkdir()
            # R asks which packages there are; this one needs none, so an empty list does
            (folder / "src" / "contrib").mkdir(parents=True)
            (folder / "src" / "contrib" / "PACKAGES").write_text("", encoding="utf-8")
            (folder / "profile").write_text(f'options(repos = c(CRAN = "file://{folder}"))\n', encoding="utf-8")
            more = {"R_LIBS": str(folder / "library"), "R_PROFILE_USER": str(folder / "profile"), "ESPALIER_PROGRAM": program()}

            def run(*command: str) -> str:
                done = subprocess.run(command, cwd=folder, text=True, capture_output=True, check=False, stdin=subprocess.DEVNULL,
                                      timeout=10 * SECONDS, env={**os.environ, **more})
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                return done.stdout

            run("R", "CMD", "build", str(REPOSITORY / "clients" / "r"))
            package, = folder.glob("espalier_*.tar.gz")
            self.assertIn("Status: OK", run("R", "CMD", "check", "--no-manual", package.name))
            run("R", "CMD", "INSTALL", package.name)
            said = run("Rscript", "-e", 'library(espalier); set <- data.frame(seed = 1:2); '
                       'print(espalier_run("classic-weed", set, \'{"modules": {"count": "F"}}\')$modules)')
            self.assertRegex(said, r"\[1\] [1-9][0-9]* [1-9][0-9]*")


if __name__ == "__main__":
    unittest.main()
