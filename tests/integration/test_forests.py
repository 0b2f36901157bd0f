"""Plants of several models in one environment, with seeds and deaths: files, the server, snapshots."""

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List

from support import GALLERY, espalier, program

from espalier import Server, ServerError

OAK = """Lsystem: 1
Module: ?Seed(asks, model), ?Death(asks)
seed: 5
derivation length: 14
Axiom: A(1)?E(0.4)
A(t) > ?E(x) : t == 4 --> F(1)[+(90)f(1+ran(2))?Seed(1,0)][-(90)f(1+ran(2))?Seed(1,2)]/(137)A(t+1)
A(t) > ?E(x) : t == 8 --> ?Death(1)
A(t) > ?E(x) : t != 4 && t != 8 --> F(0.3+ran(0.2))[+(40)F(0.4)]/(137)A(t+1)
endlsystem
"""
SHRUB = """Lsystem: 1
derivation length: 5
Axiom: F(0.2)?E(0.2)
F(l) --> F(l*1.1)
endlsystem
"""
FOREST: Dict[str, Any] = {
    "models": [{"name": "oak", "file": "oak.l"}, {"name": "shrub", "file": "shrub.l", "colour": -60}],
    "plants": [{"position": [0, 0, 0]}, {"model": "shrub", "position": [3, 0, 0], "turn": 50},
               {"model": "oak", "position": [-2, 0, 1]}],
    "environment": [{"type": "ecosystem"}],
    "seeds": {"spacing": 0.5, "area": [[-6, 0, -6], [6, 0, 6]]},
}


def lines(*arguments: str) -> List[str]:
    return espalier("derive", *arguments).stdout.splitlines()


