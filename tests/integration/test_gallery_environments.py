"""Gallery models that grow against an environment: their tables, and what they are there to show."""

import contextlib
import csv
import json
import math
import os
import re
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

from support import GALLERY, espalier, model, program, strings


def table(name: str, symbols: Sequence[str]) -> Dict[int, List[int]]:
    """The file golden.tsv of a model: numbers of modules of each symbol, by step."""
    lines = (GALLERY / name / "golden.tsv").read_text(encoding="utf-8").splitlines()
    assert lines[0].split("\t") == ["step", *symbols], lines[0]
    return {int(row[0]): [int(count) for count in row[1:]] for row in (line.split("\t") for line in lines[1:])}


def places(string: str) -> List[Tuple[float, ...]]:
    """The answers of the modules ?P in a string."""
    return [tuple(map(float, numbers.split(","))) for numbers in re.findall(r"\?P\(([^)]*)\)", string)]


def answered_at(name: str, step: int) -> str:
    """The string of a step with its answers filled in."""
    lines = espalier("derive", model(name), "--every", "--answered", "--quiet", "--steps", str(step + 1)).stdout.splitlines()
    return lines[step].split("\t")[1]


def answered_at_seed(name: str, step: int, seed: str = "1") -> str:
    """The same, with a seed."""
    lines = espalier("derive", model(name), "--every", "--answered", "--quiet", "--seed", seed, "--steps",
                     str(step + 1)).stdout.splitlines()
    return lines[step].split("\t")[1]


def answered(name: str) -> str:
    """The last string of a run with its answers filled in."""
    return espalier("derive", model(name), "--every", "--answered", "--quiet").stdout.splitlines()[-1].split("\t")[1]


def derived_by(threads: int, name: str, steps: int) -> Tuple[str, int]:
    """The last string of a run, and the most threads that its process had at a time."""
    with subprocess.Popen([program(), "derive", model(name), "--quiet", "--steps", str(steps), "--threads", str(threads)],
                          stdout=subprocess.PIPE, text=True) as process:
        most = 0
        while process.poll() is None:
            with contextlib.suppress(OSError):
                most = max(most, len(os.listdir(f"/proc/{process.pid}/task")))
            time.sleep(0.001)
        assert process.stdout is not None
        return process.stdout.read(), most


