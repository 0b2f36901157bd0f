"""Environments in and out of the process, in C++ and in Python: the same plant, bit by bit; and what happens when one dies."""

import asyncio
import json
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path
from typing import List

from support import EXAMPLES, GALLERY, PACKAGE, Process, espalier, model, program, python, stdio, strings

from espalier import AsyncClient, Client, EspalierError, Server, ServerError, local

RADIUS = "0.5"


class Transports(unittest.TestCase):
    def listening(self, command: List[str]) -> str:
        process = Process(command)
        self.addCleanup(process.stop)
        return f"tcp://{process.address}"

    def write(self, name: str, content: str) -> str:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name) / name
        path.write_text(content, encoding="utf-8")
        return str(path)

    def same(self, name: str, *environments: str) -> None:
        expected = strings(name)
        self.assertGreater(len(expected[-1]), len(expected[0]))
        for environment in environments:
            with self.subTest(environment):
                self.assertEqual(strings(name, "--environment", environment), expected)

    def test_growth_to_a_height_is_the_same_everywhere(self) -> None:
        built_in = [program(), "environment", "height"]
        in_python = python(EXAMPLES / "height.py")
        self.same("growth-to-a-height", "height", stdio([*built_in, "--stdio"]), stdio(in_python),
                  self.listening([*built_in, "--listen", "127.0.0.1:0"]),
                  self.listening([*in_python, "--listen", "127.0.0.1:0"]))

    def test_branch_tiers_are_the_same_everywhere(self) -> None:
        built_in = [program(), "environment", "honda", "--configuration", self.write("honda.json", '{"radius":0.5}')]
        in_python = python(EXAMPLES / "honda.py", "--radius", RADIUS)
        self.same("branch-tiers", stdio([*built_in, "--stdio"]), stdio(in_python),
                  self.listening([*built_in, "--listen", "127.0.0.1:0"]),
                  self.listening([*in_python, "--listen", "127.0.0.1:0"]))

    def test_an_environment_is_no_server_for_python(self) -> None:
        address = self.listening([program(), "environment", "height", "--listen", "127.0.0.1:0"])[len("tcp://"):]

        async def connect() -> None:
            async with AsyncClient(address):
                pass

        for connecting in (lambda: Client(address), lambda: asyncio.run(connect())):
            with self.assertRaisesRegex(EspalierError, f"^At {address} is an environment, not a server. .*environment='tcp://{address}'"):
                connecting()

    def test_a_program_is_no_name_of_an_environment(self) -> None:
        cut = self.write("cut.json", '{"type":\n "honda",}')
        with local(program()) as client:
            for name, message in (("well.py", "'well.py' is a program, .*: 'stdio:python3 well.py' lets the server start it. Or give its class."),
                                  ("python3 well.py", "'python3 well.py' is a program, .*: 'stdio:python3 well.py' lets"),
                                  ("well.R", "'well.R' is a program, .*: 'stdio:Rscript well.R' lets the server start it.$"),
                                  (cut, "cut.json:2:10: the environment is not valid JSON: ")):
                with self.subTest(name), self.assertRaisesRegex(EspalierError, message):
                    client.create("Lsystem: 1\nAxiom: F?E(1)\nF --> F\nendlsystem\n", environment=name)

    def test_growth_in_space_is_the_same_in_python(self) -> None:
        self.same("ulam-warburton-3d", stdio(python(EXAMPLES / "honda.py", "--radius", RADIUS, "--3d")))

    def test_light_soil_space_and_crowding_are_the_same_over_the_wire(self) -> None:
        # process, model, its configuration, steps
        cases = [("colonization", "self-organizing-tree", "self-organizing-tree.json", "16"),
                 ("light-voxels", "self-organizing-tree", "shade.json", "24"),
                 ("crowding", "self-thinning", "self-thinning.json", "12"),
                 ("soil-water", "roots-in-soil", "roots-in-soil.json", "12")]
        for process, name, file, steps in cases:
            configuration = str(GALLERY / name / file)
            more = ["--seed", "1", "--steps", steps]
            expected = strings(name, *more, "--environment", configuration)
            self.assertGreater(len(expected[-1]), len(expected[0]))
            command = [program(), "environment", process, "--configuration", configuration]
            address = self.listening([*command, "--listen", "127.0.0.1:0"])
            for environment in (address, stdio([*command, "--stdio"])):
                with self.subTest(process=process, environment=environment):
                    self.assertEqual(strings(name, *more, "--environment", environment), expected)

    def test_a_stand_with_its_light_and_its_soil_in_other_processes_is_the_same(self) -> None:
        entries = json.loads((GALLERY / "stand-year" / "stand-year.json").read_text(encoding="utf-8"))
        more = ["--seed", "1", "--steps", "130"]
        expected = strings("stand-year", *more)
        apart = []
        for entry in entries:
            file = self.write("one.json", json.dumps({key: entry[key] for key in entry if key != "name"}))
            address = self.listening([program(), "environment", entry["type"], "--configuration", file, "--listen",
                                      "127.0.0.1:0"])
            apart.append({"type": "tcp", "name": entry["name"], "address": address})
        self.assertEqual(strings("stand-year", *more, "--environment", self.write("apart.json", json.dumps(apart))),
                         expected)

    def test_an_offered_environment_gives_the_same_plant_to_several_simulations(self) -> None:
        expected = strings("branch-tiers")[-1]
        with Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "error"]) as server:
            offered = Process(python(EXAMPLES / "honda.py", "--radius", RADIUS, "--offer", server.address),
                              speaks_on="stderr")
            self.addCleanup(offered.stop)
            self.assertEqual(offered.first_line, f"environment 'honda' is offered to {server.address}")
            with server.connect(timeout=60) as client:
                environment = [{"type": "offered", "name": "honda"}]
                simulations = [client.create(gallery="branch-tiers", environment=environment) for _ in range(3)]
                for simulation in simulations:
                    simulation.step(4)
                for simulation in simulations:
                    self.assertTrue(simulation.step(4).finished)
                    self.assertEqual(simulation.string(), expected)

    def test_a_token_file_without_a_token_is_named(self) -> None:
        command = python(EXAMPLES / "ceiling.py", "--offer", "127.0.0.1:1", "--token-file", self.write("empty", "\n"))
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("empty' cannot be read, or its first line is empty. `espalier token new NAME -o FILE` makes one.", done.stderr)

    def test_the_environment_of_ten_lines_of_the_readme(self) -> None:
        source = (EXAMPLES / "ceiling.py").read_text(encoding="utf-8")
        self.assertLessEqual(len([line for line in source.splitlines() if line.strip()]), 10)
        self.assertIn(source.strip(), (PACKAGE / "README.md").read_text(encoding="utf-8"))
        stem = self.write("stem.l", "Lsystem: 1\nderivation length: 9\nAxiom: A?E(1)\n"
                                    "A > ?E(x) : x > 0 --> FA\nendlsystem\n")
        done = espalier("derive", stem, "--quiet", "--environment", stdio(python(EXAMPLES / "ceiling.py")))
        self.assertEqual(done.stdout.strip(), "FFFFFFA?E(0)")


