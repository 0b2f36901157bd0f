"""The Python client against the real server: models, streams, snapshots, errors."""

import contextlib
import re
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import List

import point_files
from support import GALLERY, PACKAGE, SECONDS, espalier, program, strings, variables

from espalier import Client, ConnectionLost, EspalierError, Frame, ModelWarning, Server, ServerError


class ClientAndServer(unittest.TestCase):
    def setUp(self) -> None:
        server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"])
        self.addCleanup(server.stop)
        self.client = server.connect(timeout=60)
        self.addCleanup(self.client.close)
        self.server = server

    def test_checks_and_loads_models(self) -> None:
        wrong = self.client.check("Lsystem: 1\nAxiom: A\nA --> B(\nendlsystem\n")
        self.assertFalse(wrong.valid)
        self.assertTrue(wrong.diagnostics)
        right = self.client.load(gallery="classic-algae")
        self.assertTrue(right.valid)
        simulation = self.client.create(loaded=right.model)
        simulation.step(8)
        self.assertEqual(simulation.string(), strings("classic-algae")[-1])

    def test_a_model_with_errors_is_refused_with_all_of_them(self) -> None:
        with self.assertRaises(ServerError) as caught:
            self.client.create("Lsystem: 1\nAxiom: A\nA --> B(\nendlsystem\n")
        self.assertEqual(caught.exception.code, 1009)
        self.assertTrue(caught.exception.diagnostics)

    def test_warnings_about_a_model_are_shown_where_it_is_created(self) -> None:
        with self.assertWarnsRegex(ModelWarning, "model.l:3:9: warning: unknown name 'y'") as seen:
            self.client.create("Lsystem: 1\nAxiom: A\nA --> A(y)\nendlsystem\n")
        self.assertEqual(Path(seen.filename).name, Path(__file__).name)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.client.create("Lsystem: 1\nAxiom: A\nA --> AA\nendlsystem\n")

    def test_a_closed_client_says_that_it_is_closed(self) -> None:
        with Client(self.server.address) as client:
            simulation = client.create(gallery="classic-algae")
        with self.assertRaisesRegex(ConnectionLost, r"is closed on this side: close\(\) was called"):
            simulation.step()

    def test_a_gallery_model_brings_its_own_environment(self) -> None:
        simulation = self.client.create(gallery="branch-tiers")
        self.assertTrue(simulation.step(8).finished)
        self.assertEqual(simulation.string(), strings("branch-tiers")[-1])

    def test_the_shell_sends_a_model_folder_with_its_environment(self) -> None:
        address = self.server.address
        simulation = espalier("connect", address, "create", str(GALLERY / "branch-tiers")).stdout.strip()
        espalier("connect", address, "run", simulation)
        self.assertEqual(espalier("connect", address, "get", simulation, "string").stdout.strip(),
                         strings("branch-tiers")[-1])

    def test_the_shell_sends_every_environment_of_the_gallery_that_is_json(self) -> None:
        # a first step: the environment was read, with the files that it names
        folders = [folder for folder in sorted(GALLERY.iterdir()) if (folder / f"{folder.name}.json").exists()]
        self.assertGreater(len(folders), 10)
        for folder in folders:
            with self.subTest(folder.name):
                made = espalier("connect", self.server.address, "create", str(folder), "--seed", "1")
                simulation = self.client.simulation(made.stdout.strip())
                self.assertNotEqual(simulation.get("information")["information"]["environment"], [])
                simulation.step()
                simulation.delete()

    def test_the_shell_sends_the_world_of_a_folder_with_its_weather(self) -> None:
        for name in ("wilting-plant", "sun-and-shade"):
            folder = str(GALLERY / name)
            simulation = espalier("connect", self.server.address, "create", folder, "--seed", "1").stdout.strip()
            self.client.simulation(simulation).step(3)
            self.assertEqual(espalier("connect", self.server.address, "get", simulation, "string").stdout.strip(),
                             espalier("derive", folder, "--seed", "1", "--steps", "3").stdout.strip())

    def test_the_shell_sends_the_files_that_a_configuration_names(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            model, cloud = Path(folder, "seeker.l"), Path(folder, "cloud.ply")
            model.write_text("Lsystem: 1\nderivation length: 1\nAxiom: ?E(1,0,0,0,0)\nendlsystem\n")
            cloud.write_bytes(point_files.ply([(0, 0, 2)]))
            file = Path(folder, "points.json")
            file.write_text('{"type":"attractors",\n"pointFile":"cloud.ply"}')
            command = ["connect", self.server.address, "create", str(model), "--environment", str(file)]
            self.assertTrue(espalier(*command).stdout.startswith("sim-"))
            cloud.unlink()
            self.assertIn("cloud.ply", espalier(*command, status=2).stderr)

    def test_the_shell_sends_what_a_model_reads_with_fopen(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "lengths.txt").write_text("2 5\n")
            model = Path(folder, "reading.l")
            model.write_text('Lsystem: 1\nderivation length: 1\nStart: {f = fopen("lengths.txt", "r");'
                             ' fscanf(f, "%g %g", &a, &b);}\nAxiom: F(a)F(b)\nx --> x\nendlsystem\n')
            address = self.server.address
            simulation = espalier("connect", address, "create", str(model)).stdout.strip()
            self.assertEqual(espalier("connect", address, "get", simulation, "string").stdout.strip(), "F(2)F(5)")

    def test_streams_a_frame_for_every_step(self) -> None:
        simulation = self.client.create(gallery="growth-to-a-height", environment=[{"type": "height"}])
        seen = []
        with self.server.connect(timeout=60) as viewer:
            with viewer.simulation(simulation.identifier).stream("turtle") as stream:
                seen.append(stream.read(60))
                for made in simulation.steps():
                    seen.append(stream.read(60))
                    self.assertEqual(seen[-1].step, made.step)
        self.assertEqual([frame.step for frame in seen], [0, 1, 2, 3])
        self.assertTrue(seen[-1].finished)
        self.assertEqual(max(record.position[1] for record in seen[-1].records), 2.0)
        self.assertEqual(sum(frame.missed for frame in seen), 0)

    def test_a_snapshot_continues_as_if_nothing_had_happened(self) -> None:
        simulation = self.client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}])
        simulation.step(3)
        snapshot = simulation.save()
        simulation.step(5)
        last = simulation.string()
        self.assertEqual(last, strings("branch-tiers")[-1])
        simulation.restore(snapshot)
        self.assertEqual(simulation.get("information")["information"]["step"], 3)
        simulation.step(5)
        self.assertEqual(simulation.string(), last)

    def test_the_program_draws_a_snapshot_of_the_server(self) -> None:
        simulation = self.client.create(gallery="classic-weed")
        simulation.step(4)
        with tempfile.TemporaryDirectory() as folder:
            snapshot, picture = Path(folder) / "weed.snapshot", Path(folder) / "weed.svg"
            simulation.save_to(snapshot)
            espalier("run", "--resume", str(snapshot), "-o", str(picture), "--quiet")
            self.assertIn("<svg", picture.read_text(encoding="utf-8"))

    def test_a_snapshot_is_not_written_under_the_name_of_a_drawing(self) -> None:
        simulation = self.client.create(gallery="classic-weed")
        with tempfile.TemporaryDirectory() as folder:
            for name, way in (("weed.png", "espalier run --resume weed.snapshot -o weed.png"), ("weed.OBJ", "-o weed.OBJ"),
                              ("weed.glb", "Path('weed.glb').write_bytes(plant.geometry())"),
                              ("weed.html", "view().save('weed.html')")):
                with self.assertRaises(ValueError) as caught:
                    simulation.save_to(Path(folder) / name)
                self.assertIn(f"save_to() writes a snapshot, and '{name}' is the name of another kind of file.", str(caught.exception))
                self.assertIn(way, str(caught.exception))
            self.assertEqual(list(Path(folder).iterdir()), [])

    def test_the_client_example_of_the_package_works_as_written(self) -> None:
        page = (PACKAGE / "README.md").read_text(encoding="utf-8")
        example = page.split("## A client")[1].split("```python\n")[1].split("```")[0]
        command = re.search(r"# espalier (run --resume .*)", example)
        assert command is not None
        example = example.replace("build/release/bin/espalier", program()).replace("clients/gallery", str(GALLERY))
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-c", example], cwd=folder, env=variables(), check=True, timeout=SECONDS,
                           stdout=subprocess.DEVNULL)
            subprocess.run([program(), *command.group(1).split()], cwd=folder, check=True, timeout=SECONDS,
                           stderr=subprocess.DEVNULL)
            self.assertIn("<svg", (Path(folder) / "tiers.svg").read_text(encoding="utf-8"))

    def test_the_asyncio_example_of_the_package_works_as_written(self) -> None:
        page = (PACKAGE / "README.md").read_text(encoding="utf-8")
        example = page.split("The same for asyncio")[1].split("```python\n")[1].split("```")[0]
        said = subprocess.run([sys.executable, "-c", example.replace("127.0.0.1:4321", self.server.address)],
                              env=variables(), check=True, timeout=SECONDS, stdout=subprocess.PIPE, text=True).stdout
        self.assertRegex(said.splitlines()[0], r"^0 \d+ \(\d+, 3\)$")
        self.assertEqual(said.splitlines()[-1].split()[0], str(len(strings("branch-tiers")) - 1))

    def test_streams_what_the_program_exports(self) -> None:
        weed = self.client.create(gallery="classic-weed")
        with weed.stream("geometry", arrays=True, credits=1) as stream:
            stream.read()
            weed.step(2)
            frame = stream.read()
            while frame.step < 2:
                frame = stream.read()
        with tempfile.TemporaryDirectory() as folder:
            snapshot, exported = Path(folder) / "weed.snapshot", Path(folder) / "weed.glb"
            weed.save_to(snapshot)
            espalier("export", str(snapshot), "-o", str(exported), "--instancing", "--quiet")
            self.assertEqual(bytes(frame.columns["glb"]), exported.read_bytes())
        self.assertEqual(weed.geometry(), bytes(frame.columns["glb"]))
        with self.assertRaisesRegex(ServerError, r'params.bin: geometry as a file comes in binary blocks; say "bin": true, '
                                    r'or "format": "columns" for tables'):
            weed.stream("geometry")
        self.assertIn("classic-weed", self.client.gallery())

    def test_edits_and_forks(self) -> None:
        weed = self.client.create(gallery="classic-weed")
        weed.insert(0, ["[", "+", "F", "]"])
        other = weed.fork("pruned")
        other.prune(0)
        self.assertEqual((weed.string(), other.string()), ("[+F]F", "F"))
        weed.replace(4, ["F", "F"])
        self.assertEqual(weed.string(), "[+F]FF")
        with self.assertRaisesRegex(EspalierError, r"3 is not a module. Write its symbol and then its parameters"):
            weed.insert(0, [3])  # type: ignore[list-item]
        with self.assertRaisesRegex(EspalierError, "not a module"):
            weed.insert(0, [()])
        with self.assertRaisesRegex(EspalierError, r"either a snapshot .* or checkpoint="):
            weed.restore()

    def test_keeps_checkpoints_on_the_servers_disk(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off", "--data", folder])
            self.addCleanup(server.stop)
            with server.connect(timeout=60) as client:
                algae = client.create(gallery="classic-algae")
                algae.checkpoint("start")
                algae.step(3)
                self.assertEqual([item["checkpoint"] for item in algae.checkpoints()], ["start"])
                algae.restore(checkpoint="start")
                self.assertEqual(algae.string(), "a")
            server.stop()

    def test_run_reports_its_progress_and_what_that_raises_ends_it(self) -> None:
        algae = self.client.create(gallery="classic-algae", derivation_length=12)
        seen: List[int] = []
        self.assertEqual(algae.run(lambda frame: seen.append(frame.step)).step, 12)
        self.assertEqual((seen, seen[-1]), (sorted(set(seen)), 12))
        self.assertEqual([made.step for made in algae.history], seen[1:])
        self.assertEqual(algae.history[-1].statistics["modules"], 377)
        with contextlib.suppress(ModuleNotFoundError):
            import matplotlib  # type: ignore[import]

            matplotlib.use("Agg")
            lines = algae.plot("modules", "queries").get_lines()
            self.assertEqual([list(line.get_xdata()) for line in lines], [seen[1:], seen[1:]])
            self.assertEqual(lines[0].get_ydata()[-1], 377)
        endless = self.client.create("Lsystem: 1\nderivation length: 1000000\nAxiom: A\nA --> A\nendlsystem\n", save=False)

        def stop(frame: Frame) -> None:
            if frame.step > 2:
                raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            endless.run(stop)
        # a step behind an endless run would wait for ever
        self.assertGreater(endless.step().step, 3)
        self.assertEqual(endless.pause(), 0)

    def test_a_snapshot_of_the_server_says_how_its_environment_was_set_up(self) -> None:
        last = strings("branch-tiers")
        for environment in (None, [{"type": "honda", "radius": 0.5}],
                            [{"type": "height", "name": "E"}, {"type": "honda"}]):
            simulation = self.client.create(gallery="branch-tiers", environment=environment, seed=7)
            simulation.step(2)
            with tempfile.TemporaryDirectory() as folder:
                snapshot, later = Path(folder) / "a.snapshot", Path(folder) / "b.snapshot"
                simulation.save_to(snapshot)
                espalier("run", "--resume", str(snapshot), "-o", str(later), "--quiet")
                simulation.step(len(last))
                state = simulation.get("state-hash")["stateHash"]
                simulation.restore(later.read_bytes())
                self.assertEqual(simulation.get("state-hash")["stateHash"], state)

    def test_a_deleted_simulation_is_gone(self) -> None:
        simulation = self.client.create(gallery="classic-algae")
        self.assertEqual([item["simulation"] for item in self.client.simulations()], [simulation.identifier])
        simulation.reset()
        simulation.delete()
        self.assertEqual(self.client.simulations(), [])
        with self.assertRaises(ServerError) as caught:
            simulation.step()
        self.assertEqual(caught.exception.code, 1011)

    def test_says_what_it_has(self) -> None:
        self.assertIn("honda", [process["name"] for process in self.client.environments()])
        self.assertIn("server", self.client.status())

    def test_the_server_ends_cleanly(self) -> None:
        self.assertEqual(self.server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
