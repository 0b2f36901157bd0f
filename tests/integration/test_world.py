"""The world of a simulation: from files, options, the server and Python, kept by snapshots and traces."""

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List

from support import espalier, program

from espalier import Server, ServerError

SENSOR = """Lsystem: 1
derivation length: 3
Axiom: ?E(0,0,0)F(1)
endlsystem
"""
SUN: Dict[str, Any] = {"type": "light", "sun": "position", "sunSamples": 1}
WORLD: Dict[str, Any] = {"stepDuration": "1 h", "latitude": 52.52, "longitude": 13.405, "start": "2021-06-21T12:00+02:00"}


def light(text: str) -> List[float]:
    """The third parameter of the sensor in each line of a derivation."""
    return [float(line.split("?E(")[1].split(")")[0].split(",")[2]) for line in text.splitlines()]


class Worlds(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.model = self.write("sensor.l", SENSOR)
        self.sun = self.write("sun.json", json.dumps(SUN))

    def write(self, name: str, text: str) -> str:
        (self.folder / name).write_text(text)
        return str(self.folder / name)

    def derive(self, *arguments: str) -> List[float]:
        return light(espalier("derive", *arguments, "--every", "--quiet").stdout)

    def test_every_way_to_give_a_world_gives_the_same_light(self) -> None:
        world = self.write("berlin.json", json.dumps(WORLD))
        expected = self.derive(self.model, "--environment", self.sun, "--world", world)
        self.assertGreater(expected[2], expected[3], "the sun of the afternoon sinks from hour to hour")
        # the option wins over the file
        days = self.write("days.json", json.dumps({**WORLD, "stepDuration": 1}))
        self.assertEqual(self.derive(self.model, "--environment", self.sun, "--world", days, "--step-duration", "60 min"),
                         expected)
        # a forest, with its own member or the folder's file
        forest = {"models": [{"name": "sensor", "file": "sensor.l"}], "plants": [{"position": [0, 0, 0]}],
                  "environment": [SUN]}
        self.assertEqual(self.derive(self.write("forest.json", json.dumps({**forest, "world": WORLD}))), expected)
        self.write("forest.json", json.dumps(forest))
        self.write("world.json", json.dumps(WORLD))
        self.assertEqual(self.derive(str(self.folder / "forest.json")), expected)
        # the folder of a model
        (self.folder / "forest.json").unlink()
        self.assertEqual(self.derive(str(self.folder), "--environment", self.sun), expected)
        # the server
        with Server(program=program(), listen="127.0.0.1:0") as server, server.connect() as client:
            for given in (["--world", world], ["--world", days, "--step-duration", "60 min"]):
                plant = espalier("connect", server.address, "create", self.model, "--environment", json.dumps([SUN]), *given)
                espalier("connect", server.address, "run", plant.stdout.strip())
                self.assertEqual(light(espalier("connect", server.address, "get", plant.stdout.strip(), "string").stdout)[0],
                                 expected[3])
            self.assertIn("there is no world file 'none.json'", espalier(
                "connect", server.address, "create", self.model, "--world", "none.json", status=1).stderr)
            simulation = client.create(SENSOR, environment=[SUN], world=WORLD)
            simulation.run()
            self.assertEqual(light(simulation.string())[0], expected[3])
            with self.assertRaises(ServerError) as caught:
                client.create(SENSOR, environment=[SUN], world={"stepLength": 1})
            self.assertIn("params.world.stepLength: this key is not known", str(caught.exception))
            with self.assertRaises(ServerError) as caught:
                client.create(SENSOR, environment=[SUN], world={"start": "noon"})
            self.assertIn("params.world: 'start' is no date: 'noon'", str(caught.exception))

    def test_a_snapshot_and_a_trace_go_on_in_the_world_of_the_run(self) -> None:
        self.write("weather.csv", "time,direct,diffuse\n0,800,100\n1,100,50\n2,0,10\n3,0,0\n")
        world = self.write("berlin.json", json.dumps({**WORLD, "stepDuration": "1 d", "weather": "weather.csv"}))
        run = ("--environment", self.sun, "--world", world)
        expected = self.derive(self.model, *run)
        snapshot = str(self.folder / "half.snapshot")
        espalier("run", self.model, *run, "--steps", "1", "-o", snapshot, "--quiet")
        (self.folder / "weather.csv").unlink()
        end = str(self.folder / "end.string")
        espalier("run", "--resume", snapshot, "--steps", "3", "-o", end, "--quiet")
        self.assertEqual(light(Path(end).read_text())[0], expected[3])
        # the trace holds the world too, with its offset
        trace = self.folder / "run.trace"
        espalier("run", "--resume", snapshot, "--steps", "3", "--trace", str(trace), "-o", end, "--quiet")
        self.assertIn(WORLD["start"].encode(), trace.read_bytes())
        espalier("replay", str(trace))
        failed = espalier("run", "--resume", snapshot, "--world", world, "-o", end, status=1)
        self.assertIn("--world and --step-duration are for a new run", failed.stderr)

    def test_an_environment_in_another_process_is_told(self) -> None:
        self.write("weather.csv", "time,direct,diffuse\n0,800,100\n1,100,50\n2,0,10\n3,0,0\n")
        world = self.write("berlin.json", json.dumps({**WORLD, "stepDuration": "1 d", "weather": "weather.csv"}))
        keys = self.write("keys.json", json.dumps({"sun": "position", "sunSamples": 1}))
        remote = f"stdio:{program()} environment light --stdio --configuration {keys}"
        self.assertEqual(self.derive(self.model, "--environment", remote, "--world", world),
                         self.derive(self.model, "--environment", self.sun, "--world", world))

    def test_a_model_reads_the_weather(self) -> None:
        model = self.write("bud.l", "Lsystem: 1\nderivation length: 4\nAxiom: B(0)\n"
                                    "B(t) : world.thermalTime >= 10 --> F(world.time)\nB(t) --> B(world.temperature)\n"
                                    "endlsystem\n")
        self.write("weather.csv", "time,temperature\n0,9\n1,12\n2,13\n3,14\n")
        world = self.write("world.json", json.dumps({"weather": "weather.csv", "baseTemperature": 5}))
        strings = espalier("derive", model, "--world", world, "--every", "--quiet").stdout.splitlines()
        # 4, then 11 degree days above 5 °C
        self.assertEqual([line.split("\t")[1] for line in strings], ["B(0)", "B(9)", "B(12)", "F(2)", "F(2)"])
        self.assertIn("the world has no 'weather'", espalier("derive", model, status=1).stderr)

    def test_a_server_gives_the_folder_of_a_model_its_world(self) -> None:
        folder = self.folder / "gallery" / "sensor"
        folder.mkdir(parents=True)
        (folder / "sensor.l").write_text(SENSOR)
        (folder / "sensor.json").write_text(json.dumps(SUN))
        (folder / "weather.csv").write_text("time,direct,diffuse\n0,800,100\n0.1,100,50\n")
        (folder / "world.json").write_text(json.dumps({**WORLD, "weather": "weather.csv"}))
        expected = self.derive(str(folder))[3]
        self.assertGreater(expected, 0.0)
        forest = self.folder / "gallery" / "stand"
        forest.mkdir()
        (forest / "sensor.l").write_text(SENSOR)
        (forest / "weather.csv").write_text((folder / "weather.csv").read_text())
        (forest / "forest.json").write_text(json.dumps(
            {"models": [{"name": "sensor", "file": "sensor.l"}], "plants": [{"position": [0, 0, 0]}], "environment": [SUN],
             "world": {**WORLD, "weather": "weather.csv"}}))
        with Server(program=program(), listen="127.0.0.1:0", arguments=["--gallery", str(self.folder / "gallery")]) as server, \
                server.connect() as client:
            made = {"gallery": client.create(gallery="sensor"), "forest": client.create(gallery="stand"),
                    "folder": client.create(folder)}
            for name, simulation in made.items():
                simulation.run()
                self.assertEqual(light(simulation.string())[0], expected, name)
            # the request's own world wins
            own = client.create(gallery="sensor", world={**WORLD, "start": "2021-06-21T00:00+02:00"})
            own.run()
            self.assertEqual(light(own.string())[0], 0.0)
            (folder / "world.json").write_text('{"weather": "none.csv"}')
            with self.assertRaises(ServerError) as caught:
                client.create(gallery="sensor")
            self.assertIn("The gallery's 'sensor/world.json': there is no table of weather 'none.csv'", str(caught.exception))

    def test_a_sweep_runs_in_a_world(self) -> None:
        world = self.write("berlin.json", json.dumps(WORLD))
        expected = self.derive(self.model, "--environment", self.sun, "--world", world)[3]
        plan: Dict[str, Any] = {"model": "sensor.l", "environment": SUN, "measures": {"light": {"sum": "c", "of": "E(a,b,c)"}}}
        results = str(self.folder / "results.sqlite")

        def swept(*options: str, **members: Any) -> float:
            file = self.write("plan.json", json.dumps({**plan, **members}))
            Path(results).unlink(missing_ok=True)
            espalier("sweep", file, "-o", results, "--quiet", *options)
            return float(espalier("sweep", "export", results).stdout.splitlines()[1].split(",")[2])

        # the last step is answered with the third hour in sight
        self.assertAlmostEqual(swept("--world", world, answered=False), expected)
        self.assertAlmostEqual(swept(world="berlin.json"), expected)
        self.assertAlmostEqual(swept(world=WORLD), expected)
        self.assertAlmostEqual(swept("--step-duration", "1 h", world={**WORLD, "stepDuration": "1 d"}), expected)
        self.assertAlmostEqual(swept(world={**WORLD, "stepDuration": "1 d"}, stepDuration="1 h"), expected)
        # results of one world are not continued in another
        self.assertAlmostEqual(swept("--world", world), expected)
        failed = espalier("sweep", str(self.folder / "plan.json"), "-o", results, "--world", world, "--step-duration", "2 h", status=1)
        self.assertIn("the model, its environment or the version of the program differs", " ".join(failed.stderr.split()))
        # the folder of a model brings its own
        self.write("world.json", json.dumps(WORLD))
        self.assertAlmostEqual(swept(model=str(self.folder)), expected)
        for members, sentence in (({"world": {"latitude": 91}}, "plan.json: world: latitude: expected degrees from -90 to 90, found 91"),
                                  ({"world": "none.json"}, "there is no world file"),
                                  ({"stepDuration": "1 month"}, 'stepDuration: expected a time above 0 such as "1 h"')):
            file = self.write("plan.json", json.dumps({**plan, **members}))
            self.assertIn(sentence, espalier("sweep", file, "-o", results, status=1).stderr)

    def test_an_evolution_runs_in_a_world(self) -> None:
        # the plant has more segments from half a day on
        model = self.write("hours.l", "#define K 1\nLsystem: 1\nderivation length: 3\nAxiom: A\n"
                                      "A : world.time > 0.5 * K --> FFFFA\nA --> FA\nendlsystem\n")
        table = {}
        for duration in ("1 h", "1 d"):
            folder = self.folder / duration.replace(" ", "")
            espalier("evolve", model, "--gene", "K=0.9:1.1", "--population", "2", "--generations", "1", "--fitness", "length",
                     "--step-duration", duration, "-o", str(folder), "--quiet")
            table[duration] = (folder / "generations.csv").read_text()
        self.assertNotEqual(table["1 h"], table["1 d"])

    def test_what_cannot_be_has_a_sentence(self) -> None:
        for world, sentence in (({"up": [0, 0, 0]}, "up: a vector of length 0 has no direction"),
                                ({"up": "none"}, "up: expected three numbers such as [0, 1, 0], found \"none\""),
                                ({"north": [1, 0]}, "north: expected three numbers such as [0, 0, -1], found an array"),
                                ({"up": [0, 1, 0], "north": [0, -1, 0]}, "'north' is along 'up'"),
                                ({"stepDuration": 0}, "stepDuration: expected a duration above 0, found 0"),
                                ({"stepDuration": "1 month"}, "stepDuration: expected a number of days, or a text"),
                                ({"stepDuration": 1e300}, "'stepDuration' must be at most 1000000 days; give a number of days"),
                                ({"stepDuration": None}, "stepDuration: null is no value; leave the key out for its default"),
                                ({"up": None}, "up: null is no value; leave the key out for its default"),
                                ({"weather": None}, "weather: null is no value"),
                                ({"latitude": 91}, "latitude: expected degrees from -90 to 90, found 91"),
                                ({"lengthUnit": "inch"}, "lengthUnit: expected m, dm, cm, mm, or 1"),
                                ({"start": "21.6.2021"}, "'start' is no date: '21.6.2021'"),
                                ({"weather": "none.csv"}, "there is no table of weather")):
            file = self.write("world.json", json.dumps(world))
            failed = espalier("derive", self.model, "--world", file, status=1)
            self.assertIn(sentence, failed.stderr)
            self.assertIn("world.json", failed.stderr)
        self.write("empty.csv", "")
        file = self.write("world.json", json.dumps({"weather": "empty.csv"}))
        self.assertIn("empty.csv' is empty: check 'weather'", espalier("derive", self.model, "--world", file, status=1).stderr)
        self.write("weather.csv", "time,direct\n1,5\n0,5\n")
        file = self.write("world.json", json.dumps({"weather": "weather.csv"}))
        self.assertIn("the weather's table, line 3: the time '0' is not after the one before",
                      espalier("derive", self.model, "--world", file, status=1).stderr)


if __name__ == "__main__":
    unittest.main()
