"""The TypeScript client: its types fit, and its tests pass in Node.js against a real server."""

import os
import re
import shutil
import subprocess
import tarfile
import tempfile
import unittest
from pathlib import Path

from support import EXAMPLES, REPOSITORY, SECONDS, program, python, stdio, strings

WEB = REPOSITORY / "clients" / "web"
CLIENT = REPOSITORY / "clients" / "typescript"
# the build of the program fetches the packages
COMPILER = WEB / "node_modules" / "typescript" / "bin" / "tsc"


def node(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["node", *arguments], cwd=folder, text=True, capture_output=True, check=False, stdin=subprocess.DEVNULL,
                          timeout=10 * SECONDS, env={**os.environ, "ESPALIER_PROGRAM": program()})


@unittest.skipUnless(shutil.which("node") and COMPILER.is_file(), "Node.js or the packages of clients/web are not there (./dev build fetches them)")
class TypeScript(unittest.TestCase):
    def test_the_client_compiles_and_passes_its_tests(self) -> None:
        self.assertEqual(node("generate.js", folder=CLIENT).returncode, 0)
        built = node(str(COMPILER), "--typeRoots", str(WEB / "node_modules" / "@types"), folder=CLIENT)
        self.assertEqual((built.returncode, built.stdout), (0, ""), built.stdout)
        self.compiled_page()
        tested = node("--test", "test/", folder=CLIENT)
        self.assertEqual(tested.returncode, 0, tested.stdout[-6000:])
        found = re.search(r"^# pass (\d+)", tested.stdout, re.MULTILINE)
        self.assertGreaterEqual(int(found.group(1)) if found else 0, 5)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "npm is slow: ./dev test --all long")
    def test_long_the_packed_package_works_in_another_project(self) -> None:
        self.assertEqual(node("generate.js", folder=CLIENT).returncode, 0)
        built = node(str(COMPILER), "--typeRoots", str(WEB / "node_modules" / "@types"), folder=CLIENT)
        self.assertEqual((built.returncode, built.stdout), (0, ""), built.stdout)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            npm = ("npm", "--offline", "--no-audit", "--no-fund", "--ignore-scripts", "--cache", str(folder / "cache"))
            packed = subprocess.run([*npm, "pack", "--pack-destination", str(folder), str(CLIENT)], cwd=folder, text=True,
                                    capture_output=True, check=False, timeout=10 * SECONDS)
            self.assertEqual(packed.returncode, 0, packed.stderr)
            archive, = folder.glob("espalier-*.tgz")
            with tarfile.open(archive) as files:
                names = files.getnames()
            self.assertIn("package/dist/node.js", names)
            self.assertIn("package/dist/browser.d.ts", names)
            self.assertEqual([file for file in names if "/test/" in file or "node_modules" in file], [])
            (folder / "package.json").write_text('{"type": "module", "private": true}', encoding="utf-8")
            installed = subprocess.run([*npm, "install", archive.name], cwd=folder, text=True, capture_output=True, check=False,
                                       timeout=10 * SECONDS)
            self.assertEqual(installed.returncode, 0, installed.stderr)
            (folder / "use.js").write_text("import * as espalier from 'espalier';\nconsole.log(Object.keys(espalier).join(' '));\n",
                                           encoding="utf-8")
            used = node("use.js", folder=folder)
            self.assertEqual(used.returncode, 0, used.stderr)
            self.assertLessEqual({"connect", "serveStdio", "ServerError"}, set(used.stdout.split()))

    def compiled_page(self) -> None:
        """The program of docs/howto/own-environment-typescript.md."""
        page = (REPOSITORY / "docs" / "howto" / "own-environment-typescript.md").read_text(encoding="utf-8")
        source, = re.findall(r"```\n(import .*?)```", page, re.DOTALL)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "node_modules").mkdir()
            (folder / "node_modules" / "espalier").symlink_to(CLIENT)
            # as `npm init -y` writes it: a reader's folder need not be one of modules
            (folder / "package.json").write_text('{"type": "commonjs"}', encoding="utf-8")
            (folder / "ceiling.mts").write_text(source, encoding="utf-8")
            # and that of the README, whose types are checked
            source, = re.findall(r"```ts\n(import .*?)```", (CLIENT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
            (folder / "readme.mts").write_text(source, encoding="utf-8")
            built = node(str(COMPILER), "--module", "nodenext", "--target", "es2022", "--strict", "--typeRoots",
                         str(WEB / "node_modules" / "@types"), "--types", "node", "ceiling.mts", "readme.mts", folder=folder)
            self.assertEqual((built.returncode, built.stdout), (0, ""), built.stdout)
            environment = stdio(["node", str(folder / "ceiling.mjs")])
            grown, same = (strings("light-tree", "--seed", "7", "--environment", given) for given in
                           (environment, stdio(python(EXAMPLES / "ceiling.py"))))
            self.assertEqual(grown, same)


if __name__ == "__main__":
    unittest.main()
