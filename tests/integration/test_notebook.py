"""The notebook of the examples, run by Jupyter and looked at in a browser."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from browser import PROGRAM, Browser
from support import EXAMPLES, SECONDS, program, variables

HAS_JUPYTER = all(importlib.util.find_spec(name) for name in ("nbconvert", "ipykernel"))


@unittest.skipUnless(HAS_JUPYTER, "Jupyter is not installed (Debian: jupyter-nbconvert, python3-ipykernel)")
class Notebook(unittest.TestCase):
    folder: "tempfile.TemporaryDirectory[str]"
    page: Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.page = Path(cls.folder.name) / "first_plant.html"
        done = subprocess.run(
            [sys.executable, "-m", "nbconvert", "--execute", "--to", "html", "--output", str(cls.page),
             str(EXAMPLES / "first_plant.ipynb")], capture_output=True, text=True, timeout=SECONDS, check=False,
            env=variables(ESPALIER_PROGRAM=program(), HOME=cls.folder.name, JUPYTER_PLATFORM_DIRS="1"))
        if done.returncode != 0:
            raise AssertionError(done.stderr)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def test_every_cell_runs(self) -> None:
        page = self.page.read_text(encoding="utf-8")
        self.assertIn("&#39;borchert-honda&#39;", page)
        self.assertIn("srcdoc=", page)
        self.assertNotIn("Traceback", page)

    @unittest.skipUnless(PROGRAM, "Chromium is not installed (Debian: chromium)")
    def test_the_plant_is_there_in_its_cell(self) -> None:
        with Browser(f"file://{self.page}", "--proxy-server=127.0.0.1:1", "--allow-file-access-from-files") as page:
            page.wait_for("document.querySelector('iframe')?.contentDocument?.getElementById('plant')?.dataset.state === 'shown'")
            page.evaluate("document.querySelector('iframe').scrollIntoView()")
            folder = os.environ.get("ESPALIER_PICTURES")
            if folder:
                Path(folder, "notebook.png").write_bytes(page.picture())
            self.assertIn("8 of 8", page.evaluate("document.querySelector('iframe').contentDocument.body.innerText"))


if __name__ == "__main__":
    unittest.main()
