"""Man pages, completions and wheels are made from the program: every command and option is in them."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path
from typing import ClassVar, List

from support import REPOSITORY, SECONDS, program

sys.path.insert(0, str(REPOSITORY / "clients" / "packaging"))

import build_wheels  # noqa: E402
import command_table  # noqa: E402
import make_completions  # noqa: E402
import make_manpages  # noqa: E402

from espalier import Server, viewing  # noqa: E402

DEBIAN = REPOSITORY / "clients" / "packaging" / "debian"
COMPILER = REPOSITORY / "clients" / "web" / "node_modules" / "typescript"

# the words that every shell offers behind a line
OFFERS = {"deri": ["derive"], "self-": ["self-test"], "derive --comp": ["--compat"], "derive --compat ": ["cpfg", "cpfg-batch"],
          "connect 127.0.0.1:1 st": ["status", "step", "stream"], "token new --ro": ["--role"], "derive tr": ["tree.l"]}

# A zsh at a prompt of a pseudo-terminal: it reads the completions of the folder $1 as an installed one does, gets the other arguments as
# lines with a tab behind them, and prints what it would offer for each. Every completion ends in compadd; with -O, -A or -D it only asks
ZSH = r"""
folder=$1; shift
zmodload zsh/zpty
zpty inner zsh -f -i
zpty -w inner "
PROMPT= RPROMPT=; stty -echo; unsetopt zle_bracketed_paste 2>/dev/null
fpath=($folder \$fpath); autoload -Uz compinit; compinit -u -D
compadd() { if [[ \${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then builtin compadd \"\$@\"; return; fi
  local -a found; builtin compadd -A found \"\$@\"; (( \$#found )) && print -l -- \"<offer>\"\${^found}\"</offer>\"; builtin compadd \"\$@\"; }
offers() { _main_complete; compstate[insert]=; compstate[list]= }
zle -C offers complete-word offers
next() { print -r -- '<next>'; zle kill-whole-line }
zle -N next
bindkey '^I' offers; bindkey '^X' next
print -r -- '<ready>'"
zpty -r inner text '*<ready>*' >/dev/null
for line; do
  zpty -n -w inner "$line"$'\t'$'\x18'
  all=
  while zpty -r inner text 2>/dev/null; do all+=$text; [[ $text == *'<next>'* ]] && break; done
  print -r -- "$all" | tr -d '\r' | grep -o '<offer>[^<]*</offer>' | sed 's/<[^>]*>//g' | sort -u | tr '\n' ' '
  print
done
zpty -d inner
"""


class FromHelp(unittest.TestCase):
    table: ClassVar[List[command_table.Command]]

    @classmethod
    def setUpClass(cls) -> None:
        cls.table = list(command_table.commands(program()))

    def command(self, *words: str) -> command_table.Command:
        return next(each for each in self.table if each.words == words)

    def test_the_table_has_commands_options_values_and_choices(self) -> None:
        self.assertGreater(len(self.table), 30)
        options = {option.names[-1]: option for option in self.command("run").options}
        self.assertEqual(options["--compat"].choices, ["cpfg", "cpfg-batch"])
        self.assertEqual(options["--output"].names, ["-o", "--output"])
        self.assertEqual((options["--steps"].value, options["--quiet"].value), ("N", ""))
        self.assertTrue(options["--variants"].meaning.startswith("Grow N plants"))
        self.assertEqual(self.command("derive").positionals[0][0].split()[0], "model")
        # a subcommand behind an address
        self.assertIn("--until", [option.names[0] for option in self.command("connect", "ADDRESS", "step").options])
        # every option of a help text is in the table
        for command in self.table:
            for option in command.options:
                self.assertTrue(option.names and option.meaning, (command.words, option))

    def test_each_command_has_a_man_page_without_warnings(self) -> None:
        pages = dict(make_manpages.pages(program(), "1.2", "2026-01-01"))
        self.assertEqual(len(pages), len(self.table))
        self.assertIn("\\fB\\-o, \\-\\-output\\fR \\fIFILE\\fR", pages["espalier-run.1"])
        self.assertIn("espalier-connect-create.1", pages)
        if shutil.which("groff"):
            for name, text in pages.items():
                done = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-K", "utf8", "-z"], input=text, capture_output=True, text=True,
                                      timeout=SECONDS, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""), name)

    def completed(self, *words: str) -> List[str]:
        """The words that bash offers for the last word."""
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "espalier"
            script.write_text(make_completions.bash(self.table), encoding="utf-8")
            quoted = " ".join(f"'{word}'" for word in ("espalier", *words))
            text = f"source {script}; COMP_WORDS=({quoted}); COMP_CWORD={len(words)}; _espalier; printf '%s\\n' \"${{COMPREPLY[@]}}\""
            done = subprocess.run(["bash", "-c", text], capture_output=True, text=True, timeout=SECONDS, check=True, cwd=folder)
        return done.stdout.split()

    def test_bash_completes_commands_options_values_and_files(self) -> None:
        self.assertEqual(self.completed("deri"), ["derive"])
        self.assertEqual(self.completed("derive", "--comp"), ["--compat"])
        self.assertEqual(self.completed("derive", "--compat", ""), ["cpfg", "cpfg-batch"])
        self.assertEqual(self.completed("connect", "127.0.0.1:1", "st"), ["step", "stream", "status"])
        self.assertEqual(self.completed("token", "new", "--ro"), ["--role"])
        self.assertEqual(self.completed("derive", "esp"), ["espalier"])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed (Debian: zsh)")
    def test_zsh_completes_at_its_prompt(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "_espalier").write_text(make_completions.zsh(self.table), encoding="utf-8")
            (Path(folder) / "tree.l").write_text("", encoding="utf-8")
            lines = [f"espalier {line}" for line in OFFERS]
            done = subprocess.run(["zsh", "-f", "-c", ZSH, "zsh", folder, *lines], capture_output=True, text=True, timeout=5 * SECONDS,
                                  check=True, cwd=folder, stdin=subprocess.DEVNULL)
        self.assertEqual([line.split() for line in done.stdout.splitlines()], list(OFFERS.values()), done.stdout + done.stderr)

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed (Debian: fish)")
    def test_fish_completes(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "espalier.fish").write_text(make_completions.fish(self.table), encoding="utf-8")
            (Path(folder) / "tree.l").write_text("", encoding="utf-8")
            text = "source espalier.fish\n" + "".join(f"complete -C 'espalier {line}'; echo '<next>'\n" for line in OFFERS)
            done = subprocess.run(["fish", "--no-config", "-c", text], capture_output=True, text=True, timeout=5 * SECONDS, check=True,
                                  cwd=folder, env={**os.environ, "HOME": folder}, stdin=subprocess.DEVNULL)
        # behind a tab stands what it means
        offers = [sorted(entry.split("\t")[0] for entry in part.splitlines() if entry) for part in done.stdout.split("<next>")[:-1]]
        self.assertEqual(offers, list(OFFERS.values()), done.stdout + done.stderr)


class Libraries(unittest.TestCase):
    @unittest.skipUnless(shutil.which("readelf"), "readelf is not installed (Debian: binutils)")
    def test_commands_that_need_neither_light_nor_tls_load_no_library_for_them(self) -> None:
        path = Path(program()).resolve()
        at_start = " ".join(build_wheels.linked(path))
        later = build_wheels.loaded_later(path)
        for library in ("libssl", "libcrypto", "libembree"):
            self.assertNotIn(library, at_start)
            self.assertEqual(sum(name.startswith(library) for name in later), 1, later)
        self.assertNotIn("libtbb", at_start)
        # a wheel has them nevertheless, with what they need themselves
        names = [each.name for each in build_wheels.libraries(path)]
        self.assertEqual([name for name in later if name not in names], [])
        self.assertTrue(any(name.startswith("libtbb") for name in names), names)
        self.assertEqual(len(names), len(set(names)))


class DebianScripts(unittest.TestCase):
    """The content of the packages' scripts. The stage `package` runs them in a bare system, which has no systemd."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    @unittest.skipUnless(shutil.which("dh_installdeb"), "debhelper is not installed (Debian: debhelper)")
    def test_the_service_is_stopped_when_it_goes_and_started_again_after_an_upgrade(self) -> None:
        shutil.copytree(DEBIAN, self.folder / "debian")
        self.built("make -f debian/rules override_dh_installsystemd", "dh_installdeb --package=espalier")
        scripts = {path.name: path.read_text(encoding="utf-8") for path in (self.folder / "debian" / "espalier" / "DEBIAN").iterdir()}
        self.assertIn("deb-systemd-invoke stop espalier.service", scripts["prerm"])
        self.assertRegex(scripts["prerm"], r'"\$1" = remove')
        # only where it ran: the service is not enabled
        self.assertIn("deb-systemd-invoke try-restart 'espalier.service'", scripts["postinst"])
        self.assertNotIn("deb-systemd-invoke", scripts.get("preinst", ""))
        for name in ("prerm", "postinst", "postrm"):
            self.assertEqual(subprocess.run(["sh", "-n"], input=scripts[name], text=True, check=False).returncode, 0, name)

    def built(self, *commands: str) -> None:
        """Runs targets of the recipe and programs of debhelper in the folder, which has debian/."""
        variables = {**os.environ, "DH_VERBOSE": "", "DH_NO_ACT": ""}
        for command in commands:
            done = subprocess.run(command.split(), cwd=self.folder, env=variables, capture_output=True, text=True, timeout=SECONDS, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @unittest.skipUnless(shutil.which("dh_compress"), "debhelper is not installed (Debian: debhelper)")
    def test_no_file_of_the_handbook_and_of_the_examples_is_packed(self) -> None:
        documents = self.folder / "debian" / "espalier" / "usr" / "share" / "doc" / "espalier"
        names = ["changelog", "handbook/docs/studio.webp", "handbook/protocol/espalier-1.schema.json", "handbook/clients/bmi/example/heat.hxx"]
        for name in names:
            (documents / name).parent.mkdir(parents=True, exist_ok=True)
            (documents / name).write_text("a line\n" * 4000, encoding="utf-8")
        shutil.copytree(DEBIAN, self.folder / "debian", dirs_exist_ok=True)
        self.built("make -f debian/rules override_dh_compress")
        files = [str(path.relative_to(documents)) for path in documents.rglob("*") if path.is_file()]
        self.assertEqual(sorted(files), sorted(["changelog.gz", *names[1:]]))

    @unittest.skipUnless(shutil.which("dh_installexamples"), "debhelper is not installed (Debian: debhelper)")
    def test_the_packages_have_the_examples_of_the_pages(self) -> None:
        for name in ("clients/bmi/example", "clients/cpp/example", "environment/plugin_example", "clients/python/examples"):
            shutil.copytree(REPOSITORY / name, self.folder / name)
        lines = [line for line in (DEBIAN / "espalier-dev.install").read_text(encoding="utf-8").splitlines(keepends=True) if "examples" in line]
        shutil.copytree(DEBIAN, self.folder / "debian")
        (self.folder / "debian" / "espalier-dev.install").write_text("".join(lines), encoding="utf-8")
        self.built("dh_install --package=espalier-dev", "dh_installexamples --package=python3-espalier")
        for name in ("espalier-dev/examples/bmi/driver.cpp", "espalier-dev/examples/bmi/CMakeLists.txt", "espalier-dev/examples/bmi/heat.hxx",
                     "espalier-dev/examples/cpp/grow_many.cpp", "espalier-dev/examples/plugin/ceiling.c",
                     "python3-espalier/examples/heat.py", "python3-espalier/examples/ceiling.py"):
            package = name.split("/")[0]
            self.assertTrue((self.folder / "debian" / package / "usr" / "share" / "doc" / name).is_file(), name)

    def test_a_purge_removes_data_unless_a_process_uses_them(self) -> None:
        script = self.folder / "postrm"
        script.write_text((DEBIAN / "espalier.postrm").read_text(encoding="utf-8").replace("/var/lib", str(self.folder)), encoding="utf-8")
        data = self.folder / "private" / "espalier"
        data.mkdir(parents=True)
        (self.folder / "espalier").symlink_to("private/espalier")

        def purge(what: str = "purge") -> str:
            return subprocess.run(["sh", str(script), what], capture_output=True, text=True, timeout=SECONDS, check=True).stderr

        with (data / "espalier.sqlite").open("w"):
            self.assertIn(f"a process uses {data}, so it stays", purge())
            self.assertTrue((data / "espalier.sqlite").exists())
        purge("remove")
        self.assertTrue((data / "espalier.sqlite").exists())
        self.assertEqual(purge(), "")
        self.assertEqual(list((self.folder / "private").iterdir()), [])
        self.assertFalse((self.folder / "espalier").is_symlink())

    def test_the_python_package_has_the_script_of_its_pages(self) -> None:
        lines = [line.split() for line in (DEBIAN / "python3-espalier.install").read_text(encoding="utf-8").splitlines()]
        target = next(target for source, target in lines if source == "clients/web/espalier.js")
        package = Path(next(target for source, target in lines if source == "clients/python/espalier")) / "espalier"
        place = viewing.SCRIPTS[0].relative_to(Path(viewing.__file__).parent)
        self.assertEqual(Path(target) / "espalier.js", package / place)

    def test_the_development_package_brings_what_its_cmake_package_looks_for(self) -> None:
        # the names of Debian 12; threads are the C library's
        brought = {"OpenSSL": "libssl-dev", "zstd": "libzstd-dev", "tl-expected": "libexpected-dev", "Boost": "libboost1.81-dev",
                   "nlohmann_json": "nlohmann-json3-dev", "simdjson": "libsimdjson-dev", "tinyobjloader": "libtinyobjloader-dev",
                   "TinyGLTF": "libtinygltf-dev", "PNG": "libpng-dev", "JPEG": "libjpeg-dev", "embree": "libembree-dev", "ZLIB": "zlib1g-dev"}
        looked = set(re.findall(r"find_dependency\((\S+?)[ )]", (REPOSITORY / "cmake" / "espalier-config.cmake").read_text(encoding="utf-8")))
        self.assertEqual(looked - {"Threads"}, set(brought))
        control = (DEBIAN / "control").read_text(encoding="utf-8")
        paragraph = next(part for part in control.split("\n\n") if part.startswith("Package: espalier-dev\n"))
        depends = re.search(r"Depends:(.*?)\n(?=\S)", paragraph, re.DOTALL)
        assert depends is not None
        packages = {word.strip() for word in depends.group(1).split(",")}
        self.assertEqual(set(brought.values()) - packages, set())

    def test_no_line_of_the_test_of_packages_hides_a_failure(self) -> None:
        # `set -e` does not see a command behind `!`
        text = (DEBIAN.parent / "test_package.sh").read_text(encoding="utf-8")
        self.assertEqual([line for line in text.splitlines() if line.lstrip().startswith("! ") or line.rstrip().endswith("|| true")], [])


@unittest.skipUnless(shutil.which("npm"), "npm is not installed")
@unittest.skipUnless(COMPILER.is_dir(), "the packages of clients/web are not there (./dev build fetches them)")
class Archives(unittest.TestCase):
    """The archives of build_archives.sh for npm, Blender and R, used as people get them: without the repository."""
    folder: ClassVar[Path]

    @classmethod
    def setUpClass(cls) -> None:
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.command("bash", str(REPOSITORY / "clients" / "packaging" / "build_archives.sh"), str(cls.folder))

    @classmethod
    def command(cls, *words: str, **more: str) -> str:
        done = subprocess.run(words, cwd=cls.folder, text=True, capture_output=True, check=False, stdin=subprocess.DEVNULL,
                              timeout=10 * SECONDS, env={**os.environ, **more})
        if done.returncode != 0:
            raise AssertionError(f"{words}: {done.stdout}{done.stderr}")
        return done.stdout

    def test_npm_installs_its_package_without_a_network(self) -> None:
        archive, = self.folder.glob("espalier-*.tgz")
        (self.folder / "package.json").write_text('{"type": "module"}', encoding="utf-8")
        self.command("npm", "install", "--offline", "--no-audit", "--no-fund", "--silent", str(archive))
        with Server(program(), arguments=["--log-level", "off"]) as server:
            (self.folder / "use.js").write_text(
                'import { connect } from "espalier";\nconst client = await connect(process.argv[2]);\n'
                'const plant = await client.create({ model: { source: "Lsystem: 1\\nderivation length: 2\\nAxiom: A\\nA --> AB\\nendlsystem\\n" } });\n'
                "await plant.step(2);\nconsole.log(await plant.string());\nclient.close();\n", encoding="utf-8")
            self.assertIn("ABB", self.command("node", "use.js", server.address))

    def test_the_add_on_of_blender_is_whole(self) -> None:
        with zipfile.ZipFile(self.folder / "espalier-blender.zip") as archive:
            names = archive.namelist()
            self.assertIn("bl_info", archive.read("espalier_blender/__init__.py").decode())
            self.assertIn("espalier_blender/packages/espalier/__init__.py", names)
            # Blender takes each folder at the top for an add-on, and complains of those that are none
            self.assertEqual({name.split("/")[0] for name in names}, {"espalier_blender"})
            self.assertEqual([name for name in names if "__pycache__" in name], [])
            for name in names:
                if name.endswith(".py"):
                    compile(archive.read(name), name, "exec")

    @unittest.skipUnless(shutil.which("R"), "R is not installed (Debian: r-base-core)")
    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes half a minute: ./dev test --all package")
    def test_long_r_finds_nothing_to_complain_of(self) -> None:
        archive, = self.folder.glob("espalier_*.tar.gz")
        # R asks which packages there are; this one needs none, so an empty list does
        (self.folder / "src" / "contrib").mkdir(parents=True)
        (self.folder / "src" / "contrib" / "PACKAGES").write_text("", encoding="utf-8")
        (self.folder / "profile").write_text(f'options(repos = c(CRAN = "file://{self.folder}"))\n', encoding="utf-8")
        checked = self.command("R", "CMD", "check", "--no-manual", archive.name, R_PROFILE_USER=str(self.folder / "profile"),
                               ESPALIER_PROGRAM=program())
        self.assertIn("Status: OK", checked)


class Wheels(unittest.TestCase):
    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all long")
    @unittest.skipUnless(shutil.which("patchelf") and shutil.which("objdump"), "patchelf is not installed (Debian: patchelf)")
    def test_long_one_has_the_program_inside_and_an_honest_name(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            name = build_wheels.platform_wheel(Path(program()).resolve(), Path(folder))
            self.assertRegex(name, r"^espalier-[\d.]+-py3-none-manylinux_2_\d+_\w+\.whl$")
            with zipfile.ZipFile(Path(folder) / name) as wheel:
                files = wheel.namelist()
                for wanted in ("espalier/bin/espalier", "espalier/share/espalier/gallery/classic-weed/classic-weed.l",
                               "espalier/share/espalier/conformance/cases.tsv", "espalier/__init__.py"):
                    self.assertIn(wanted, files)
                self.assertTrue(wheel.getinfo("espalier/bin/espalier").external_attr >> 16 & 0o111)
                # the C library is the system's
                self.assertEqual([file for file in files if Path(file).name.startswith(("libc.so", "libm.so", "ld-linux"))], [])
                self.assertIn("espalier = espalier.program:main",
                              wheel.read(next(file for file in files if file.endswith("entry_points.txt"))).decode())
                wheel.extractall(folder)
            copy = Path(folder) / "espalier" / "bin" / "espalier"
            copy.chmod(0o755)
            for file in (copy, *(copy.parent / "lib").iterdir()):
                done = subprocess.run(["ldd", str(file)], capture_output=True, text=True, timeout=SECONDS, check=True)
                self.assertNotIn("not found", done.stdout, file)
            # its own library, not the system's
            done = subprocess.run([str(copy), "derive", str(REPOSITORY / "clients" / "gallery" / "sun-and-shade"), "--steps", "2"],
                                  capture_output=True, text=True, timeout=SECONDS, check=True, env={"LD_DEBUG": "files"})
            self.assertIn(f"{copy.parent}/lib/libembree3.so.3", done.stderr.replace("bin/lib/../lib", "bin/lib"))


if __name__ == "__main__":
    unittest.main()
