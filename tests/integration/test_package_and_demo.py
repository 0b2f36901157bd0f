"""The Python package installs without a network, its examples run, and so does the demonstration."""

import base64
import gzip
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
import venv
from pathlib import Path

from support import EXAMPLES, GALLERY, PACKAGE, SECONDS, espalier, program, python, stdio, variables

from espalier import Server

# pip may look for nothing outside this machine
OFFLINE = {"PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1"}


class Installing(unittest.TestCase):
    folder: "tempfile.TemporaryDirectory[str]"
    python: str

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        venv.create(cls.folder.name, with_pip=True)
        cls.python = str(Path(cls.folder.name) / "bin" / "python")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def run_in_venv(self, *arguments: str) -> str:
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        done = subprocess.run([self.python, *arguments], capture_output=True, text=True, timeout=SECONDS, check=False,
                              cwd=self.folder.name, env={**environment, **OFFLINE})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout.strip()

    def test_installs_as_a_wheel_and_as_a_link_without_a_network(self) -> None:
        where = "import espalier; print(espalier.__file__, espalier.__version__)"
        for option, expected in (((), self.folder.name), (("--editable",), str(PACKAGE))):
            with self.subTest(option):
                self.run_in_venv("-m", "pip", "install", "--quiet", *option, str(PACKAGE))
                self.assertTrue(self.run_in_venv("-c", where).startswith(os.path.realpath(expected)))
                self.assertIn("Version: 0.1.0", self.run_in_venv("-m", "pip", "show", "espalier"))
                self.run_in_venv("-m", "pip", "uninstall", "--quiet", "--yes", "espalier")

    def test_the_installed_package_runs_an_environment(self) -> None:
        self.run_in_venv("-m", "pip", "install", "--quiet", str(PACKAGE))
        described = self.run_in_venv(str(EXAMPLES / "canopy_light.py"), "--describe")
        self.assertIn('"name": "canopy"', described)

    def test_the_installed_package_carries_the_viewer_that_the_build_made(self) -> None:
        self.run_in_venv("-m", "pip", "uninstall", "--quiet", "--yes", "espalier")
        self.run_in_venv("-m", "pip", "install", "--quiet", str(PACKAGE))
        page = self.run_in_venv("-c", "import espalier; print(espalier.View([b'glTF']).html())")
        # the page carries its script packed
        packed = re.findall(r'atob\("(H4sI[A-Za-z0-9+/=]+)"\)', page)
        self.assertEqual(len(packed), 1)
        self.assertIn(b"Three.js Authors", gzip.decompress(base64.b64decode(packed[0])))

    def test_the_package_installs_without_the_viewer_where_there_is_no_node(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "clients" / "python"
            shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", ".mypy_cache"))
            done = subprocess.run([self.python, "-c", "import espalier_build; print(espalier_build.build_wheel('.'))"],
                                  capture_output=True, text=True, timeout=SECONDS, check=True, cwd=folder,
                                  env={"PYTHONPATH": str(copy / "build_backend"), "PATH": ""})
            self.assertIn("Install Node.js 18 or newer", done.stderr)
            self.run_in_venv("-m", "pip", "install", "--quiet", "--force-reinstall", str(Path(folder) / done.stdout.strip()))
            said = self.run_in_venv("-c", "import espalier\n"
                                    "try:\n  espalier.View([b'glTF']).html()\n"
                                    "except espalier.EspalierError as error:\n  print(error)")
        self.assertIn("The viewer's script espalier.js is missing", said)


class Examples(unittest.TestCase):
    def test_watch_growth_prints_every_step(self) -> None:
        with Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"]) as server:
            done = subprocess.run(python(EXAMPLES / "watch_growth.py", server.address, "growth-to-a-height", "height"),
                                  capture_output=True, text=True, timeout=SECONDS, check=False, env=variables())
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        self.assertEqual(len(lines), 5)
        self.assertTrue(lines[3].startswith("step 3: ") and lines[3].endswith(", height 2"))
        self.assertEqual(lines[4], "F(0,0)F(0,1)F(0,2)?E(2)")

    def test_the_environment_of_the_front_page_is_ten_lines_and_grows_a_tree_as_printed(self) -> None:
        page = (PACKAGE.parents[1] / "README.md").read_text(encoding="utf-8")
        section = page.split("## An environment in ten lines")[1]
        lines = section.split("```python\n")[1].split("```")[0]
        self.assertEqual(len(lines.splitlines()), 10)
        command = next(line for line in section.splitlines() if line.startswith("espalier run "))
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "ceiling.py"
            script.write_text(lines, encoding="utf-8")
            arguments = (shlex.split(command.replace("ceiling.py", str(script)).replace("python3", sys.executable)
                                     .replace("tree.png", f"{folder}/tree.png")))
            done = espalier(*arguments[1:])
            self.assertEqual((Path(folder) / "tree.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            # a tree, not a stump
            self.assertGreater(int(done.stderr.split(", ")[-1].split()[0]), 10_000)

    def test_shade_thins_the_light_tree(self) -> None:
        def buds(*arguments: str) -> int:
            derived = espalier("derive", str(GALLERY / "light-tree" / "light-tree.l"), "--quiet", *arguments).stdout
            return derived.count("A(")

        lit = buds("--environment", "constant")
        shaded = buds("--environment", stdio(python(EXAMPLES / "canopy_light.py")))
        self.assertLess(0, shaded)
        self.assertLess(shaded, 3**8)
        self.assertNotEqual(lit, shaded)


class Demonstration(unittest.TestCase):
    def test_grows_three_plants_and_draws_them(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, str(EXAMPLES / "demo.py"), "--program", program(), "--out", folder],
                                  capture_output=True, text=True, timeout=SECONDS, check=False, env=variables())
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            for name in ("light-tree", "branch-tiers", "shadow-trees"):
                self.assertIn("showPlant", (Path(folder) / f"{name}.html").read_text(encoding="utf-8"))
                self.assertIn("<svg", (Path(folder) / f"{name}.svg").read_text(encoding="utf-8"))
                self.assertIn("\nv ", (Path(folder) / f"{name}.obj").read_text(encoding="utf-8"))
            self.assertEqual(done.stdout.count("\nlight-tree "), 8)
            self.assertIn("Three plants grew", done.stdout)

    def test_says_what_to_do_without_a_program(self) -> None:
        done = subprocess.run([sys.executable, str(EXAMPLES / "demo.py"), "--program", "no-such-program"],
                              capture_output=True, text=True, timeout=SECONDS, check=False, env=variables())
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr.strip(), "demo: There is no program 'no-such-program'. Install Espalier (docs/install.md) or "
                                              "build it with './dev build', and give the path of its program.")


if __name__ == "__main__":
    unittest.main()
