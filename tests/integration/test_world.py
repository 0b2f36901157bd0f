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

    def test_what_cannot_be_has_a_sentence(self) -> None:
        for world, sentence in (({"up": [0, 0, 0]}, "up: a vector of length 0 has no direction"),
                                ({"up": [0, 1, 0], "north": [0, -1, 0]}, "'north' is along 'up'"),
                                ({"stepDuration": 0}, "stepDuration: expected a duration above 0, found 0"),
                                ({"stepDuration": "1 month"}, "stepDuration: expected a number of days, or a text"),
                                ({"latitude": 91}, "latitude: expected degrees from -90 to 90, found 91"),
                                ({"lengthUnit": "inch"}, "lengthUnit: expected m, dm, cm, mm, or 1"),
                                ({"start": "21.6.2021"}, "'start' is no date: '21.6.2021'"),
                                ({"weather": "none.csv"}, "there is no table of weather")):
            file = self.write("world.json", json.dumps(world))
            failed = espalier("derive", self.model, "--world", file, status=1)
            self.assertIn(sentence, failed.stderr)
            self.assertIn("world.json", failed.stderr)
        self.write("weather.csv", "time,direct\n1,5\n0,5\n")
        file = self.write("world.json", json.dumps({"weather": "weather.csv"}))
        self.assertIn("the weather's table, line 3: the time '0' is not after the one before",
                      espalier("derive", self.model, "--world", file, status=1).stderr)


if __name__ == "__main__":
    unittest.main()
