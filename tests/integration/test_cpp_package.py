"""The C++ client library as an installed CMake package, used by a project outside the tree."""

import os
import re
import shutil
import subprocess
import unittest

from installation import Installed, run
from support import REPOSITORY, SECONDS

from espalier import Server


class CppPackage(Installed):
    def test_a_project_outside_the_tree_finds_builds_and_grows(self) -> None:
        project = self.folder / "project"
        shutil.copytree(REPOSITORY / "clients" / "cpp" / "example", project)
        out = self.build_project(project)
        with Server(str(self.prefix / "bin" / "espalier"), arguments=["--log-level", "off"]) as server:
            grown = run(str(out / "grow"), server.address)
            many = run(str(out / "grow_many"), server.address)
            # an installed program finds its gallery
            with server.connect() as client:
                self.assertIn("light-tree", client.gallery())
            wrong = subprocess.run([str(out / "grow_many"), "127.0.0.1:1"], capture_output=True, text=True,
                                   timeout=SECONDS, check=False)
        lines = [line.split("\t") for line in grown.splitlines()]
        self.assertEqual([line[0] for line in lines], ["1", "2", "3", "4", "5"])
        # an apex at the heights 0, 1 and 2 grows, an apex at 3 does not
        self.assertEqual([line[1] for line in lines],
                         ["FA?E(0)", "FFA?E(0)", "FFFA?E(0)", "FFFA?E(3)", "FFFA?E(3)"])
        # the coroutines: four plants over one connection, in the order in which they finish
        self.assertEqual(sorted(many.splitlines()),
                         [f"{height}\t{'F' * height}A?E({height})" for height in range(1, 5)])
        # and its conformance suite
        suite = run(str(self.prefix / "bin" / "espalier"), "conformance", "001", "178")
        self.assertIn("2 passed, 0 failed", suite)
        self.assertTrue((self.prefix / "share" / "espalier" / "conformance" / "README.md").is_file())
        self.assertEqual((wrong.returncode, "Cannot connect to 127.0.0.1:1" in wrong.stderr), (1, True))

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "compiles: ./dev test --all long")
    def test_long_the_programs_of_the_page_are_built_and_do_what_it_says(self) -> None:
        page = (REPOSITORY / "clients" / "cpp" / "README.md").read_text(encoding="utf-8")
        client, environment = (text for text in re.findall(r"```cpp\n(.*?)```", page, re.DOTALL) if "int main" in text)
        project = self.folder / "page"
        project.mkdir()
        (project / "client.cpp").write_text(client.replace("127.0.0.1:4321", '" ESPALIER_ADDRESS "'), encoding="utf-8")
        (project / "ceiling.cpp").write_text(environment, encoding="utf-8")
        with Server(str(self.prefix / "bin" / "espalier"), arguments=["--log-level", "off"]) as server:
            (project / "CMakeLists.txt").write_text(
                "cmake_minimum_required(VERSION 3.20)\nproject(page CXX)\nset(CMAKE_CXX_STANDARD 20)\nfind_package(espalier 0.1 REQUIRED)\n"
                "foreach(name client ceiling)\n  add_executable(${name} ${name}.cpp)\n"
                "  target_link_libraries(${name} PRIVATE espalier::client)\nendforeach()\n"
                f'target_compile_definitions(client PRIVATE ESPALIER_ADDRESS="{server.address}")\n', encoding="utf-8")
            out = self.build_project(project)
            self.assertIn('"simulation"', run(str(out / "client")))
        checked = run(str(self.prefix / "bin" / "espalier"), "environment", "check", f"stdio:{out / 'ceiling'}")
        self.assertTrue(checked.endswith("all is right\n"), checked)


if __name__ == "__main__":
    unittest.main()
