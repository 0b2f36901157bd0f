"""Root systems in RSML against a second reader (rsml_reader.py): geometry, hierarchy and diameters, in and out."""

import csv
import random
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List, Optional, Tuple

from rsml_reader import Point, RsmlFile
from support import espalier, model

Segment = Tuple[Point, Point, Optional[float]]


class RootMarkup(unittest.TestCase):
    maxDiff = 3000

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def read(self, name: str) -> RsmlFile:
        return RsmlFile((self.folder / name).read_text(encoding="utf-8"))

    def assertSegments(self, found: List[Segment], expected: List[Segment], digits: int) -> None:
        def key(segment: Segment) -> Tuple[float, ...]:
            return tuple(round(number, 6) for point in segment[:2] for number in point)

        self.assertEqual(len(found), len(expected))
        for one, other in zip(sorted(found, key=key), sorted(expected, key=key)):
            for point, wanted in zip(one[:2], other[:2]):
                for number, want in zip(point, wanted):
                    self.assertAlmostEqual(number, want, digits, (one, other))
            self.assertEqual(one[2] is None, other[2] is None, (one, other))
            if one[2] is not None and other[2] is not None:
                self.assertAlmostEqual(one[2], other[2], digits, (one, other))

    def test_what_is_written_of_a_table_has_its_segments_diameters_and_laterals(self) -> None:
        for seed in range(5):
            chance = random.Random(seed)
            rows: List[Tuple[int, Point, float, int]] = [(-1, (0.0, 0.0, 0.0), 0.5, 1)]
            # the row of the tip of each axis
            tips = [0]
            for _ in range(60):
                # an axis grows, or a lateral of the next order begins at any row
                isLateral = chance.random() < 0.2 and len(rows) > 1
                before = chance.randrange(1, len(rows)) if isLateral else chance.choice(tips)
                x, y, z = rows[before][1]
                place = (round(x + chance.uniform(-1, 1), 3), round(y - chance.uniform(0.1, 1), 3), round(z + chance.uniform(-1, 1), 3))
                rows.append((before, place, round(chance.uniform(0.01, 0.5), 4), rows[before][3] + isLateral))
                tips = [*(tip for tip in tips if isLateral or tip != before), len(rows) - 1]
            (self.folder / "roots.tsv").write_text("node\tparent\tx\ty\tz\tradius\torder\n" + "".join(
                f"{i}\t{before}\t{x}\t{y}\t{z}\t{radius}\t{order}\n" for i, (before, (x, y, z), radius, order) in enumerate(rows)), encoding="utf-8")
            espalier("run", str(self.folder / "roots.tsv"), "-o", str(self.folder / "out.rsml"))
            found = self.read("out.rsml")
            self.assertSegments(list(found.segments()), [(rows[before][1], place, 2 * radius) for before, place, radius, _ in rows[1:]], 9)
            orders: Dict[Point, int] = {place: order for _, place, _, order in rows}
            for root in found.roots:
                # a lateral begins at a point of its parent, and its own points have its order
                self.assertEqual(found.joint(root), None if root.parent is None else root.points[0])
                order = 1
                above = root.parent
                while above is not None:
                    order, above = order + 1, found.roots[above].parent
                self.assertEqual({orders[point] for point in root.points[1:]}, {order})

    def test_what_a_model_grew_is_what_its_table_of_modules_says(self) -> None:
        espalier("run", model("roots-in-soil"), "--steps", "16", "--seed", "3", "--quiet", "-o", str(self.folder / "out.rsml"), "-o", str(self.folder / "out.csv"))
        with (self.folder / "out.csv").open(encoding="utf-8") as file:
            modules = {int(row["module"]): row for row in csv.DictReader(file)}
        expected: List[Segment] = []
        for row in modules.values():
            if row["symbol"] != "I":
                continue
            before = row
            while before["parent"]:
                before = modules[int(before["parent"])]
                if before["symbol"] == "I":
                    break
            ends = [(float(each["x"]), float(each["y"]), float(each["z"])) for each in (before, row)]
            expected.append((ends[0] if before["symbol"] == "I" and before is not row else (0.0, 0.0, 0.0), ends[1], float(row["width"])))
        self.assertGreater(len(expected), 30)
        found = self.read("out.rsml")
        self.assertSegments(list(found.segments()), expected, 9)
        self.assertGreater(sum(root.parent is not None for root in found.roots), 2)

    def written(self, seed: int) -> str:
        """A file of another program: namespaces, functions of each domain, properties, annotations, splines, and no z here and there."""
        chance = random.Random(seed)

        def point(place: Point) -> str:
            return f'<point x="{place[0]}" y="{place[1]}"' + (f' z="{place[2]}"/>' if place[2] else "/>")

        def diameters(points: List[Point]) -> str:
            domain = chance.choice(("polyline", "uniform", "length"))
            # the last points may have no value
            count = max(2, len(points) - chance.randrange(2)) if domain == "polyline" else chance.randrange(2, 6)
            samples = []
            for i in range(count):
                place = f' position="{round(i * 0.7 + chance.random() / 2, 3)}"' if domain == "length" else ""
                value = round(chance.uniform(0.05, 0.4), 3)
                samples.append(f"<sample{place}>{value}</sample>" if chance.random() < 0.3 else f'<sample{place} value="{value}"/>')
            return f'<function name="diameter" domain="{domain}">{"".join(samples)}</function>'

        def root(begin: Point, depth: int, node: int) -> str:
            points = [begin]
            for _ in range(chance.randrange(2, 6)):
                x, y, z = points[-1]
                points.append((round(x + chance.uniform(-1, 1), 3), round(y - chance.uniform(0.2, 1), 3), chance.choice((0.0, round(z + 0.25, 3)))))
            nodes = [chance.randrange(1, len(points)) for _ in range(chance.randrange(3) if depth < 3 else 0)]
            return (f'<root ID="{chance.randrange(10 ** 6)}" label="r{depth} &amp; &quot;{node}&quot;" po:accession="PO:0020127"><properties>' +
                    (f'<parent-node value="{node}"/>' if node >= 0 else "") + '<category value="seminal"/></properties><geometry>' +
                    f'<rootnavspline controlpointseparation="50">{point((9.0, 9.0, 9.0))}</rootnavspline>' +
                    f'<polyline>{"".join(map(point, points))}</polyline></geometry><functions><function name="orientation" domain="polyline">' +
                    f'<sample value="7"/></function>{diameters(points)}</functions>' + "".join(root(points[at], depth + 1, at) for at in nodes) +
                    f'<annotations><annotation name="note">{point((5.0, 5.0, 0.0))}<value>by eye</value></annotation></annotations></root>')

        plants = "".join(f'<plant ID="p{i}" label="Béla &lt;{i}&gt;">{root((10.0 * i, 0.0, 0.0), 1, -1)}</plant>' for i in range(2))
        return ('<?xml version="1.0"?><rsml xmlns:po="http://www.plantontology.org/xml-dtd/po.dtd"><metadata><version>1</version><unit>cm</unit>'
                f"<resolution>1</resolution></metadata><scene>{plants}</scene></rsml>")

    def test_what_is_read_and_written_again_means_the_same(self) -> None:
        domains, laterals = set(), 0
        for seed in range(12):
            text = self.written(seed)
            source = RsmlFile(text)
            (self.folder / "in.rsml").write_text(text, encoding="utf-8")
            espalier("run", str(self.folder / "in.rsml"), "-o", str(self.folder / "out.rsml"))
            found = self.read("out.rsml")
            self.assertEqual(found.unit, "cm")
            self.assertSegments(list(found.segments()), list(source.segments()), 9)
            # roots may come in another order; each has its own names, points, parent and plant

            def known(file: RsmlFile) -> List[Tuple[Tuple[str, str], str, str, List[Point], Optional[List[Point]]]]:
                return sorted((file.plants[root.plant], root.identifier, root.label, root.points,
                               None if root.parent is None else file.roots[root.parent].points) for root in file.roots)

            self.assertEqual(known(found), known(source))
            self.assertEqual(found.plants, [("p0", "Béla <0>"), ("p1", "Béla <1>")])
            # the second time nothing changes at all
            espalier("run", str(self.folder / "out.rsml"), "-o", str(self.folder / "again.rsml"))
            self.assertEqual((self.folder / "again.rsml").read_bytes(), (self.folder / "out.rsml").read_bytes())
            domains |= {root.functions["diameter"].domain for root in source.roots}
            laterals += sum(root.parent is not None for root in source.roots)
            self.assertTrue(all(root.annotations["note"] == [(5.0, 5.0, 0.0)] and root.properties["category"] == "seminal" for root in source.roots))
            traits = dict(line.rsplit("\t", 1)[0].rsplit("\t", 1) for line in espalier("traits", str(self.folder / "in.rsml")).stdout.splitlines())
            self.assertAlmostEqual(float(traits["length\t"]), sum(root.positions()[-1] for root in source.roots), 9)
        self.assertEqual(domains, {"polyline", "uniform", "length"})
        self.assertGreater(laterals, 10)

    def test_what_is_read_is_written_as_it_was(self) -> None:
        def root(name: str, points: List[Point], node: Optional[int] = None, diameters: str = "", days: str = "", inside: str = "") -> str:
            functions = "".join(f'<function name="{kind}" domain="polyline">' + "".join(f'<sample value="{each}"/>' for each in values.split()) + "</function>"
                                for kind, values in (("diameter", diameters), ("emergence_time", days)) if values)
            return (f"<root {name}>" + ("" if node is None else f'<properties><parent-node value="{node}"/></properties>') + "<geometry><polyline>" +
                    "".join(f'<point x="{x}" y="{y}" z="{z}"/>' for x, y, z in points) + f"</polyline></geometry><functions>{functions}</functions>{inside}</root>")

        far = 1e12
        first = root('ID="4"', [(0, 0, 0), (0, -1, 0), (0, -1, 0), (0, -2, 0)], None, "0.5 0.4 0.4 0", "", "".join((
            # laterals: at the first point, with one of its own there; off the parent; in the end, before and behind in the drawing
            root('ID="tip"', [(0, -2, 0), (1, -3, 0)], 3, "0.1 0"),
            root('ID="first" label="l"', [(0, 0, 0), (2, -1, 0), (2, -1, 0)], 0, "0.2 0.1", "", root('ID="deep"', [(0, 0, 0), (0, 0, 4)], 0)),
            root('ID="off"', [(0.25, -1, 0), (3, -1.5, 0)], 2, "0.2 0.1"),
            root('ID="on"', [(0, -1, 0), (0.1 + 0.2, -1, 1 / 3)], 1),
            root('ID="dot"', [(0, -1, 0)], 1, "0.3"))))
        second = root("", [(far, 0, 0), (far + 0.125, -0.0625, 1e-7), (far + 0.375, -1, 1e-300)], None, "0.1 0.1 0.1", "", root("", [(far, 0, 0), (far, 0, 1)], 0))
        seed = root('ID="7"', [(5, 5, 5)], None, "0.25")
        timed = root('ID="a"', [(0, 0, 0), (0, -1, 0)], None, "", "0.5 3.25", root('ID="b"', [(0, 0, 0), (1, 0, 0)], 0, "", "1.5 2.25"))
        for name, plants in (("roots", f'<plant ID="0" label="p">{first}</plant><plant>{second}</plant><plant ID="2">{seed}</plant>'),
                             ("days", f'<plant ID="p">{timed}</plant>')):
            text = f"<rsml><metadata><unit>mm</unit></metadata><scene>{plants}</scene></rsml>"
            (self.folder / "in.rsml").write_text(text, encoding="utf-8")
            source = RsmlFile(text).roots
            for more in ((), ("--every",)) if name == "days" else ((),):
                espalier("run", str(self.folder / "in.rsml"), *more, "-o", str(self.folder / "out.rsml"))
                found = self.read("out.rsml")
                for one, other in zip(found.roots, source):
                    # numbers stand for names that are missing, and none of them is the name of another
                    other.identifier = other.identifier or one.identifier
                self.assertEqual(found.roots, source)
                names = [root.identifier for root in found.roots]
                self.assertEqual(len(set(names)), len(names), names)
                identifiers = [identifier for identifier, _ in found.plants]
                self.assertEqual(len(set(identifiers)), len(identifiers), identifiers)
                espalier("run", str(self.folder / "out.rsml"), *more, "-o", str(self.folder / "again.rsml"))
                self.assertEqual((self.folder / "again.rsml").read_bytes(), (self.folder / "out.rsml").read_bytes())
        # a day of the animation has the roots that are there then, in their hierarchy
        espalier("run", str(self.folder / "in.rsml"), "--every", "-o", str(self.folder / "day-%d.rsml"))
        self.assertEqual([[(root.identifier, root.parent, root.points) for root in self.read(f"day-{day}.rsml").roots] for day in (1, 2, 3)],
                         [[], [("a", None, [(0, 0, 0)]), ("b", 0, [(0, 0, 0), (1, 0, 0)])],
                          [("a", None, [(0, 0, 0), (0, -1, 0)]), ("b", 0, [(0, 0, 0), (1, 0, 0)])]])

    def test_a_small_plant_far_away_keeps_its_digits(self) -> None:
        (self.folder / "far.l").write_text("Lsystem: 1\nderivation length: 0\nAxiom: @M(1000000000000,0,0)F(0.5)\nendlsystem\n", encoding="utf-8")
        espalier("run", str(self.folder / "far.l"), "-o", str(self.folder / "out.rsml"))
        self.assertEqual(self.read("out.rsml").roots[0].points[1], (1e12, 0.5, 0.0))

    def test_roots_without_a_length_are_named(self) -> None:
        point = '<geometry><polyline><point x="1" y="2"/></polyline></geometry>'
        (self.folder / "in.rsml").write_text(f'<rsml><scene><plant>\n<root ID="a">{point}</root></plant></scene></rsml>', encoding="utf-8")
        said = espalier("run", str(self.folder / "in.rsml"), "-o", str(self.folder / "out.png"), status=1).stderr
        self.assertRegex(" ".join(said.split()), r"^error: .*in.rsml: its roots have no length, so there is nothing to draw. Give a file with two points of "
                                                 "at least one root$")
        self.assertFalse((self.folder / "out.png").exists())
        line = '<geometry><polyline><point x="1" y="2"/><point x="1" y="0"/></polyline></geometry>'
        (self.folder / "in.rsml").write_text(f'<rsml><scene><plant>\n<root ID="a">{point}</root>\n<root ID="b">{line}</root></plant></scene></rsml>',
                                             encoding="utf-8")
        said = espalier("run", str(self.folder / "in.rsml"), "-o", str(self.folder / "out.png")).stderr
        self.assertIn("in.rsml': 1 root has a single point or no length and is not drawn: line 2", " ".join(said.split()))

    def test_days_keep_their_fractions_and_first_points_their_values(self) -> None:
        def root(name: str, place: float, days: Tuple[float, ...], inside: str = "", node: str = "") -> str:
            points = "".join(f'<point x="{place}" y="{-i}"/>' for i in range(len(days)))
            samples = "".join(f'<sample value="{day}"/>' for day in days)
            return (f'<root ID="{name}">{node}<geometry><polyline>{points}</polyline></geometry><functions><function name="diameter" domain="polyline">'
                    f'{"".join(f"<sample value={chr(34)}{0.5 - i / 10}{chr(34)}/>" for i in range(len(days)))}</function><function name="emergence_time" '
                    f'domain="polyline">{samples}</function></functions>{inside}</root>')

        text = ("<rsml><metadata><unit>cm</unit></metadata><scene><plant ID=\"1\">" + root("a", 0.0, (0.25, 1.75, 3.125, 3.5)) +
                root("b", 5.0, (0.5, 2.5, 7.0625)) + '</plant><plant ID="2">' + root("c", 9.0, (1.1, 1.2)) + "</plant></scene></rsml>")
        (self.folder / "in.rsml").write_text(text, encoding="utf-8")
        source = {root.identifier: root for root in RsmlFile(text).roots}
        for more in ((), ("--every",)):
            espalier("run", str(self.folder / "in.rsml"), *more, "-o", str(self.folder / "out.rsml"))
            found = self.read("out.rsml")
            self.assertEqual(sorted(root.identifier for root in found.roots), ["a", "b", "c"])
            for each in found.roots:
                for name in ("emergence_time", "diameter"):
                    self.assertEqual(each.values(name), source[each.identifier].values(name), (each.identifier, name, more))
            self.assertEqual([found.plants[root.plant][0] for root in found.roots], ["1", "1", "2"])

    def test_more_points_than_can_be_drawn_are_one_sentence_at_once(self) -> None:
        # as a limit of a million bytes: 20,000 points
        points = "".join(f'<point x="{i % 7}" y="-{i}"/>' for i in range(20_001))
        (self.folder / "in.rsml").write_text(f'<rsml><scene><plant ID="1"><root ID="a"><geometry><polyline>{points}</polyline></geometry></root></plant>'
                                             "</scene></rsml>", encoding="utf-8")
        said = espalier("run", str(self.folder / "in.rsml"), "--limit", "sourceBytes=1000000", "-o", str(self.folder / "out.rsml"), status=1).stderr
        said = " ".join(said.split())  # long lines are folded
        self.assertRegex(said, r"^error: .*in.rsml, line 1: the file has more than 20000 points, which is as many as can be drawn: 'espalier traits' "
                               r"measures more, and --limit sourceBytes=N lets more be drawn \(50 bytes a point\)$")
        self.assertFalse((self.folder / "out.rsml").exists())
        self.assertIn("length\t\t", espalier("traits", str(self.folder / "in.rsml")).stdout)


if __name__ == "__main__":
    unittest.main()