# grows like honda, and ends without a word in the middle of the step it is told
MORTAL = """
    import os, sys
    sys.path.insert(0, {examples!r})
    from honda import Honda

    class Mortal(Honda):
        radius = 0.5

        def step(self, queries):
            if str(self.completed_steps) == os.environ.get("DIES_IN_STEP"):
                os._exit(9)
            return super().step(queries)

    Mortal.serve()
"""


class Failing(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.script = Path(folder.name) / "mortal.py"
        self.script.write_text(textwrap.dedent(MORTAL).format(examples=str(EXAMPLES)), encoding="utf-8")

    def offer(self, address: str, **more: str) -> Process:
        process = Process([sys.executable, str(self.script), "--offer", address], speaks_on="stderr", **more)
        self.addCleanup(process.stop)
        self.assertIn("is offered to", process.first_line)
        return process

    def test_killed_in_a_step_the_simulation_stays_and_goes_on_after_the_next_offer(self) -> None:
        expected = strings("branch-tiers")
        with Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"]) as server:
            first = self.offer(server.address, DIES_IN_STEP="4")
            with server.connect(timeout=60) as client:
                simulation = client.create(gallery="branch-tiers", environment=[{"type": "offered", "name": "mortal"}])
                with self.assertRaises(ServerError) as caught:
                    simulation.step(8)
                self.assertEqual(first.wait(), 9)
                self.assertEqual(caught.exception.code, 1006)
                self.assertTrue(caught.exception.is_retryable)
                # which environment, and what to do
                self.assertRegex(caught.exception.message, "'mortal'")
                self.assertRegex(caught.exception.message, "(?i)offer|again|start")
                self.assertEqual(simulation.get("string"), {"step": 4, "string": expected[4]})

                # while it is away the same error comes back and nothing changes
                with self.assertRaises(ServerError) as caught:
                    simulation.step()
                self.assertTrue(caught.exception.is_retryable)
                self.assertEqual(simulation.string(), expected[4])

                self.offer(server.address)
                self.assertEqual(simulation.step().step, 5)
                self.assertEqual(simulation.string(), expected[5])
                self.assertTrue(simulation.step(until=8).finished)
                self.assertEqual(simulation.string(), expected[8])

    def test_an_environment_that_is_not_offered_is_named(self) -> None:
        with Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"]) as server:
            with Client(server.address, timeout=60) as client, self.assertRaises(ServerError) as caught:
                client.create(gallery="light-tree", environment=[{"type": "offered", "name": "canopy"}]).step()
            self.assertIn("canopy", caught.exception.message)

    def test_the_command_line_names_the_environment_that_died(self) -> None:
        done = espalier("derive", model("branch-tiers"), "--environment", stdio([sys.executable, str(self.script)]),
                        status=1, DIES_IN_STEP="2")
        self.assertIn("mortal", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, re.compile("step 2", re.IGNORECASE))

    def test_a_mistake_in_a_python_environment_reaches_the_person(self) -> None:
        self.script.write_text("from espalier import Environment\n\n\nclass Broken(Environment):\n"
                               "    def answer(self, query):\n        return [1 / 0]\n\n\nBroken.serve()\n", encoding="utf-8")
        done = espalier("derive", model("branch-tiers"), "--environment", stdio([sys.executable, str(self.script)]), status=1)
        self.assertIn("ZeroDivisionError", done.stderr)
        self.assertIn("mortal.py:6", done.stderr)


if __name__ == "__main__":
    unittest.main()
