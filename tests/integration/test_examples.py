"""The examples of the Python package, run as their pages say, and what they are about."""

import csv
import importlib.util
import re
import subprocess
import sys
import tempfile
import types
import unittest
from pathlib import Path
from typing import Any, List
from unittest import mock

from support import EXAMPLES, SECONDS, program, variables

import espalier


def run(*arguments: str, status: int = 0) -> str:
    """Standard output of an example."""
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=SECONDS, check=False,
                          cwd=EXAMPLES, env=variables(ESPALIER_PROGRAM=program()), stdin=subprocess.DEVNULL)
    if done.returncode != status:
        raise AssertionError(f"{' '.join(arguments)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


class Examples(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
    def test_voxel_light_makes_two_trees_grow_away_from_each_other(self) -> None:
        centres = [float(value) for value in re.findall(r"centred ([-+.\d]+) m", run("voxel_light/voxel_light.py", "--steps", "8"))]
        alone, left, right = centres
        self.assertAlmostEqual(alone, 0.0, places=2)
        self.assertLess(left, -0.1)
        self.assertGreater(right, 0.1)

    def test_soil_bucket_stops_leaves_in_the_dry_spell(self) -> None:
        rows = [line.split() for line in run("soil_bucket/soil_bucket.py").splitlines()[1:]]
        satisfaction = {int(row[0]): float(row[3]) for row in rows}
        water = {int(row[0]): float(row[2]) for row in rows}
        self.assertEqual(satisfaction[49], 1.0)
        self.assertLess(satisfaction[84], 0.6)
        self.assertEqual(satisfaction[98], 1.0)
        self.assertTrue(all(0.0 <= value <= 60.0 for value in water.values()))

    def test_thermal_time_writes_a_series_for_every_leaf(self) -> None:
        run("thermal_time/thermal_time.py", "--series", str(self.folder / "leaves.csv"))
        with (self.folder / "leaves.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        areas: List[float] = []
        for number in range(1, 16):
            own = [row for row in rows if int(row["leaf"]) == number]
            grown = [float(row["area_cm2"]) for row in own]
            made = [float(row["assimilated_mg_CO2"]) for row in own]
            self.assertEqual(grown, sorted(grown))
            self.assertGreater(made[-1], 0.0)
            areas.append(grown[-1])
        self.assertEqual(areas.index(max(areas)) + 1, 9)
        self.assertLessEqual(max(areas), 120.0)

    def test_obstacle_world_keeps_its_distance(self) -> None:
        rows = [line.split() for line in run("obstacle_world/obstacle_world.py", "--steps", "5").splitlines()[1:]]
        self.assertEqual([int(row[0]) for row in rows], [1, 2, 3, 4, 5])
        shoots = [int(row[1]) for row in rows]
        self.assertEqual(shoots[:2], [2, 5])
        # without obstacles it would be three times as many each step and one
        self.assertLess(shoots[-1], 3 * shoots[-2] - 1)

    def test_obstacle_world_names_a_broken_face(self) -> None:
        broken = self.folder / "broken.obj"
        broken.write_text("v 0 0 0\nv 1 0 0\nf 1 2 3\n", encoding="utf-8")
        done = subprocess.run([sys.executable, "obstacle_world/obstacle_world.py", "--obstacles", str(broken), "--steps", "1"],
                              capture_output=True, text=True, timeout=SECONDS, check=False, cwd=EXAMPLES,
                              env=variables(ESPALIER_PROGRAM=program()))
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"{broken}:3: a face names a vertex that is not there", done.stderr)

    def test_pruning_robot_earns_more_than_an_idle_one(self) -> None:
        picture = self.folder / "trained.png"
        lines = run("pruning_robot/pruning_robot.py", "--seasons", "4", "--picture", str(picture)).splitlines()
        returns = {line.split(":")[0]: float(line.split("return ")[1].split(";")[0]) for line in lines}
        self.assertEqual(list(returns), ["idle", "careless", "trained"])
        self.assertGreater(returns["trained"], returns["idle"])
        self.assertLess(returns["careless"], returns["idle"])
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")

    def test_parameter_sweep_writes_a_table_and_a_plot(self) -> None:
        table, plot = self.folder / "sweep.csv", self.folder / "sweep.svg"
        said = run("parameter_sweep.py", "--angles", "3", "--radii", "4", "--table", str(table), "--plot", str(plot))
        self.assertIn("12 simulations", said)
        with table.open(newline="", encoding="utf-8") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
        self.assertEqual(len(rows), 12)
        self.assertIn("<polyline", plot.read_text(encoding="utf-8"))
        # the larger the clusters, the fewer find room
        for angle in {row["angle"] for row in rows}:
            clusters = [row["clusters"] for row in sorted(rows, key=lambda row: row["radius"]) if row["angle"] == angle]
            self.assertEqual(clusters, sorted(clusters, reverse=True))


def pruning_robot() -> types.ModuleType:
    """The example as a module."""
    specification = importlib.util.spec_from_file_location("pruning_robot", EXAMPLES / "pruning_robot" / "pruning_robot.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


class PruningRobot(unittest.TestCase):
    def setUp(self) -> None:
        self.robot = pruning_robot()
        self.client = espalier.local(program(), arguments=["--log-level", "off"])
        self.addCleanup(self.client.close)
        self.sky = self.client.attach(self.robot.Sky)

    def task(self, seasons: int) -> Any:
        return self.robot.PruningEnvironment(self.client, self.sky, seasons)

    def test_the_same_seed_and_actions_make_the_same_episode(self) -> None:
        episodes = []
        for _ in range(2):
            task = self.task(3)
            observation, info = task.reset(seed=5)
            self.assertEqual(info["seed"], 5)
            episode = [observation]
            for _ in range(3):
                episode.append(task.step(self.robot.trained(episode[-1] if len(episode) == 1 else episode[-1][0])))
            episodes.append(episode)
            task.close()
        self.assertEqual(episodes[0], episodes[1])
        self.assertEqual((len(observation), len(observation[0])), (self.robot.SHOOTS, self.robot.COLUMNS))

    def test_the_end_of_the_seasons_truncates_and_the_death_of_the_tree_terminates(self) -> None:
        task = self.task(2)
        task.reset(seed=1)
        nothing = [0] * self.robot.SHOOTS
        self.assertEqual(task.step(nothing)[2:4], (False, False))
        self.assertEqual(task.step(nothing)[2:4], (False, True))
        task.reset(seed=1)
        observation, reward, terminated, truncated, info = task.step([1] * self.robot.SHOOTS)
        self.assertEqual((terminated, truncated, info["buds"]), (True, False, 0))
        self.assertLess(reward, 0.0)
        self.assertEqual(set(observation), {(0.0,) * self.robot.COLUMNS})

    def test_a_cut_shoot_falls_with_all_that_it_carries(self) -> None:
        task = self.task(5)
        observation, info = task.reset(seed=1)
        first = [1] + [0] * (self.robot.SHOOTS - 1)
        carried = observation[0][3]
        self.assertGreater(carried, 1.0)
        before = info["buds"]
        task.simulation.prune(task._shown[0].module)
        self.assertEqual(len([record for record in task.simulation.turtle() if record.symbol == "E"]), before - carried)
        with self.assertRaisesRegex(RuntimeError, "reset"):
            self.task(1).step(first)

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
    def test_gives_gymnasium_arrays_and_spaces(self) -> None:
        # what the example uses of the package, which Debian does not have
        gymnasium = types.ModuleType("gymnasium")
        gymnasium.Env = type("Env", (), {"reset": lambda self, seed=None: None})  # type: ignore[attr-defined]
        gymnasium.spaces = types.SimpleNamespace(  # type: ignore[attr-defined]
            Box=lambda low, high, shape, dtype: shape, MultiBinary=lambda count: count)
        with mock.patch.dict(sys.modules, {"gymnasium": gymnasium}):
            robot = pruning_robot()
        wrapped = robot.PruningEnv(self.client, self.sky, 1)
        observation, info = wrapped.reset(seed=3)
        self.assertEqual((observation.shape, info["seed"]), (wrapped.observation_space, 3))
        observation, reward, terminated, truncated, info = wrapped.step(observation[:, 0] > 9.0)
        self.assertEqual((observation.shape, terminated, truncated, info["cuts"]), (wrapped.observation_space, False, True, 0))
        wrapped.close()

    @unittest.skipUnless(importlib.util.find_spec("gymnasium") and importlib.util.find_spec("numpy"), "gymnasium is not installed")
    def test_is_an_environment_of_gymnasium(self) -> None:
        from gymnasium.utils.env_checker import check_env  # type: ignore[import]

        check_env(self.robot.PruningEnv(self.client, self.sky, 2), skip_render_check=True)


class LocalServer(unittest.TestCase):
    def test_runs_an_environment_of_the_same_program(self) -> None:
        script = ("import espalier\n"
                  "class Ceiling(espalier.Environment):\n"
                  "    def answer(self, query):\n"
                  "        return [1 if query.position[1] < 3 else 0]\n"
                  "with espalier.local() as client:\n"
                  "    plant = client.create('Lsystem: 1\\nderivation length: 6\\nAxiom: A?E(1)\\n'\n"
                  "                          'A?E(x) : x > 0 --> FA?E(1)\\nendlsystem\\n', environment=[client.attach(Ceiling)])\n"
                  "    plant.step(6)\n"
                  "    print(plant.string())\n")
        self.assertEqual(run("-c", script).strip(), "FFFA?E(0)")

    def test_an_environment_that_ends_its_thread_fails_the_call_at_once(self) -> None:
        script = ("import espalier\n"
                  "class Leaver(espalier.Environment):\n"
                  "    def answer(self, query):\n"
                  "        raise SystemExit\n"
                  "with espalier.local(timeout=20) as client:\n"
                  "    plant = client.create('Lsystem: 1\\nderivation length: 6\\nAxiom: A?E(1)\\nA --> A\\nendlsystem\\n',\n"
                  "                          environment=[client.attach(Leaver)])\n"
                  "    try:\n"
                  "        plant.step()\n"
                  "    except espalier.ServerError as error:\n"
                  "        print(error.code, error.is_retryable)\n")
        self.assertEqual(run("-c", script).strip(), "1006 True")

    def test_says_what_to_do_without_a_program(self) -> None:
        done = subprocess.run([sys.executable, "-c", "import espalier; espalier.local()"], capture_output=True, text=True,
                              timeout=SECONDS, check=False, cwd="/",
                              env={**variables(), "PATH": "/nowhere", "ESPALIER_PROGRAM": str(self.id())})
        self.assertEqual(done.returncode, 1)
        self.assertIn("There is no program", done.stderr)


if __name__ == "__main__":
    unittest.main()