class Forests(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "oak.l").write_text(OAK)
        (self.folder / "shrub.l").write_text(SHRUB)
        self.forest = self.write(FOREST)

    def write(self, content: Any, name: str = "forest.json") -> str:
        path = self.folder / name
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return str(path)

    def test_a_run_has_plants_that_come_and_go(self) -> None:
        after = lines(self.forest)
        numbers = [int(line.split("\t")[0]) for line in after]
        self.assertNotIn(0, numbers)  # it died
        self.assertGreater(max(numbers), 4)
        # a folder with a forest.json is the forest
        self.assertEqual(lines(str(self.folder)), after)

    def test_the_order_of_the_list_and_threads_do_not_matter(self) -> None:
        expected = lines(self.forest)
        shuffled = dict(FOREST, plants=list(reversed(FOREST["plants"])))
        self.assertEqual(lines(self.write(shuffled, "shuffled.json")), expected)
        self.assertEqual(lines(self.forest, "--threads", "4"), expected)

    def test_a_snapshot_of_it_goes_on_without_its_files(self) -> None:
        snapshot = str(self.folder / "forest.snapshot")
        espalier("run", self.forest, "--steps", "8", "-o", snapshot, "--quiet")
        for file in ("oak.l", "shrub.l", "forest.json"):
            (self.folder / file).rename(self.folder / (file + ".away"))
        espalier("run", "--resume", snapshot, "--steps", "14", "-o", str(self.folder / "late.csv"), "--quiet")
        espalier("export", snapshot, "-o", str(self.folder / "early.obj"), "--quiet")
        for file in ("oak.l", "shrub.l", "forest.json"):
            (self.folder / (file + ".away")).rename(self.folder / file)
        espalier("run", self.forest, "--steps", "14", "-o", str(self.folder / "whole.csv"), "--quiet")
        self.assertEqual((self.folder / "late.csv").read_text(), (self.folder / "whole.csv").read_text())
        self.assertIn("plant_1", (self.folder / "early.obj").read_text())

    def test_a_server_grows_the_same_forest_and_has_it_after_a_restart(self) -> None:
        models = [{"name": "oak", "source": OAK}, {"name": "shrub", "source": SHRUB}]
        data = str(self.folder / "data")
        server = Server(program(), arguments=["--data", data, "--log-level", "off"])
        self.addCleanup(server.stop)
        with server.connect(timeout=60) as client:
            forest = client.create_forest(models, FOREST["plants"], seeds=FOREST["seeds"],
                                          environment=FOREST["environment"])
            self.assertEqual(forest.step(6).statistics["plants"], 7)
            identifier = forest.identifier
        server.stop()
        server = Server(program(), arguments=["--data", data, "--log-level", "off"])
        self.addCleanup(server.stop)
        with server.connect(timeout=60) as client:
            forest = client.simulation(identifier)
            made = forest.step(8)
            self.assertTrue(made.finished)
            count = forest.get("information")["information"]["plants"]
            strings = [forest.get("string", plant=plant)["string"] for plant in range(count)]
            self.assertEqual([line.split("\t")[1] for line in lines(self.forest)],
                             [string for string in strings if string])
            # back to the beginning, with the plants of the beginning
            forest.reset()
            self.assertEqual(forest.step(1).statistics["plants"], 3)
            with self.assertRaises(ServerError) as caught:
                client.create_forest(models, [{"position": [0, 0, 0], "model": "elm"}])
            self.assertIn("params.plants[0].model: there is no model 'elm'. There are oak, shrub",
                          str(caught.exception))

    def test_a_server_grows_forests_and_models_of_its_gallery_and_has_them_after_a_restart(self) -> None:
        arguments = ["--data", str(self.folder / "data"), "--log-level", "off", "--gallery", str(GALLERY)]
        server = Server(program(), arguments=arguments)
        self.addCleanup(server.stop)
        with server.connect(timeout=60) as client:
            forest = client.create(gallery="two-trees")
            self.assertEqual(forest.step(4).statistics["plants"], 2)
            # its configuration is a single process, not a list
            pattern = client.create(gallery="density-pattern")
            pattern.step(3)
            # plants of one's own are of the folder's model
            alone = client.create(gallery="two-trees", plants=[(0, 0, 0)])
            self.assertEqual(alone.get("information")["information"]["plants"], 1)
        server.stop()
        server = Server(program(), arguments=arguments)
        self.addCleanup(server.stop)
        with server.connect(timeout=60) as client:
            again = client.simulation(forest.identifier)
            again.step(4)
            expected = lines(str(GALLERY / "two-trees"), "--steps", "8")
            self.assertEqual([again.get("string", plant=plant)["string"] for plant in range(2)],
                             [line.split("\t")[1] for line in expected])
            pattern = client.simulation(pattern.identifier)
            pattern.step(3)
            derived = espalier("derive", str(GALLERY / "density-pattern"), "--steps", "6", "--quiet").stdout.strip()
            self.assertEqual(pattern.get("string")["string"], derived)

    def test_what_is_wrong_is_named_with_its_place(self) -> None:
        for change, message in [
            ({"models": [{"name": "oak", "file": "oak.x"}, {"name": "shrub", "file": "shrub.l"}]}, "there is no file '"),
            ({"plants": [{"position": [0, 0]}]}, "plants[0].position: expected three numbers"),
            ({"plants": [{"position": [0, 0, 0], "turm": 3}]},
             "plants[0].turm: this key is not known; did you mean 'turn'? There are model, position, heading"),
            ({"plants": []}, "plants: expected at least one plant"),
            ({"models": []}, "models: expected at least one model"),
            ({"models": [{"name": "a", "file": "oak.l"}, {"name": "a", "file": "oak.l"}]},
             "models[1].name: there are two models 'a'; give each a name of its own"),
            ({"seeds": {"spacing": -1}}, "seeds.spacing: expected a length of at least 0"),
            ({"seeds": {"area": [[0, 0, 0]]}}, "seeds.area: expected two corners of three numbers"),
            ({"environment": [{"type": "ecosystem", "raduis": 3}]}, "raduis"),
        ]:
            with self.subTest(message=message):
                failed = espalier("check", self.write(dict(FOREST, **change), "bad.json"), status=1)
                self.assertIn(message, failed.stderr)
        self.assertIn("line 1, column", espalier("check", self.write("{", "bad.json"), status=1).stderr)
        self.assertIn("--from is for a single model", espalier("derive", self.forest, "--from", "x", status=1).stderr)


if __name__ == "__main__":
    unittest.main()