class GalleryEnvironments(unittest.TestCase):
    @unittest.skipUnless(Path("/proc/self/task").exists(), "/proc is not mounted")
    def test_rays_of_light_are_traced_by_the_threads_of_the_command_line(self) -> None:
        alone, threads = derived_by(1, "stand-year", 30)
        together, more_threads = derived_by(3, "stand-year", 30)
        self.assertGreater(more_threads, threads)
        self.assertEqual(together, alone)

    def check_table(self, name: str, symbols: str) -> List[str]:
        derived = strings(name)
        for step, expected in table(name, symbols).items():
            self.assertEqual([derived[step].count(symbol) for symbol in symbols], expected, f"{name}, step {step}")
        return derived

    def test_borchert_honda_shares_the_flux_and_forks_only_above_the_threshold(self) -> None:
        derived = self.check_table("borchert-honda", "IA")
        nodes = 0
        for string in derived[::10]:
            # a fork: a segment, a minor branch in brackets, a major one; fluxes of one year when the message has passed
            for parent, minor, major in re.findall(
                    r"I\(\d,0,([-\d.e]+),\d+\)/\(180\)\[-\(32\)I\(2,1,([-\d.e]+),\d+\)"
                    r"[^]]*\]\+\(10\)I\(1,1,([-\d.e]+),\d+\)", string):
                self.assertAlmostEqual(float(minor) + float(major), float(parent), 9)
                nodes += 1
        self.assertGreater(nodes, 0)
        # tips never get fewer, and the growth of the flux slows down
        tips = [string.count("A") for string in derived]
        self.assertEqual(tips, sorted(tips))
        self.assertLess(tips[240] - tips[180], tips[120] - tips[60] + 1)

    def test_topiary_stays_in_its_box_and_fills_it(self) -> None:
        derived = self.check_table("topiary", "FAB")
        for step in (10, 50, 100, 150):
            filled = espalier("derive", model("topiary"), "--every", "--answered", "--quiet", "--steps",
                              str(step + 1)).stdout.splitlines()[step].split("\t")[1]
            # an apex may be one segment outside, for the step before it is cut
            for x, y in places(filled):
                self.assertLessEqual(max(abs(x), abs(y)), 2.6 + 1.0)
        segments = [string.count("F") for string in derived]
        self.assertGreater(segments[150], 3 * segments[10])

    def test_clonal_plants_forage_where_there_is_light(self) -> None:
        self.check_table("clonal-foraging", "FAGD")
        lines = (GALLERY / "clonal-foraging" / "patches.pnm").read_text(encoding="utf-8").splitlines()[4:]
        patches = [[int(number) for number in line.split()[1::3]] for line in lines][::-1]

        def light(x: float, y: float) -> Optional[int]:
            inside = -80 <= x < 80 and -80 <= y < 80
            return patches[int((y + 80) // 20)][int((x + 80) // 20)] if inside else None

        ramets = [light(*place) for place in places(answered("clonal-foraging"))]
        area = {value: sum(row.count(value) for row in patches) for value in (230, 90, 15)}
        density = {value: ramets.count(value) / area[value] for value in area}
        self.assertGreater(density[230], density[90])
        self.assertGreater(density[90], density[15])

    def test_the_vine_climbs_at_its_distance_from_the_boulder_and_the_ground(self) -> None:
        self.check_table("climbing", "FAL")
        points = places(answered("climbing"))
        self.assertGreater(len(points), 50)
        distances = [min((x * x + (y - 1) ** 2 + z * z) ** 0.5 - 1.5, y) for x, y, z in points]
        # in the crease between boulder and ground the distance is kept from one of them only
        self.assertGreater(min(distances), 0.0)
        self.assertLess(max(distances), 0.1 + 1e-5)
        self.assertGreater(sum(distance > 0.1 - 1e-5 for distance in distances), 0.9 * len(distances))
        # it starts on the ground and comes up over the boulder
        self.assertGreater(max(y for _, y, _ in points), 1.5)

    def tips_of(self, name: str, symbol: str, *more: str) -> List[Tuple[float, ...]]:
        """Places and headings of the modules of a symbol in the last string."""
        with tempfile.TemporaryDirectory() as folder:
            table_file = Path(folder) / "tips.csv"
            espalier("run", model(name), "-o", str(table_file), *more)
            rows = csv.DictReader(table_file.read_text(encoding="utf-8").splitlines())
            return [tuple(float(row[key]) for key in ("x", "y", "z", "hx", "hy", "hz"))
                    for row in rows if row["symbol"] == symbol]

    def test_a_pattern_keeps_away_from_its_source_and_gathers_at_its_sink(self) -> None:
        self.check_table("density-pattern", "FAB")
        # x to the right: the axis is y, and a turn by 72 to the right
        source, sink = (0.0, 7.0), (8 * math.sin(math.radians(72)), 8 * math.cos(math.radians(72)))
        tips = [place for symbol in "AB" for place in self.tips_of("density-pattern", symbol)]
        self.assertGreater(len(tips), 50)
        to_source = [math.hypot(x - source[0], y - source[1]) for x, y, *_ in tips]
        to_sink = [math.hypot(x - sink[0], y - sink[1]) for x, y, *_ in tips]
        self.assertGreater(min(to_source), 2.0)
        self.assertLess(min(to_sink), 1.0)
        # all in the plane, and those that grow have room
        self.assertEqual({z for _, _, z, *_ in tips}, {0.0})
        growing = [place[:2] for place in self.tips_of("density-pattern", "A")]
        nearest = [min(math.dist(one, other) for other in growing if other is not one) for one in growing]
        self.assertGreater(sorted(nearest)[len(nearest) // 2], 0.3)

    def test_a_tree_leans_to_leeward_the_more_the_higher_and_to_the_light(self) -> None:
        self.counted("windswept-tree", {"F(": "F(", "A(": "A(", "?Wind(": "?Wind("})
        configuration = (GALLERY / "windswept-tree" / "windswept-tree.json").read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            def tips(name: str, words: str, instead: str) -> List[Tuple[float, ...]]:
                self.assertIn(words, configuration)
                path = Path(folder) / f"{name}.json"
                path.write_text(configuration.replace(words, instead), encoding="utf-8")
                return self.tips_of("windswept-tree", "A", "--environment", str(path))

            windy = tips("windy", "[", "[")
            still = tips("still", '"speed": 9', '"speed": 0')
            dark = tips("dark", "[2, 6, 6, 1]", "[2, 6, 6, 0]")

        def mean(values: Sequence[float]) -> float:
            return sum(values) / len(values)

        # leeward is +x: places and headings; to the light is +z
        self.assertGreater(mean([tip[0] for tip in windy]), mean([tip[0] for tip in still]) + 0.3)
        self.assertGreater(mean([tip[3] for tip in windy]), mean([tip[3] for tip in still]) + 0.2)
        self.assertGreater(mean([tip[5] for tip in windy]), mean([tip[5] for tip in dark]) + 0.05)
        # near the ground it is calm: the air moves faster where the shoots are higher
        winds = re.findall(r"A\(([-\d.,e]+)\)\?H\([^)]*\)\?Wind\(([-\d.e]+),0,0\)", answered_at("windswept-tree", 6))
        self.assertGreater(len(winds), 500)
        self.assertGreater(max(float(speed) for _, speed in winds), 1.2 * min(float(speed) for _, speed in winds))

    def test_roots_keep_out_of_stones_and_gather_in_wet_ground(self) -> None:
        self.counted("roots-and-stones", {"I": "I(", "T": "T(", "D": "D("}, "4")

        def map_of(component: int) -> List[List[int]]:
            lines = (GALLERY / "roots-and-stones" / "ground.pnm").read_text(encoding="utf-8").splitlines()[4:]
            return [[int(number) for number in line.split()[component::3]] for line in lines]

        # red is that of stone or 0, green is the water
        stones, water = map_of(0), map_of(1)
        counts: Dict[bool, float] = {True: 0, False: 0}
        for x, y, _, hx, hy, _ in self.tips_of("roots-and-stones", "I"):
            # the place is the end of a segment
            column, row = math.floor((x + 2) * 20), math.floor(-y * 20)
            if 0 <= column < 80 and 0 <= row < 60:
                self.assertEqual(stones[row][column], 0, (x, y))
                counts[water[row][column] > 128] += 1
        cells = {wet: sum(stone == 0 and (amount > 128) == wet for stone_row, row in zip(stones, water)
                          for stone, amount in zip(stone_row, row)) for wet in (True, False)}
        self.assertGreater(counts[True] / cells[True], 1.6 * counts[False] / cells[False])

    def test_shoots_that_earn_nothing_fall_and_those_inside_earn_least(self) -> None:
        self.counted("leaf-economy", {"F": "F(", "S": "S("}, "8")
        shoots = re.findall(r"S\((\d+)\)\?E\(([^,]+),([^)]+)\)", answered_at("leaf-economy", 9))
        profits = [float(profit) for _, _, profit in shoots]
        # a ball in full light: 0.015 · 0.09/4 · 1.5² · (1 − (1 − 0.9/1.5²)²) · 8640 = 4.199 mol, less 0.6
        most = 0.015 * 0.09 / 4 * 2.25 * (1 - (1 - 0.9 / 2.25) ** 2) * 8640 - 0.6
        self.assertLessEqual(max(profits), most + 1e-9)
        self.assertLess(min(profits), 0)
        configuration = (GALLERY / "leaf-economy" / "leaf-economy.json").read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "thin.json"
            # leaves that let pass what falls on them make nothing, so they are only thinner
            path.write_text(configuration.replace('"transmittance": 0.1', '"transmittance": 0.6'), encoding="utf-8")
            thin = espalier("derive", model("leaf-economy"), "--quiet", "--define", "COST=0", "--define", "RISES=0",
                            "--environment", str(path)).stdout
        whole = strings("leaf-economy")[-1]
        # segments that end a branch without a shoot: those have fallen
        fallen = re.compile(r"F\([^)]*\)\]")
        self.assertGreater(len(fallen.findall(whole)), 20)
        self.assertEqual(len(fallen.findall(thin)), 0)

    def test_crowded_tips_stop_and_the_others_are_further_out(self) -> None:
        self.counted("crowded-bush", {"I": "I(", "A": "A(", "B": "B("}, "2")
        growing, stopped = self.tips_of("crowded-bush", "A"), self.tips_of("crowded-bush", "B")

        def mean_distance(tips: Sequence[Tuple[float, ...]]) -> float:
            return sum(math.dist(tip[:3], (0, 0.6, 0)) for tip in tips) / len(tips)

        self.assertGreater(mean_distance(growing), 1.1 * mean_distance(stopped))
        for count in re.findall(r"B\(\d+\)\?E\(([^)]*)\)", answered("crowded-bush")):
            self.assertGreaterEqual(float(count), 7)

    def test_ornament_keeps_within_the_heart_and_its_stems_apart(self) -> None:
        self.counted("ornament", {"F": "F(", "A": "A(", "K": "K?"})
        stems = self.tips_of("ornament", "F")
        inside = (GALLERY / "ornament" / "heart.pnm").read_text(encoding="utf-8").splitlines()[4:]
        for x, y, *_ in stems:
            # a tip looks 0.37 ahead, so no piece reaches the border
            self.assertEqual(inside[int((6 - y) * 10)].split()[1::3][int((x + 6) * 10)], "255", (x, y))
        for i, one in enumerate(stems):
            near = [other for other in stems if math.dist(one[:2], other[:2]) < 0.12]
            # itself, and where a branch leaves, its first piece
            self.assertLessEqual(len(near), 3, i)
        self.assertGreater(max(y for _, y, *_ in stems), 2.5)
        self.assertLess(min(x for x, *_ in stems), -3.0)
        self.assertGreater(max(x for x, *_ in stems), 3.0)

    def test_larger_discs_win_and_those_that_are_free_do_not_overlap(self) -> None:
        derived = self.counted("stand-of-discs", {"P": "P("})
        counts = [string.count("P(") for string in derived]
        self.assertEqual(counts[1:], sorted(counts[1:], reverse=True))
        plants = [tuple(map(float, numbers)) for numbers in re.findall(
            r"@M\(([^,]+),0,([^)]+)\)P\(([^,]+),([^,]+),\d+\)\?E\(([01])\)", answered_at_seed("stand-of-discs", 15))]
        self.assertGreater(len(plants), 50)
        free = [plant for plant in plants if plant[4] == 1]
        for i, (x, z, radius, *_) in enumerate(free):
            for u, v, other, *_ in free[:i]:
                self.assertGreater(math.hypot(x - u, z - v), radius + other)
        # rates of growth are even over 0.02 … 0.06: those that are left are the fast ones
        self.assertGreater(sum(plant[3] for plant in plants) / len(plants), 0.045)

    def test_the_crown_leans_to_the_light_and_the_roots_to_the_water(self) -> None:
        self.counted("root-and-shoot", {"G": "G(", "T": "T(", "F": "F(", "A": "A("}, "3")
        shoots, roots = self.tips_of("root-and-shoot", "A"), self.tips_of("root-and-shoot", "G")
        self.assertLess(sum(x for x, *_ in shoots) / len(shoots), -0.2)
        self.assertGreater(sum(x for x, *_ in roots) / len(roots), 0.1)
        self.assertTrue(all(y > 0 for _, y, *_ in shoots))
        self.assertTrue(all(y < 0.1 for _, y, *_ in roots))

    def test_an_espalier_leaves_windows_and_door_free_and_grows_around_them(self) -> None:
        self.counted("espalier", {"F": "F(", "B": "B("})
        ends = self.tips_of("espalier", "F", "--seed", "1")
        boxes = json.loads((GALLERY / "espalier" / "espalier.json").read_text(encoding="utf-8"))["boxes"]
        for x, y, z, *_ in ends[1:]:
            self.assertGreater(y, 0.03 - 1e-6)
            self.assertGreater(z, 0.03)
            for x0, y0, z0, x1, y1, z1 in boxes:
                aside = [max(low - value, value - high, 0.0)
                         for low, value, high in ((x0, x, x1), (y0, y, y1), (z0, z, z1))]
                self.assertGreater(math.hypot(*aside), 0.03 - 1e-6, (x, y))
        # above both windows, and beyond them
        self.assertGreater(sum(y > 3 and abs(x) > 1 for x, y, *_ in ends), 50)
        self.assertTrue(any(x < -2.2 and y < 2.5 for x, y, *_ in ends))

    def test_litter_makes_a_ring_that_widens(self) -> None:
        self.counted("litter-ring", {"S": "S(", "R": "R("})

        def distances(step: int) -> List[float]:
            return sorted(math.hypot(x, y) for x, y, *_ in
                          self.tips_of("litter-ring", "S", "--seed", "1", "--steps", str(step)))

        young, old = distances(12), distances(40)
        self.assertLess(young[0], 1.0)
        # nothing lives in the middle; most live near the front
        self.assertGreater(old[0], 0.3 * old[-1])
        self.assertGreater(old[len(old) // 2], 0.7 * old[-1])
        self.assertGreater(old[len(old) // 2], 2 * young[len(young) // 2])

    def counted(self, name: str, patterns: Dict[str, str], seed: str = "1") -> List[str]:
        """The strings of a run with a seed, after comparing numbers of matches with golden.tsv."""
        derived = strings(name, "--seed", seed)
        for step, expected in table(name, list(patterns)).items():
            self.assertEqual([derived[step].count(patterns[symbol]) for symbol in patterns], expected,
                             f"{name}, step {step}")
        return derived

    def test_self_organizing_trees_get_a_trunk_as_lambda_grows(self) -> None:
        self.counted("self-organizing-tree", {"I": "I(", "B": "B("})

        def metamers(weight: str, *more: str) -> Tuple[int, int]:
            """Of the trunk, and in all."""
            string = espalier("derive", model("self-organizing-tree"), "--quiet", "--seed", "1", "--define",
                              f"LAMBDA={weight}", *more).stdout
            depth = trunk = 0
            for character, after in zip(string, string[1:]):
                depth += {"[": 1, "]": -1}.get(character, 0)
                trunk += depth == 0 and character + after == "I("
            return trunk, string.count("I(")

        decurrent, even, excurrent = metamers("0.46"), metamers("0.48"), metamers("0.54")
        self.assertLess(decurrent[0], even[0])
        self.assertLess(even[0], excurrent[0])
        self.assertGreater(excurrent[0] / excurrent[1], 2 * decurrent[0] / decurrent[1])
        # the same model in propagated shadows: a tree with a trunk
        shade = metamers("0.54", "--steps", "24", "--environment",
                         str(GALLERY / "self-organizing-tree" / "shade.json"))
        self.assertGreater(shade[0], 10)
        self.assertGreater(shade[1], 100)

    def test_self_organizing_trees_feed_by_rank_and_lose_branches(self) -> None:
        def run(*more: str) -> List[str]:
            environment = str(GALLERY / "self-organizing-tree" / "shade.json")
            return strings("self-organizing-tree", "--seed", "1", "--steps", "34", "--environment", environment,
                           "--define", "PRIORITY=1", *more)

        def trunk(string: str) -> int:
            depth = metamers = 0
            for character, after in zip(string, string[1:]):
                depth += {"[": 1, "]": -1}.get(character, 0)
                metamers += depth == 0 and character + after == "I("
            return metamers

        derived = run()
        lines = (GALLERY / "self-organizing-tree" / "golden-priority.tsv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(lines[0].split("\t"), ["step", "I", "B", "fallen"])
        for step, *expected in ([int(number) for number in line.split("\t")] for line in lines[1:]):
            self.assertEqual([derived[step].count(symbol) for symbol in ("I(", "B(", "[]")], expected, f"step {step}")
        whole = run("--define", "SHED=0")[-1]
        self.assertEqual(whole.count("[]"), 0)
        self.assertGreater(derived[-1].count("[]"), 5)
        self.assertLess(derived[-1].count("I("), 0.5 * whole.count("I("))
        self.assertGreater(trunk(whole), trunk(run("--define", "SHED=0", "--define", "APICAL=0")[-1]))

    def test_roots_gather_in_the_wet_layer(self) -> None:
        self.counted("roots-in-soil", {"I": "I(", "T": "T("})
        with tempfile.TemporaryDirectory() as folder:
            drawn = str(Path(folder) / "roots.csv")
            espalier("run", model("roots-in-soil"), "--seed", "1", "--quiet", "-o", drawn)
            rows = list(csv.DictReader(Path(drawn).read_text(encoding="utf-8").splitlines()))
        lengths = {True: 0.0, False: 0.0}
        for row in rows:
            if row["symbol"] == "I":
                lengths[-0.75 <= float(row["y"]) < -0.45] += float(row["parameters"].split(";")[0])
        # the layer is 0.3 m of 1.25 m; per metre of depth it has several times the roots of the sand
        self.assertGreater(lengths[True] / 0.3, 3 * lengths[False] / 0.95)

    def test_a_plant_without_water_closes_its_stomata_wilts_and_recovers(self) -> None:
        lines = espalier("derive", str(GALLERY / "wilting-plant"), "--every", "--quiet").stdout.splitlines()
        leaves = [[[float(number) for number in query.split(",")] for query in re.findall(r"\?E\(([^)]*)\)L", line)]
                  for line in lines]

        def conductance(day: int, hour: int) -> float:
            """Of the oldest leaf; the string of an hour has the answers of the hour before."""
            return leaves[24 * (day - 1) + hour + 1][0][5]

        # on the first days it follows the sun; on the fifth it is open in the morning, closes, and opens at night only by f(psi)
        self.assertEqual(conductance(1, 3), 0.0)
        self.assertGreater(conductance(2, 12), conductance(2, 7))
        self.assertAlmostEqual(conductance(3, 12), conductance(1, 12), delta=1e-6)
        self.assertLess(conductance(5, 12), 0.6 * conductance(5, 8))
        noons = [conductance(day, 12) for day in range(1, 11)]
        self.assertTrue(all(after < before for before, after in zip(noons[3:], noons[4:9])), noons)
        self.assertLess(noons[8], 0.1 * noons[0])
        self.assertAlmostEqual(noons[9], noons[0], delta=1e-5)  # after the rain
        # closed leaves are warmer, and give off less heat as vapour
        self.assertGreater(leaves[24 * 8 + 13][0][6], leaves[24 * 2 + 13][0][6] + 3)
        self.assertLess(leaves[24 * 8 + 13][0][9], 0.2 * leaves[24 * 2 + 13][0][9])
        # no turgor at noon: leaves grow and come more slowly
        self.assertEqual(leaves[24 * 6 + 13][0][8], 0.0)
        self.assertGreater(leaves[24 * 6 + 4][0][8], 0.5)
        counts = [len(leaves[24 * day]) for day in (0, 4, 8)]
        self.assertGreater(counts[1] - counts[0], counts[2] - counts[1])

    def test_leaves_give_off_water_by_the_light_that_they_absorb(self) -> None:
        lines = espalier("derive", str(GALLERY / "sun-and-shade"), "--every", "--quiet").stdout.splitlines()
        numbers = re.compile(r"\?Water\(([^)]*)\)\?Light\(([^)]*)\)L")
        hours = [[[[float(each) for each in part.split(",")] for part in leaf] for leaf in numbers.findall(line)]
                 for line in lines]
        for leaves in hours[2:]:
            for water, light in leaves:
                # the answers of light: both bands less long waves, and photons
                self.assertAlmostEqual(water[3], light[0] + light[4] - 30, places=6)
                self.assertAlmostEqual(water[4], 4.57 * light[2], places=6)
                # the drawn leaf is as large as the leaf that gives off water
                self.assertAlmostEqual(light[3], 0.006 * light[2], delta=1e-3 * light[3])
        # the light of an hour comes in that hour: the sun rises at 4:05 and sets at 20 o'clock, universal time
        self.assertEqual([hour for hour, leaves in enumerate(hours) if any(water[4] > 0 for water, _ in leaves)], list(range(4, 20)))
        self.assertTrue(all(water[5] == 0 for hour in (3, 22) for water, _ in hours[hour]))
        # in the sun a leaf opens wider, is warmer and gives off more than in the shade; an answer is in the next string
        noon = [(before[3], after[5:]) for (before, _), (after, _) in zip(hours[12], hours[13])]
        sunny, shaded = max(noon), min(noon)
        self.assertGreater(sunny[0], 2 * shaded[0])
        for number in (0, 1, 4):
            self.assertGreater(sunny[1][number], shaded[1][number])

    def test_a_stand_thins_along_the_line_of_minus_three_halves(self) -> None:
        derived = self.counted("self-thinning", {"P": "P("})
        points = []
        for string in derived[1:]:
            radii = [float(radius) for radius in re.findall(r"P\(([^,]+),", string)]
            points.append((len(radii), sum(radius ** 3 for radius in radii) / len(radii)))
        # only while it thins
        thinning = [(math.log(count), math.log(mass)) for count, mass in points if 0.05 * 1500 < count < 0.9 * 1500]
        self.assertGreater(len(thinning), 15)
        mean_x = sum(x for x, _ in thinning) / len(thinning)
        mean_y = sum(y for _, y in thinning) / len(thinning)
        slope = (sum((x - mean_x) * (y - mean_y) for x, y in thinning) / sum((x - mean_x) ** 2 for x, _ in thinning))
        self.assertAlmostEqual(slope, -1.5, delta=0.15)

    def test_pioneers_come_first_and_climax_trees_last(self) -> None:
        derived = self.counted("ecosystem", {species: f"P({species}," for species in "012"})
        counts = [[string.count(f"P({species},") for species in range(3)] for string in derived]
        self.assertEqual(max(range(3), key=lambda species: counts[32][species]), 0)
        self.assertEqual(max(range(3), key=lambda species: counts[90][species]), 2)
        self.assertTrue(all(min(row) > 0 for row in counts))

    def test_a_year_of_a_stand_shades_the_ground_and_draws_the_soil_dry(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            series = Path(folder) / "year.csv"
            espalier("run", model("stand-year"), "--seed", "1", "--quiet", "-o", str(Path(folder) / "stand.string"),
                     "--field", str(series))
            rows = list(csv.DictReader(series.read_text(encoding="utf-8").splitlines()))
        means = {field: [float(row["mean"]) for row in rows if row["field"] == field]
                 for field in ("Light.groundLight", "Soil.waterContent")}
        light, water = means["Light.groundLight"], means["Soil.waterContent"]
        self.assertEqual([len(light), len(water)], [365, 366], "there is light from the first day on")
        # 100 days before and after the solstice the sun is the same, but in autumn the leaves are there: a third is gone
        self.assertLess(sum(light[232:242]), 0.8 * sum(light[102:112]))
        # the sun of December is weak, and the ground has it all
        self.assertLess(max(light[:20]), min(light[150:170]))
        # roots draw the soil dry in summer, rain fills it again
        self.assertLess(min(water[200:281]), 0.9 * min(water[60:100]))
        self.assertGreater(water[365], 1.1 * min(water[200:281]))

    def test_the_bed_of_the_stand_is_dark_to_the_north_and_dry_below(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            light, soil = Path(folder) / "light.raw", Path(folder) / "soil.raw"
            espalier("run", model("stand-year"), "--seed", "1", "--steps", "200", "--quiet", "-o",
                     str(Path(folder) / "stand.string"), "--field", f"Light.groundLight={light}", "--field",
                     f"Soil.waterContent={soil}")
            ground = struct.unpack("<256d", light.read_bytes())  # x fastest, then z, 0.125 m each, from -1
            water = struct.unpack("<288d", soil.read_bytes())  # 3 by 12 by 8 cells, x fastest, then y upwards, then z
        rows = [sum(ground[16 * z:16 * z + 16]) / 16 for z in range(16)]
        # north is -z: as far from the middle of the bed the north has less of the sun than the south, the path the most
        for away in (3, 4, 5):
            self.assertLess(rows[7 - away], 0.9 * rows[8 + away])
        self.assertLess(max(rows[3:8]), 0.8 * max(rows))
        self.assertIn(rows.index(max(rows)), range(12, 16))

        def content(z: int) -> float:
            """Mean of a column of cells in the rooted part, 0.2 to 0.9 m deep."""
            return sum(water[(z * 12 + y) * 3 + x] for y in range(3, 10) for x in range(3)) / 21

        self.assertLess(content(4), 0.85 * content(0))
        self.assertLess(content(4), 0.85 * content(7))

    def test_insects_find_the_plant_and_feed(self) -> None:
        self.check_table("insect-on-a-plant", "FLI")
        insects = re.findall(r"@M\(([^,]*),[^)]*\)\?E\([^)]*\)I\(([^)]*)\)", answered("insect-on-a-plant"))
        self.assertEqual(len(insects), 4)
        for place, eaten in insects:
            self.assertLess(abs(float(place)), 2.4)  # all started further from the stalk
            self.assertGreater(float(eaten), 0.1)

    def test_a_shrub_branches_where_insects_browse_it(self) -> None:
        self.check_table("browsed-shrub", "FLB")
        # insects sit on leaves of the plant, each on one of them
        sitting = re.findall(r"\?E\(([^,]*),([^)]*)\)L\(([^,]*),", answered("browsed-shrub"))
        self.assertTrue(0 < sum(float(number) for _, number, _ in sitting) <= 12)
        for eaten, number, area in sitting:
            self.assertLessEqual(float(eaten), min(float(area), 0.12 * float(number)) + 1e-9)
        # without appetite no leaf falls, and the shrub keeps its one stem
        with tempfile.TemporaryDirectory() as folder:
            fasting = Path(folder) / "fasting.json"
            fasting.write_text(json.dumps({"type": "insects", "count": 12, "appetite": 0}), encoding="utf-8")
            string = espalier("derive", model("browsed-shrub"), "--environment", str(fasting), "--quiet").stdout
        self.assertEqual((string.count("F("), string.count("L("), string.count("B(")), (11, 11, 0))

    def test_trees_that_keep_accounts_shed_what_costs_more_than_it_earns(self) -> None:
        folder = GALLERY / "trees-by-account"
        derived: Dict[Tuple[int, int], str] = {}
        for line in espalier("derive", str(folder), "--every", "--quiet").stdout.splitlines():
            step, plant, string = line.split("\t")
            derived[int(step), int(plant)] = string
        rows = [line.split("\t") for line in (folder / "golden.tsv").read_text(encoding="utf-8").splitlines()]
        self.assertEqual(rows[0], ["step", "plant", "I", "A"])
        for row in rows[1:]:
            number, tree, segments, shoots = map(int, row)
            self.assertEqual([derived[number, tree].count("I("), derived[number, tree].count("A(")], [segments, shoots])
        # forks whose lateral has no fork of its own: accounts and shoots add up, widths by w^2.5
        numbers = r"I\(([^)]*)\)"
        forks = re.findall(numbers + r"/\(137\.5\)\[&\(32\)" + numbers + r"[^][]*\]\^\(\d+\)" + numbers, derived[182, 0])
        checked = 0
        for fork in forks:
            (_, width, balance, count, year), *branches = ([float(word) for word in part.split(",")] for part in fork)
            if year == 16 and all(branch[4] == 16 for branch in branches):
                carried = sum(branch[1] ** 2.5 for branch in branches) ** 0.4
                self.assertGreater(width, carried - 1e-9)
                earned = sum(branch[2] for branch in branches) - 0.32 * (width / 0.03) ** 1.875
                self.assertAlmostEqual(balance, earned, 6)
                self.assertEqual(count, sum(branch[3] for branch in branches))
                checked += 1
        self.assertGreater(checked, 20)
        alone = espalier("derive", str(folder / "alone.json"), "--every", "--quiet").stdout.count("%")
        both = sum(string.count("%") for string in derived.values())
        self.assertGreater(alone, 20)
        self.assertGreater(both, 2 * alone)
        with tempfile.TemporaryDirectory() as place:
            modules = Path(place) / "modules.csv"
            espalier("run", str(folder), "-o", str(modules), "--quiet")
            shoots_of = [row for row in csv.DictReader(modules.read_text(encoding="utf-8").splitlines())
                         if row["symbol"] == "A"]
        for plant, middle, side in (("0", -2.0, 1), ("1", 2.0, -1)):
            aside = [side * (float(row["x"]) - middle) for row in shoots_of if row["plant"] == plant]
            facing, far = sum(x > 0.05 for x in aside), sum(x < -0.05 for x in aside)
            self.assertLess(2 * facing, far)

    def test_trees_that_face_each_other_grow_less_on_that_side(self) -> None:
        folder = GALLERY / "two-trees"
        rows = [line.split("\t") for line in (folder / "golden.tsv").read_text(encoding="utf-8").splitlines()]
        self.assertEqual(rows[0], ["step", "plant", "F", "B"])
        for step, plant, segments, buds in rows[1:]:
            lines = espalier("derive", str(folder), "--steps", step, "--quiet").stdout.splitlines()
            string = lines[int(plant)].split("\t")[1]
            self.assertEqual([string.count("F"), string.count("B")], [int(segments), int(buds)], f"step {step}")

        def sides(forest: str) -> Dict[Tuple[int, bool], int]:
            """Segments of each plant on the side of larger x, and on the other."""
            with tempfile.TemporaryDirectory() as place:
                table = f"{place}/modules.csv"
                espalier("run", str(folder / forest), "-o", table, "--quiet")
                with open(table, encoding="utf-8") as text:
                    drawn = [row for row in csv.DictReader(text) if row["symbol"] == "F" and row["x"]]
            counts: Dict[Tuple[int, bool], int] = {}
            for row in drawn:
                plant = int(row["plant"])
                aside = float(row["x"]) - (-2.0 if plant == 0 else 2.0)
                if abs(aside) > 0.05:
                    counts[plant, aside > 0] = counts.get((plant, aside > 0), 0) + 1
            return counts

        alone, together = sides("alone.json"), sides("forest.json")
        for plant, faces in ((0, True), (1, False)):
            near = alone[0, faces] - together[plant, faces]
            far = alone[0, not faces] - together[plant, not faces]
            self.assertGreater(near, 3 * max(far, 1))


if __name__ == "__main__":
    unittest.main()
