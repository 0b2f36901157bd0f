"""A robot trains a tree flat against a wall: a task for reinforcement learning in the manner of Gymnasium.

    python3 clients/python/examples/pruning_robot/pruning_robot.py --picture trained.png

Every season the robot sees the largest shoots and decides which to cut; then the tree grows for a season. Cutting opens the crown for
light, and shoots outside the bed have a cost. With the package gymnasium, `PruningEnv` is a `gymnasium.Env`.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
from math import exp, floor
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from espalier import Answer, Client, Environment, Query, Simulation, TurtleRecord, Variable, local  # noqa: E402

Row = Tuple[float, ...]
Observation = Tuple[Row, ...]
Action = Sequence[int]  # for each row of the observation: 1 cuts the shoot, 0 leaves it

SHOOTS = 32  # rows of an observation
FILES = {name: (HERE / name).read_text(encoding="utf-8") for name in ("plant.l", "plant.v")}
COLUMNS = 6  # of a row: x, y, z of the shoot's end (m), buds that it carries, their light from 0 to 1, branch order


class Sky(Environment):
    """Answers the light at a bud, from 0 to 1: every bud above, in a column of air 0.5 m wide, takes a part of it."""

    needs = ("position",)
    outputs = (Variable("light"),)
    column = 0.5
    extinction = 0.3

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        columns: Dict[Tuple[int, int], List[float]] = {}
        places = [(floor(query.position[0] / self.column), floor(query.position[2] / self.column)) for query in queries]
        for place, query in zip(places, queries):
            columns.setdefault(place, []).append(query.position[1])
        return [[exp(-self.extinction * sum(height > query.position[1] for height in columns[place]))]
                for place, query in zip(places, queries)]


class Shoot:
    """A shoot that can be cut: where it ends and what it carries."""

    def __init__(self, record: TurtleRecord) -> None:
        self.module = record.module
        self.position = record.position
        self.order = record.branch_order
        self.light: List[float] = []  # of each bud that it carries

    def row(self) -> Row:
        mean = sum(self.light) / len(self.light) if self.light else 0.0
        return (*self.position, float(len(self.light)), mean, float(self.order))


def shoots_of(records: Sequence[TurtleRecord]) -> List[Shoot]:
    """All shoots but the trunk, in the order of the string, with the light of the buds that each carries."""
    shoots: Dict[int, Shoot] = {}
    for record in records:
        if record.symbol == "F" and record.parent is not None:
            shoots[record.index] = Shoot(record)
    for record in records:
        if record.symbol == "E":
            below = record.parent
            while below is not None:
                if below in shoots:
                    shoots[below].light.append(record.parameters[0])
                below = records[below].parent
    return list(shoots.values())


class PruningEnvironment:
    """reset(seed) and step(action) as Gymnasium has them, without Gymnasium.

    An observation has SHOOTS rows of COLUMNS numbers: the shoots that carry most buds, the greatest first; rows beyond the
    last shoot are zero. The reward of a season is the light of all buds in the bed before the wall, less `outside_cost` for
    each bud that sticks out of it and `cut_cost` for each cut. An episode is terminated when no bud is left alive, and
    truncated after `seasons`.
    """

    bed = 0.5  # half the depth of the bed, m: what is farther from the plane z = 0 sticks out
    outside_cost = 0.5
    cut_cost = 0.2

    def __init__(self, client: Client, sky: Dict[str, str], seasons: int = 6) -> None:
        """`sky` is what attach(Sky) returned."""
        self._client = client
        self._sky = sky
        self._seasons = seasons
        self._shown: List[Shoot] = []
        self.simulation: Optional[Simulation] = None

    def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> Tuple[Observation, Dict[str, Any]]:
        """A new tree, two seasons old; the seed is used here and nowhere else. Returns observation and info."""
        self.close()
        self._season = 0
        self.simulation = self._client.create(files=FILES, main="plant.l", environment=[self._sky], seed=seed, save=False)
        self.simulation.step(2)
        observation, buds = self._look()
        return observation, {"buds": len(buds), "seed": self.simulation.created["seed"]}

    def step(self, action: Action) -> Tuple[Observation, float, bool, bool, Dict[str, Any]]:
        """Cuts, then one season. Returns observation, reward, terminated, truncated, info."""
        if self.simulation is None:
            raise RuntimeError("Call reset() before step().")
        chosen = [shoot for shoot, cut in zip(self._shown, action) if cut]
        cuts = 0
        # from the end of the string to its beginning, so that the indices before stay right; a shoot that was carried by
        # another one of the chosen falls with it
        for shoot in sorted(chosen, key=lambda item: item.module, reverse=True):
            self.simulation.prune(shoot.module)
            cuts += 1
        self.simulation.step()
        self._season += 1
        observation, buds = self._look()
        inside = [light for position, light in buds if abs(position[2]) <= self.bed]
        outside = len(buds) - len(inside)
        reward = sum(inside) - self.outside_cost * outside - self.cut_cost * cuts
        terminated = not buds
        truncated = not terminated and self._season >= self._seasons
        return observation, reward, terminated, truncated, {"buds": len(buds), "outside": outside, "cuts": cuts}

    def close(self) -> None:
        """Removes the tree from the server."""
        if self.simulation is not None:
            self.simulation.delete()
            self.simulation = None

    def _look(self) -> Tuple[Observation, List[Tuple[Tuple[float, float, float], float]]]:
        """The observation now, and position and light of every bud."""
        assert self.simulation is not None
        records = self.simulation.turtle()
        found = sorted(shoots_of(records), key=lambda shoot: -len(shoot.light))
        self._shown = found[:SHOOTS]
        rows = [shoot.row() for shoot in self._shown]
        rows += [(0.0,) * COLUMNS] * (SHOOTS - len(rows))
        return tuple(rows), [(record.position, record.parameters[0]) for record in records if record.symbol == "E"]


try:
    import gymnasium
    import numpy
except ImportError:
    pass
else:
    class PruningEnv(gymnasium.Env):  # type: ignore[misc]
        """The same as a gymnasium.Env, with a server of its own unless it is given a client."""

        metadata: Dict[str, Any] = {"render_modes": []}

        def __init__(self, client: Optional[Client] = None, sky: Optional[Dict[str, str]] = None, seasons: int = 6) -> None:
            self._own = None if client is not None else local()
            used = client or self._own
            assert used is not None
            self._task = PruningEnvironment(used, sky or used.attach(Sky), seasons)  # type: ignore[attr-defined]
            self.observation_space = gymnasium.spaces.Box(-numpy.inf, numpy.inf, (SHOOTS, COLUMNS), numpy.float64)
            self.action_space = gymnasium.spaces.MultiBinary(SHOOTS)

        def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> Tuple[Any, Dict[str, Any]]:
            super().reset(seed=seed)
            observation, info = self._task.reset(seed=seed, options=options)
            return numpy.array(observation), info

        def step(self, action: Any) -> Tuple[Any, float, bool, bool, Dict[str, Any]]:
            observation, *rest = self._task.step(action)
            return (numpy.array(observation), *rest)

        def close(self) -> None:
            self._task.close()
            if self._own is not None:
                self._own.close()


# ---- three gardeners ------------------------------------------------------------------------------------------------


def idle(observation: Observation) -> Action:
    """Cuts nothing."""
    return [0] * len(observation)


def careless(chance: random.Random) -> Callable[[Observation], Action]:
    """Cuts one shoot in five, whichever."""
    return lambda observation: [int(chance.random() < 0.2) for _ in observation]


def trained(observation: Observation) -> Action:
    """Cuts side shoots that leave the middle half of the bed: what they would carry next season sticks out."""
    return [int(abs(z) > 0.5 * PruningEnvironment.bed and order > 0) for _, _, z, _, _, order in observation]


def play(task: PruningEnvironment, gardener: Callable[[Observation], Action], seed: int) -> Tuple[float, Dict[str, Any]]:
    """One episode: the sum of its rewards and the last info."""
    observation, info = task.reset(seed=seed)
    total, terminated, truncated = 0.0, False, False
    while not (terminated or truncated):
        observation, reward, terminated, truncated, info = task.step(gardener(observation))
        total += reward
    return total, {**info, "terminated": terminated}


def draw(simulation: Simulation, path: Path) -> None:
    """A picture of the tree as it is."""
    from espalier.local_server import find_program

    snapshot = path.with_suffix(".snapshot")
    simulation.save_to(snapshot)
    done = subprocess.run([find_program(), "export", str(snapshot), "--quiet", "--size", "460x600", "--colours", "48", "-o",
                           str(path)], check=False)
    snapshot.unlink()
    if done.returncode != 0:
        sys.exit("pruning_robot: the picture could not be drawn (the reason is above).")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seasons", type=int, default=6, help="(default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="(default: %(default)s)")
    parser.add_argument("--picture", type=Path, help="draw a tree: .png, .svg, .glb")
    parser.add_argument("--gardener", default="trained", help="whose tree to draw: idle, careless, trained (default: %(default)s)")
    options = parser.parse_args()
    with local() as client:
        task = PruningEnvironment(client, client.attach(Sky), options.seasons)
        gardeners = {"idle": idle, "careless": careless(random.Random(options.seed)), "trained": trained}
        for name, gardener in gardeners.items():
            total, info = play(task, gardener, options.seed)
            end = "no bud is left" if info["terminated"] else f"{info['buds']} buds in the end, {info['outside']} outside the bed"
            print(f"{name}: return {total:.1f}; {end}")
            if name == options.gardener and options.picture and task.simulation:
                draw(task.simulation, options.picture)
        task.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
