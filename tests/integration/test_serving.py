"""`espalier serve` and `espalier status` as their operator sees them: configuration, log, status."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Tuple

from support import SECONDS, Process, espalier, program, variables

from espalier import Client


class Serving(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def configuration(self, text: str) -> str:
        file = self.folder / "server.toml"
        file.write_text(text, encoding="utf-8")
        return str(file)

    def test_what_print_config_prints_is_a_configuration(self) -> None:
        first = espalier("serve", "--listen", "127.0.0.1:0", "--workers", "3", "--insecure", "--limit", "sessions=7",
                         "--print-config").stdout
        self.assertIn('listen = "127.0.0.1:0"\n', first)
        self.assertIn('workers = "3"\n', first)
        self.assertIn("insecure = true\n", first)
        self.assertIn("allow-spawn = false\n", first)
        self.assertIn("sessions = 7  # peers at a time that have said hello\n", first)
        again = espalier("serve", "--config", self.configuration(first), "--print-config").stdout
        self.assertEqual(again, first)

    def test_the_command_line_wins_over_the_configuration(self) -> None:
        file = self.configuration('listen = "127.0.0.1:4000"\nworkers = 3\n[limits]\nsessions = 5\nmodules = 1000\n')
        text = espalier("serve", "--config", file, "--workers", "2", "--limit", "sessions=6", "--print-config").stdout
        self.assertIn('listen = "127.0.0.1:4000"\n', text)
        self.assertIn('workers = "2"\n', text)
        self.assertIn("sessions = 6 ", text)
        self.assertIn("modules = 1000 ", text)

    def test_a_token_is_not_printed(self) -> None:
        self.assertNotIn("secret", espalier("serve", "--token", "secret", "--print-config").stdout)

    def test_what_is_not_known_is_refused_with_the_nearest_name(self) -> None:
        for text, problem in (
                ("worker = 3\n", "'worker' is not an option. Did you mean 'workers'?"),
                ("[limits]\nsession = 3\n", "there is no limit 'session'. Did you mean 'sessions'?"),
                ("[limits]\nsessions = 0\n", "must be from 1 to 4294967295, not 0."),
                ("insecure = maybe\n", "'insecure' is true or false, not 'maybe'."),
                ("workers = many\n", "the configuration '")):
            self.assertIn(problem, espalier("serve", "--config", self.configuration(text), status=2).stderr, text)
        self.assertIn("the configuration 'nowhere.toml' (--config) cannot be read",
                      espalier("serve", "--config", "nowhere.toml", status=2).stderr)

    def test_the_log_can_be_json_and_says_what_it_is_about(self) -> None:
        log = self.folder / "log"
        with log.open("wb") as errors:
            serve = subprocess.Popen([program(), "serve", "--listen", "127.0.0.1:0", "--log-format", "json"],
                                     stdout=subprocess.PIPE, stderr=errors, text=True, env=variables())
            assert serve.stdout is not None
            address = serve.stdout.readline().split()[-1]
            with Client(address, timeout=SECONDS) as client:
                simulation = client.create("Lsystem: 1\nAxiom: A\nA --> A\nendlsystem\n").identifier
            serve.terminate()
            self.assertEqual(serve.wait(SECONDS), 0)
            serve.stdout.close()
        lines = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
        for line in lines:
            self.assertTrue({"time", "level", "message"} <= set(line), line)
        created = [line for line in lines if line["message"] == "created"]
        self.assertEqual([(line["simulation"], line["session"], line["level"]) for line in created],
                         [(simulation, "1", "info")])

    def serve_with_a_pipe_for_its_log(self) -> Tuple[Process, int]:
        reader, writer = os.pipe()
        serve = Process(["bash", "-c", f'exec "$0" serve --listen 127.0.0.1:0 2>&{writer}', program()], pass_fds=(writer,))
        self.addCleanup(serve.stop)
        os.close(writer)
        return serve, reader

    def test_a_server_goes_on_when_the_reader_of_its_log_has_ended(self) -> None:
        serve, reader = self.serve_with_a_pipe_for_its_log()
        os.close(reader)
        for _ in range(3):
            with Client(serve.address, timeout=SECONDS) as client:
                self.assertEqual(client.status()["simulations"], 0)

    def test_a_server_goes_on_when_nobody_reads_its_log(self) -> None:
        serve, reader = self.serve_with_a_pipe_for_its_log()
        self.addCleanup(os.close, reader)
        # more lines than a pipe holds
        for _ in range(1000):
            with Client(serve.address, timeout=SECONDS):
                pass
        os.set_blocking(reader, False)
        self.assertGreater(len(os.read(reader, 1 << 20)), 50_000)
        with Client(serve.address, timeout=SECONDS) as client:
            client.status()
            self.assertRegex(os.read(reader, 1 << 20).decode(), r"^\S+ warning [1-9][0-9]* lines are missing here: nobody read the log\n")

    def test_status_asks_a_running_server(self) -> None:
        serve = Process([program(), "serve", "--listen", "127.0.0.1:0", "--data", str(self.folder / "data"),
                         "--log-level", "off"])
        self.addCleanup(serve.stop)
        text = espalier("status", serve.address).stdout
        self.assertRegex(text, r"(?m)^sessions +1$")
        self.assertRegex(text, r"(?m)^saved on disk +true$")
        self.assertRegex(text, r"(?m)^bytes of the data folder +[1-9][0-9]+$")
        status = json.loads(espalier("status", serve.address, "--json").stdout)
        self.assertEqual(status["memory"]["stringBytes"], 0)
        serve.stop()
        self.assertNotEqual(espalier("status", serve.address, status=1).stderr, "")

    def test_load_says_how_fast_a_server_answers(self) -> None:
        serve = Process([program(), "serve", "--listen", "127.0.0.1:0", "--log-level", "off"])
        self.addCleanup(serve.stop)
        text = espalier("load", serve.address, "--sessions", "3", "--viewers", "4", "--idle", "10", "--seconds", "0.5").stdout
        for figure in ("steps/s", "queries/s", r"step, median \(us\)", r"step, 99 of 100 \(us\)", "frames/s", "bytes a frame"):
            self.assertRegex(text, rf"(?m)^{figure} +[1-9][0-9]*$")
        with Client(serve.address, timeout=SECONDS) as client:
            self.assertEqual(client.status()["simulations"], 0)
        serve.stop()
        self.assertIn("Cannot connect", espalier("load", serve.address, status=1).stderr)

    def test_sigterm_finishes_saves_and_ends(self) -> None:
        data = str(self.folder / "data")
        serve = Process([program(), "serve", "--listen", "127.0.0.1:0", "--data", data, "--log-level", "off"])
        with Client(serve.address, timeout=SECONDS) as client:
            simulation = client.create("Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> AA\nendlsystem\n", save=True)
            simulation.step(3)
        serve.process.terminate()
        self.assertEqual(serve.wait(), 0)
        serve.stop()
        serve = Process([program(), "serve", "--listen", "127.0.0.1:0", "--data", data, "--log-level", "off"])
        self.addCleanup(serve.stop)
        with Client(serve.address, timeout=SECONDS) as client:
            self.assertEqual(client.simulation(simulation.identifier).string(), "AAAAAAAA")


if __name__ == "__main__":
    unittest.main()
