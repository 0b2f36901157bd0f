"""Espalier as a library: the page docs/library.md does what it says, outside the tree."""

import re
import unittest
from pathlib import Path

from installation import Installed, run
from support import REPOSITORY

PAGE = (REPOSITORY / "docs" / "library.md").read_text(encoding="utf-8")
PLUGIN = REPOSITORY / "environment" / "plugin_example" / "ceiling.c"
# links every library of the component `environment`
PROCESSES = """
#include <cstdio>
#include "environment/registry.h"
int main() {
  for (const std::string& name : espalier::environment::processNames()) std::puts(name.c_str());
}
"""


def code(language: str, number: int = 0) -> str:
    """A block of code of the page."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[number]


class Library(Installed):
    def project(self, name: str, cmake: str, source: str) -> Path:
        folder = self.folder / name
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(cmake, encoding="utf-8")
        (folder / f"{name}.cpp").write_text(source, encoding="utf-8")
        return folder

    def test_the_project_of_the_page_derives_a_model_in_its_own_process(self) -> None:
        out = self.build_project(self.project("grow", code("cmake"), code("cpp")))
        printed = PAGE.split("It prints the string of every step:")[1].split("```")[1].lstrip("\n")
        self.assertEqual(run(str(out / "grow")), printed)

    def test_a_project_links_the_built_in_environments(self) -> None:
        cmake = (code("cmake").replace("grow", "processes").replace("COMPONENTS engine", "COMPONENTS environment")
                 .replace("espalier::simulation", "espalier::environment"))
        out = self.build_project(self.project("processes", cmake, PROCESSES))
        self.assertIn("honda", run(str(out / "processes")).splitlines())

    def test_an_unknown_component_is_named(self) -> None:
        cmake = code("cmake").replace("COMPONENTS engine", "COMPONENTS motor")
        with self.assertRaisesRegex(AssertionError, "no component 'motor'. +Available: bmi, client, engine,"):
            self.build_project(self.project("wrong", cmake.replace("grow", "wrong"), ""))

    def test_a_plugin_built_against_the_installed_header_answers(self) -> None:
        library = self.folder / "libceiling.so"
        model = self.folder / "plant.l"
        source = re.search(r'kModel = R"\((.*?)\)"', PAGE, re.DOTALL)
        assert source is not None
        model.write_text(source.group(1), encoding="utf-8")
        # as the page says
        command = next(line for line in PAGE.splitlines() if line.startswith("cc -shared"))
        words = (command.replace("~/espalier", str(self.prefix)).replace(" ceiling.c", f" {PLUGIN}")
                 .replace("libceiling.so", str(library)).split())
        run(*words)
        espalier = str(self.prefix / "bin" / "espalier")
        run(espalier, "run", str(model), "--environment", str(library), "--quiet", "-o", str(self.folder / "plant.svg"))
        self.assertIn("<svg", (self.folder / "plant.svg").read_text(encoding="utf-8"))
        # the plug-in's ceiling is at 3
        self.assertEqual(run(espalier, "derive", str(model), "--environment", str(library), "--quiet"), "FFFA?E(0)\n")


if __name__ == "__main__":
    unittest.main()
