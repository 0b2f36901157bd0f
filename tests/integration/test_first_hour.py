"""The problems of a user in the first hour: interrupted runs, mistyped commands, options and files that have no effect."""

import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from support import EXAMPLES, GALLERY, SECONDS, Process, Server, espalier, model, program, python

TREE = "Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> F[+F]F\nendlsystem\n"


def sentence(done: "subprocess.CompletedProcess[str]") -> str:
    """What a command has said, without the ends of long lines."""
    return " ".join((done.stdout + done.stderr).split())


class FirstHour(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, text: str, name: str = "model.l") -> str:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return str(path)

    # ---- a run that a signal ends

    def interrupted(self, number: int) -> None:
        model = self.file("Lsystem: 1\nderivation length: 10\nAxiom: F\nF --> F[+F][-F]F\nendlsystem\n")
        process = subprocess.Popen([program(), "run", model, "-o", str(self.folder / "big.obj"), "--quiet"],
                                   stderr=subprocess.DEVNULL,
                                   # tests that run behind a shell's & ignore the signal, and so would the run
                                   preexec_fn=lambda: signal.signal(number, signal.SIG_DFL))
        self.addCleanup(process.kill)
        deadline = time.monotonic() + SECONDS
        while not list(self.folder.glob("*.part")):
            self.assertIsNone(process.poll(), "the run has ended before its file was seen")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.002)
        process.send_signal(number)
        self.assertEqual(process.wait(SECONDS), -number)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["model.l"])

    def test_a_run_that_is_interrupted_leaves_no_part_of_a_file(self) -> None:
        self.interrupted(signal.SIGINT)
        self.interrupted(signal.SIGTERM)

    # ---- what has no effect is said

    def test_an_environment_that_nobody_asks_is_a_warning(self) -> None:
        model = self.file(TREE)
        sentence = "warning: the environment has no effect: the model has no communication module ?E(x) that asks it"
        for command in ("derive", "check"):
            self.assertIn(sentence, espalier(command, model, "--environment", "honda").stderr)
        espalier("derive", model, "--environment", "honda", "--strict", status=1)
        asking = self.file("Lsystem: 1\nderivation length: 2\nAxiom: F?E(0)\nF --> FF\nendlsystem\n", "asking.l")
        self.assertNotIn("no effect", espalier("derive", asking, "--environment", "honda").stderr)

    def test_a_start_without_a_partner_of_its_bracket_is_a_warning(self) -> None:
        model = self.file(TREE)
        for text, mark in (("F\n[+F]F]\n", ":2:6: warning: this ']' closes no '[' in the string"),
                           ("F[+F[F]\n", ":1:2: warning: this '[' is not closed in the string")):
            start = self.file(text, "start.string")
            self.assertIn(start + mark, espalier("derive", model, "--from", start, "--steps", "0").stderr)
            espalier("derive", model, "--from", start, "--strict", status=1)
        whole = espalier("derive", model, "--from", self.file("F[+F[F]]\n", "start.string"), "--steps", "0")
        self.assertEqual((whole.stdout, whole.stderr), ("F[+F[F]]\n", ""))

    def test_options_of_a_server_that_can_have_no_effect_are_refused(self) -> None:
        for arguments, sentence in (
                (("--handbook", str(self.folder)), "--handbook is for browsers, and no address for them is given"),
                (("--allow-origin", "https://a.example"), "--allow-origin is for browsers"),
                (("--allow-origin", "a.example", "--http", "127.0.0.1:0"), "'a.example' is no origin of a page"),
                (("--allow-dial", "nonsense"), "--allow-dial 'nonsense' is not an address")):
            self.assertIn(sentence, espalier("serve", "--listen", "127.0.0.1:0", *arguments, status=2).stderr)

    def test_a_token_that_has_expired_is_not_made(self) -> None:
        done = espalier("token", "new", "screen", "--expires", "2020-01-31", status=2)
        self.assertIn("--expires '2020-01-31' is past: no server would accept the token", done.stderr)
        self.assertEqual(done.stdout, "")

    # ---- mistyped commands and wrong files

    def test_a_model_without_a_command_gets_the_command(self) -> None:
        model = self.file(TREE)
        self.assertIn(f"a command stands before it: espalier run {model} -o plant.png", espalier(model, status=2).stderr)

    def test_help_is_a_command_too(self) -> None:
        self.assertIn("Grow a model and write pictures", espalier("help").stdout)
        self.assertIn("--turntable N", espalier("help", "run").stdout)
        self.assertIn("Usage: espalier run [OPTIONS]", espalier("help", "run").stdout)

    def test_format_says_what_a_file_is_that_it_cannot_lay_out(self) -> None:
        picture = str(GALLERY / "chapter-fractint" / "curves-Tree.png")
        self.assertIn("error: this is a PNG picture, not a model", espalier("format", picture, status=1).stderr)
        other = self.file('#include <lpfgall.h>\nmodule A(float);\n')
        self.assertIn("error: this is an L+C model for lpfg", espalier("format", other, status=1).stderr)

    def test_a_folder_of_other_dialects_lists_its_models(self) -> None:
        done = espalier("run", str(GALLERY / "chapter-lsystem-viewer"), "-o", str(self.folder / "a.png"), status=1)
        self.assertIn("give the name of one of its other files: branch.lsv, circle.lsv,", done.stderr)

    def test_help_of_an_unknown_command_names_the_nearest(self) -> None:
        self.assertIn("there is no command 'derve'. Did you mean 'derive'?", espalier("help", "derve", status=2).stderr)

    def test_a_mistyped_part_of_a_command_gets_the_nearest(self) -> None:
        done = espalier("connect", "127.0.0.1:1", "crate", "model.l", status=2)
        self.assertIn("there is no command 'connect … crate'. Did you mean 'create'?", done.stderr)
        # the value of an option is no command
        for options in (("--token-file", self.file("secret\n", "token")), ("--token=x",), ("--trust", "stop.pem")):
            for arguments in (("127.0.0.1:1", *options), (*options, "127.0.0.1:1")):
                self.assertIn("there is no command 'connect … stp'. Did you mean 'step'?",
                              espalier("connect", *arguments, "stp", status=2).stderr)
        self.assertIn("give a command behind 'token'. Available: new", espalier("token", status=2).stderr)
        self.assertIn("Did you mean --listen HOST:PORT?", espalier("serve", "--port", "0", status=2).stderr)
        self.assertIn("ADDRESS is required", espalier("connect", status=2).stderr)

    # ---- servers and environments

    def test_a_server_is_no_environment_and_an_environment_is_no_server(self) -> None:
        asking = self.file("Lsystem: 1\nAxiom: F?E(0)\nF --> FF\nendlsystem\n")
        for arguments in ((), ("--token", "secret")):
            server = Server(*arguments)
            self.addCleanup(server.stop)
            for command in (("derive", asking, "--environment"), ("environment", "check")):
                done = espalier(*command, f"tcp://{server.address}", status=1)
                self.assertIn(f"environment tcp://{server.address} is a server of simulations, not an environment (while "
                              "connecting). Give the address that the environment prints when it listens.", sentence(done))
        for listening in (python(EXAMPLES / "ceiling.py", "--listen", "127.0.0.1:0"),
                          [program(), "environment", "height", "--listen", "127.0.0.1:0"]):
            environment = Process(listening)
            self.addCleanup(environment.stop)
            for command in ((), ("list",), ("create", asking)):
                done = espalier("connect" if command else "status", environment.address, *command, status=1)
                self.assertIn(f"at {environment.address} is an environment, not a server. `espalier serve` starts a server; "
                              f"--environment tcp://{environment.address} lets a model ask this environment.", sentence(done))

    def test_a_model_of_the_gallery_is_created_with_the_option_that_the_message_names(self) -> None:
        server = Server()
        self.addCleanup(server.stop)
        done = espalier("connect", server.address, "create", "branch-tiers", status=1)
        self.assertIn("there is no file 'branch-tiers'. A model of the gallery has this name. --gallery NAME takes a "
                      "model of the server's gallery", sentence(done))
        espalier("connect", server.address, "create", "--gallery", "branch-tiers")
        self.assertNotIn("--gallery", espalier("connect", server.address, "create", "tiers.l", status=1).stderr)
        done = espalier("connect", server.address, "create", model("branch-tiers"), "--environment", "sky.py", status=2)
        self.assertIn("write --environment 'stdio:python3 sky.py', which starts it", done.stderr)

    # ---- limits and numbers

    def test_a_limit_has_one_name(self) -> None:
        model = self.file(TREE)
        done = espalier("derive", model, "--limit", "modules=5", status=1)
        self.assertIn("(limit modules)", done.stderr)
        self.assertIn("(--limit modules=N sets another bound.)", done.stderr)
        deep = self.file("Lsystem: 1\nAxiom: F(" + "(" * 50 + "1" + ")" * 50 + ")\nendlsystem\n", "deep.l")
        done = espalier("derive", deep, "--limit", "expressionDepth=20", status=1)
        self.assertIn("deeper than the limit expressionDepth (20)", done.stderr)

    def test_traits_are_finite_or_an_error(self) -> None:
        model = self.file("Lsystem: 1\nderivation length: 1\nAxiom: F(1.0e200)+F(1.0e200)\nF --> F\nendlsystem\n")
        done = espalier("traits", model, status=1)
        self.assertEqual((done.stdout, "the trait 'length' is not a finite number" in done.stderr), ("", True))

    def test_a_binary_configuration_prints_no_control_characters(self) -> None:
        file = self.folder / "server.toml"
        file.write_bytes(bytes(range(256)) * 20)
        done = subprocess.run([program(), "serve", "--config", str(file), "--print-config"], capture_output=True,
                              timeout=SECONDS, check=False)
        self.assertEqual(done.returncode, 2)
        for line in done.stderr.decode("utf-8").splitlines():
            self.assertTrue(line.isprintable() or "\t" in line, repr(line))
            self.assertLessEqual(len(line), 200)


if __name__ == "__main__":
    unittest.main()
