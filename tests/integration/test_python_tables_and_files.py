"""The Python package as scientists use it: models from files, environments by any name, tables, threads, and an end."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest
from pathlib import Path
from typing import Any, List
from unittest import mock

from support import GALLERY, REPOSITORY, program

import espalier
from espalier import tables

MODEL = "Lsystem: 1\nderivation length: 4\nAxiom: A\nA --> F(1)[+(40)F(0.5)]A\nendlsystem\n"


class Height(espalier.Environment):
    def answer(self, query: espalier.Query) -> List[float]:
        return [query.position[1]]


class Scientist(unittest.TestCase):
    client: espalier.Local

    @classmethod
    def setUpClass(cls) -> None:
        with mock.patch.dict("os.environ", {"ESPALIER_PROGRAM": program()}):
            cls.client = espalier.local(arguments=["--log-level", "off"])
        cls.addClassCleanup(cls.client.close)

    def test_a_model_is_a_file_a_folder_a_path_or_a_text(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "tree.l").write_text(MODEL.replace("F(1)", "F(LENGTH)").replace("Lsystem", '#include "sizes.h"\nLsystem'))
            (folder / "sizes.h").write_text("#define LENGTH 2\n")
            (folder / "tree.v").write_text("initial line width: 0.25\n")
            (folder / "notes.txt").write_text("not part of the model\n")
            for model in (str(folder / "tree.l"), folder / "tree.l", folder, str(folder)):
                plant = self.client.create(model)
                plant.step()
                self.assertEqual(plant.string(), "F(2)[+(40)F(0.5)]A", model)
                self.assertEqual(plant.turtle()[0].width, 0.25)
        plant = self.client.create(MODEL)
        plant.step()
        self.assertEqual(plant.string(), "F(1)[+(40)F(0.5)]A")
        with self.assertRaisesRegex(espalier.EspalierError, "There is no model file or folder 'missing.l'"):
            self.client.create("missing.l")

    def test_a_published_folder_has_its_colours_and_its_last_frame(self) -> None:
        for made in (self.client.create(GALLERY / "lilac"), self.client.create(gallery="lilac")):
            self.assertEqual(made.created["derivationLength"], 22)
            made.step(until=3)
            with tempfile.TemporaryDirectory() as name:
                # the same bytes as on the command line
                expected = Path(name) / "lilac.glb"
                subprocess.run([program(), "run", str(GALLERY / "lilac"), "--steps", "3", "--instancing", "-o", str(expected),
                                "--quiet"], check=True)
                self.assertEqual(made.geometry()[:expected.stat().st_size], expected.read_bytes())

    def test_an_environment_is_a_name_a_mapping_a_class_an_object_or_a_list(self) -> None:
        model = (GALLERY / "growth-to-a-height" / "growth-to-a-height.l").read_text()
        own = Height()
        for environment in ("height", {"type": "height"}, Height, own, ["height"], [Height]):
            plant = self.client.create(model, environment=environment)
            plant.run()
            self.assertEqual(plant.string(), "F(0,0)F(0,1)F(0,2)?E(2)", environment)
        self.assertGreater(own.completed_steps, 0)
        # two objects of one class are two environments
        both = [Height(), Height()]
        plant = self.client.create(model, environment=both)
        self.assertEqual([one.opening.simulation for one in both if one.opening], [plant.identifier] * 2)
        environment: Any = 7
        with self.assertRaisesRegex(espalier.EspalierError, "7 is no environment"):
            self.client.create(model, environment=environment)

    def test_a_frame_is_a_table(self) -> None:
        plant = self.client.create(MODEL)
        plant.step(2)
        with plant.stream() as stream, plant.stream(arrays=True) as columns:
            frame, fast = stream.read(), columns.read()
        rows = list(frame)
        self.assertEqual(len(rows), len(frame))
        self.assertEqual([row["symbol"] for row in rows], ["F", "F", "F", "F"])
        self.assertEqual(rows[2]["y"], 2.0)
        self.assertEqual(rows[0]["parent"], -1)
        self.assertEqual([dict(row) for row in fast], [dict(row) for row in rows])
        table = frame.to_numpy()
        self.assertEqual(table["y"][2], 2.0)
        self.assertEqual(table[table["symbol"] == "F"]["parameter_1"].tolist(), [1.0, 0.5, 1.0, 0.5])

        class DataFrame:
            def __init__(self, columns: Any) -> None:
                self.columns = columns

        with mock.patch.dict("sys.modules", {"pandas": mock.Mock(DataFrame=DataFrame)}):
            self.assertEqual(frame.to_pandas().columns, tables.to_columns(frame.records))
        self.assertTrue(repr(frame).startswith("<Frame: step 2, 4 records"))

    def test_several_threads_use_one_client(self) -> None:
        endless = self.client.create("Lsystem: 1\nderivation length: 1000000000\nAxiom: A\nA --> A\nendlsystem\n")
        ended: List[bool] = []
        running = threading.Thread(target=lambda: ended.append(endless.run().truncated))
        running.start()
        strings: List[str] = []

        def grow() -> None:
            algae = self.client.create(gallery="classic-algae")
            algae.step(4)
            strings.append(algae.string())

        others = [threading.Thread(target=grow) for _ in range(5)]
        for thread in others:
            thread.start()
        for thread in others:
            thread.join(60)
        self.assertEqual(strings, ["abaababa"] * 5)
        while endless.pause() == 0:
            pass  # the run has not begun
        running.join(60)
        self.assertEqual(ended, [True])

    def test_everything_says_what_it_is(self) -> None:
        plant = self.client.create(MODEL, name="pine")
        plant.step(2)
        self.assertIn("Local", repr(self.client))
        self.assertIn("step 2", repr(plant))
        self.assertRegex(repr(plant.view()), r"<View of '.*': 1 frame, \d+\.\d MB>")
        with plant.stream() as stream:
            self.assertIn("open", repr(stream))
        self.assertIn("closed", repr(stream))

    def test_the_server_ends_with_its_program_however_it_ends(self) -> None:
        script = textwrap.dedent("""
            import espalier, sys, time
            client = espalier.local(arguments=["--log-level", "off"])
            print(client.address[len("unix:"):], flush=True)
            time.sleep(600)
        """)
        variables = {**os.environ, "ESPALIER_PROGRAM": program(), "PYTHONPATH": str(REPOSITORY / "clients" / "python")}
        child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, env=variables, text=True)
        assert child.stdout is not None
        address = child.stdout.readline().strip()
        child.send_signal(signal.SIGKILL)
        child.communicate(timeout=60)
        # the server closes its socket when it ends
        while True:
            with socket.socket(socket.AF_UNIX) as probe:
                if probe.connect_ex(address) != 0:
                    break
            time.sleep(0.01)
        shutil.rmtree(Path(address).parent)

    def test_a_program_that_closes_nothing_leaves_no_folder(self) -> None:
        script = """
import espalier
client = espalier.local()
print(client.address[len("unix:"):])
"""
        variables = {**os.environ, "ESPALIER_PROGRAM": program(), "PYTHONPATH": str(REPOSITORY / "clients" / "python")}
        ended = subprocess.run([sys.executable, "-c", script], capture_output=True, env=variables, text=True, check=True)
        self.assertFalse(Path(ended.stdout.strip()).parent.exists())
        self.assertEqual(ended.stderr, "")


if __name__ == "__main__":
    unittest.main()
