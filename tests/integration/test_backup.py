"""`espalier backup` of a server that runs, and `espalier restore` into another folder."""

import contextlib
import sqlite3
import tempfile
import unittest
from pathlib import Path

from support import SECONDS, Process, espalier, program

from espalier import Client

GROWING = "Lsystem: 1\nderivation length: 40\nAxiom: A(0.5)\nA(x) --> F(ran(1))A(x+1)\nendlsystem\n"


class Backup(unittest.TestCase):
    def serve(self, folder: Path, *arguments: str) -> Process:
        process = Process([program(), "serve", "--listen", "127.0.0.1:0", "--data", str(folder), "--log-level", "off", *arguments])
        self.addCleanup(process.stop)
        return process

    def test_a_copy_of_a_running_server_becomes_another_server(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            running = self.serve(folder / "data", "--durability", "power")
            with Client(running.address, timeout=SECONDS) as client:
                self.assertEqual(client.status()["durability"], "power")
                plant = client.create(GROWING, seed=3)
                plant.step(7)
                state = plant.get("state-hash")
                done = espalier("backup", str(folder / "data"), str(folder / "copy"))
                self.assertEqual((done.stdout, done.stderr), ("", ""))
                plant.step(5)
                self.assertIn("is used by another server", espalier("restore", str(folder / "copy"), str(folder / "data"),
                                                                     status=1).stderr)
            espalier("restore", str(folder / "copy"), str(folder / "other"))
            with Client(self.serve(folder / "other").address, timeout=SECONDS) as client:
                again = client.simulation(plant.identifier)
                self.assertEqual(again.get("state-hash"), state)
                self.assertEqual(again.step(1).step, 8)

    def test_a_database_with_programs_of_its_own_is_no_backup(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with Client(self.serve(folder / "data").address, timeout=SECONDS) as client:
                client.create(GROWING, seed=3).step(2)
            espalier("backup", str(folder / "data"), str(folder / "copy"))
            with contextlib.closing(sqlite3.connect(folder / "copy")) as copy:
                copy.execute("CREATE TRIGGER lost AFTER INSERT ON parts BEGIN DELETE FROM parts; END")
                copy.commit()
            refused = espalier("restore", str(folder / "copy"), str(folder / "other"), status=1).stderr
            self.assertIn("has triggers or views, which no backup has ('lost')", refused)
            self.assertFalse((folder / "other" / "espalier.sqlite").exists())

    def test_the_configuration_has_a_section_for_it(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            file = Path(name, "server.toml")
            file.write_text('[store]\ndurability = "power"\n', encoding="utf-8")
            printed = espalier("serve", "--config", str(file), "--print-config").stdout
            self.assertIn('\n[store]\ndurability = "power"\n', printed)
            self.assertIn('durability = "process"', espalier("serve", "--print-config").stdout)
            for text in ('[store]\ndurability = "maybe"\n', '[store]\nother = "power"\n', 'durability = "power"\n'):
                file.write_text(text, encoding="utf-8")
                self.assertIn("the configuration", espalier("serve", "--config", str(file), status=2).stderr, text)


if __name__ == "__main__":
    unittest.main()
