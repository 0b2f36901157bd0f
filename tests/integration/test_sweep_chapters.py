"""The chapter of the gallery on sensitivity and calibration, and the Python package's functions for sweeps."""

import importlib.util
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings
from pathlib import Path
from typing import Any

from support import GALLERY, PACKAGE, program, variables

import espalier

CHAPTER = GALLERY / "chapter-sensitivity"
NUMPY: Any = None
if importlib.util.find_spec("numpy"):
    import numpy
    NUMPY = numpy


def script(name: str) -> Any:
    """A program of the chapter as a module."""
    spec = importlib.util.spec_from_file_location(name, CHAPTER / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def swept(plan: Path) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        espalier.sweep.run(plan, f"{folder}/r.sqlite", program=program())
        return espalier.sweep.results(f"{folder}/r.sqlite", program=program())


def morris(x: Any) -> float:
    """The function of Morris (1991), written as in his paper."""
    w = [2 * (1.1 * v / (v + 0.1) - 0.5) if i in (2, 4, 6) else 2 * (v - 0.5) for i, v in enumerate(x)]
    n = range(20)
    y = sum((20 if i < 10 else (-1) ** (i + 1)) * w[i] for i in n)
    y += sum((-15 if j < 6 else (-1) ** (i + j)) * w[i] * w[j] for i in n for j in n if i < j)
    y += sum(-10 * w[i] * w[j] * w[k] for i in range(5) for j in range(5) for k in range(5) if i < j < k)
    return y + 5 * w[0] * w[1] * w[2] * w[3]


@unittest.skipIf(NUMPY is None, "NumPy is not installed")
class Chapter(unittest.TestCase):
    def test_the_indices_of_ishigami_are_the_analytic_ones(self) -> None:
        # Ishigami & Homma 1990: V1 = (1 + b pi^4 / 5)^2 / 2, V2 = a^2 / 8, V13 = b^2 pi^8 (1/18 - 1/50)
        a, b = 7.0, 0.1
        v1, v2 = (1 + b * math.pi ** 4 / 5) ** 2 / 2, a * a / 8
        v13 = b * b * math.pi ** 8 * (1 / 18 - 1 / 50)
        v = v1 + v2 + v13
        results = swept(CHAPTER / "indices.json")
        self.assertEqual(len(results["run"]), 2 ** 13 * 5)
        indices = espalier.sweep.sobol_indices(results["f"], 3)
        for found, exact in zip([*indices.first, *indices.total], [v1 / v, v2 / v, 0, (v1 + v13) / v, v2 / v, v13 / v]):
            self.assertLess(abs(found - exact), 0.02)

    def test_the_effects_of_morris_are_those_of_his_function_on_the_same_trajectories(self) -> None:
        results = swept(CHAPTER / "effects.json")
        names = [f"x{i}" for i in range(1, 21)]
        x = results.array(names)
        found = espalier.sweep.morris_effects(x, results["y"], levels=4)
        # independently: effects by factor, in plain Python
        jump = 4 / (2 * 3)
        effects: Any = [[] for _ in names]
        for walk in range(0, len(x), 21):
            for k in range(walk, walk + 20):
                (factor,) = [i for i in range(20) if x[k][i] != x[k + 1][i]]
                sign = 1 if x[k + 1][factor] > x[k][factor] else -1
                effects[factor].append((morris(x[k + 1]) - morris(x[k])) / (sign * jump))
        for i, values in enumerate(effects):
            self.assertEqual(len(values), 40)
            mean = math.fsum(values) / 40
            self.assertAlmostEqual(found.mu[i], mean, delta=1e-9)
            self.assertAlmostEqual(found.mu_star[i], math.fsum(map(abs, values)) / 40, delta=1e-9)
            self.assertAlmostEqual(found.sigma[i], math.sqrt(math.fsum((e - mean) ** 2 for e in values) / 39), delta=1e-9)
        # figure 1 of the paper: factors 1 to 10 matter, 8 to 10 without interactions; the others do not
        self.assertLess(max(found.mu_star[10:]), 0.3 * min(found.mu_star[:10]))
        self.assertLess(max(found.sigma[7:10]), 0.5 * min(found.sigma[:6]))

    def test_hidden_parameters_of_random_trees_are_recovered(self) -> None:
        inside, width, samples = script("calibration").calibrate()
        self.assertEqual(len(samples), 20)
        self.assertTrue(82 <= inside <= 97, inside)
        self.assertLess(width, 1 / 3)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all sweep")
    def test_long_patterns_filter_the_sets_and_the_planted_one_survives(self) -> None:
        module = script("patterns")
        report = module.filtered()
        self.assertEqual(report.sets, 10_000)
        self.assertGreaterEqual(len(report.filters), 4)
        self.assertGreaterEqual(len(report.held_out), 2)
        self.assertTrue(report.planted_survives)
        self.assertLess(len(report.survivors), 0.05 * report.sets)
        self.assertGreater(len(report.survivors), 3)
        # the survivors foretell patterns that have not filtered them
        self.assertGreater(report.hit_rate, 3 * report.hit_rate_of_all)
        # they lie around the planted set, which is none of them
        planted = NUMPY.array([module.PLANTED[name] for name in module.PLAN["parameters"]])
        self.assertTrue((report.survivors.min(axis=0) < planted).all() and (planted < report.survivors.max(axis=0)).all())

    def test_measured_trees_are_likeliest_near_the_set_that_made_them(self) -> None:
        module = script("measured")
        found = module.compared()
        self.assertEqual((found.names, found.measures), (["branch", "length"], ["axes", "trunk", "internode"]))
        self.assertEqual((found.parameters.shape, set(found.replicates)), ((81, 2), {60}))
        true = NUMPY.array([module.TRUE[name] for name in found.names])
        nearest = int(abs(NUMPY.log(found.parameters / true)).sum(axis=1).argmin())
        likelihood = found.log_likelihood
        self.assertLess(likelihood[found.best] - likelihood[nearest], 8)
        self.assertLess((likelihood >= likelihood[nearest]).mean(), 0.15)
        self.assertTrue((found.low[found.best] < found.measured_mean * 1.25).all())

    def test_a_response_surface_has_its_parameters_as_axes(self) -> None:
        eta, share, tips = script("sensitivity").response()
        self.assertEqual((eta[0], eta[-1], share[0], share[-1]), (0.8, 0.95, 0.5, 0.8))
        with espalier.Model(GALLERY / "borchert-honda", parameters=["ETA", "LAMBDA"], measures={"tips": {"count": "A"}},
                            steps=120, program=program()) as model:
            self.assertEqual(tips[5, 7], model([eta[5], share[7]]))


@unittest.skipIf(NUMPY is None, "NumPy is not installed")
class Measured(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def file(self, name: str, text: str) -> Path:
        (self.folder / name).write_text(text, encoding="utf-8")
        return self.folder / name

    def test_a_comparison_is_that_of_the_formulas(self) -> None:
        # 2 sets of 3 replicates; the measured values are 4 and 7
        columns = {"run": range(1, 8), "seed": [1] * 7, "p": [1, 2, 1, 2, 1, 2, 2], "x": [3, 10, 5, 10, 10, 10, 99]}
        results = espalier.sweep.Results({name: NUMPY.array(values, dtype=float) for name, values in columns.items()},
                                         [""] * 6 + ["failed"], ["p"], ["x"])
        found = espalier.measured.compare(results, {"x": NUMPY.array([4.0, math.nan, 7.0]), "tree": 0})
        self.assertEqual((found.parameters.tolist(), found.replicates.tolist()), ([[1], [2]], [3, 3]))
        self.assertEqual((found.mean[0, 0], found.measured_mean[0]), (6, 5.5))
        # deviations -3, -1, 4: s^2 = 13; t of 2 degrees of freedom at 0.975 is 4.302653
        s = math.sqrt(13)
        self.assertAlmostEqual(found.high[0, 0] - 6, 4.302652729911275 * s / math.sqrt(3), places=6)
        self.assertAlmostEqual(6 - found.low[0, 0], 4.302652729911275 * s / math.sqrt(3), places=6)
        self.assertAlmostEqual(found.rmse[0, 0], math.sqrt((4 + 1) / 2), places=12)
        normal = sum(-0.5 * (y - 6) ** 2 / 13 - math.log(s) - 0.5 * math.log(2 * math.pi) for y in (4, 7))
        self.assertAlmostEqual(found.log_likelihood[0], normal, places=12)
        # no spread: impossible, unless the measuring has an error
        self.assertEqual((found.log_likelihood[1], found.best), (-math.inf, 0))
        loose = espalier.measured.compare(results, {"x": [4.0, 7.0]}, error={"x": 2.0})
        self.assertAlmostEqual(loose.log_likelihood[1],
                               sum(-0.5 * ((y - 10) / 2) ** 2 - math.log(2 * math.sqrt(2 * math.pi)) for y in (4, 7)), places=12)

    def test_an_mtg_file_has_the_measures_of_the_plant_that_wrote_it(self) -> None:
        measures = {name: {"mtg": name, "of": "I"} for name in
                    ("vertices", "axes", "tips", "verticesPerAxis", "maximumOrder", "depth", "strahler")}
        measures.update({"first": {"mtg": "tips", "of": "I", "order": 1}, "n": {"count": "I"}})
        plan = self.file("plan.json", json.dumps({
            "model": str(CHAPTER / "tree.l"), "measures": measures, "runs": {"rows": [{"seed": 3}, {"seed": 4}]},
            "files": [{"name": "tree.mtg", "every": 1}]}))
        espalier.sweep.run(plan, self.folder / "r.sqlite", program=program())
        simulated = espalier.sweep.results(self.folder / "r.sqlite", program=program())
        files = sorted((self.folder / "r.files").iterdir())
        self.assertEqual(len(files), 2)
        found = espalier.measured.mtg(files, {**measures, "height": {"plant": "height"}})
        self.assertEqual(sorted(found), sorted(measures))
        for name in measures:
            self.assertEqual(found[name].tolist(), simulated[name].tolist(), name)
        self.assertGreater(found["strahler"][0], 1)

    def test_an_mtg_file_of_another_program(self) -> None:
        # two plants; columns to the right are daughters, `^` continues, several entities on one line
        file = self.file("t.mtg", "CODE:\tFORM-A\n\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n$\t0\tFREE\t"
                         "FREE\tIMPLICIT\nP\t1\tFREE\tFREE\tEXPLICIT\nU\t2\tFREE\tFREE\tEXPLICIT\nL\t2\tFREE\tFREE\tEXPLICIT\n\n"
                         "DESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\nU\tU\t+\t?\n\nFEATURES:\nNAME\tTYPE\nlength\tREAL\n\nMTG:\n"
                         "ENTITY-CODE\t\t\tlength\n/P1/U1<U2\t\t\t1\n\t+U3<U4\t\t2\n\t+L1\t\t3\n^<U5\t\t\t4\n/P2/U1\t\t\t5\n")
        found = espalier.measured.mtg(file, {"u": {"count": "U"}, "axes": {"mtg": "axes", "of": "U"}, "all": {"mtg": "vertices"},
                                             "depth": {"mtg": "depth", "of": "U"}})
        self.assertEqual({name: values[0] for name, values in found.items()}, {"u": 6, "axes": 3, "all": 7, "depth": 4})

    def test_axes_of_an_mtg_file_branch_off_with_their_first_unit(self) -> None:
        head = ("CODE:\tFORM-A\n\nCLASSES:\nSYMBOL\tSCALE\n$\t0\nP\t1\nA\t2\nU\t3\n\nDESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\n\n"
                "FEATURES:\nNAME\tTYPE\n\nMTG:\nENTITY-CODE\n")
        measures = {"u": {"count": "U"}, "axes": {"mtg": "axes", "of": "U"}, "order": {"mtg": "maximumOrder", "of": "U"}}
        # in one line, and with the axis in a line of its own
        for graph in ("/P1/A1/U1\n\t+A2/U1<U2\n^<U2\n", "/P1/A1/U1\n\t+A2\n\t\t/U1<U2\n^<U2\n"):
            found = espalier.measured.mtg(self.file("a.mtg", head + graph), measures)
            self.assertEqual({name: values[0] for name, values in found.items()}, {"u": 4, "axes": 2, "order": 1}, graph)

    def test_tables_of_spreadsheets(self) -> None:
        for text in ("tree,axes,l\nA,3,1.5\nB,,2\n", "\ufefftree;axes;l\r\nA;3;1,5\r\nB;;2\r\n", "tree\taxes\tl\nA\t3\t1.5\n\nB\t\t2\n",
                     "tree,axes,l\nA,3,1.5\nB,NA,2\n"):
            found = espalier.measured.table(self.file("m.csv", text))
            self.assertEqual(list(found), ["axes", "l"])
            self.assertEqual((found["axes"][0], math.isnan(found["axes"][1]), found["l"].tolist()), (3, True, [1.5, 2]))

    def test_mistakes(self) -> None:
        results = espalier.sweep.Results({"run": NUMPY.array([1]), "seed": NUMPY.array([1]), "axes": NUMPY.array([3.0])}, [""],
                                         [], ["axes"])
        for call, message in ((lambda: espalier.measured.compare(results, {"axs": [1.0]}), "No measured column has the name"),
                              (lambda: espalier.measured.compare(results, {"axes": [1.0]}, measures=["axs"]), "Did you mean 'axes'"),
                              (lambda: espalier.measured.compare(results, {"axes": [math.nan]}), "has no number"),
                              (lambda: espalier.measured.compare(results, {"axes": [1.0]}, error={"x": 1.0}), "no measure 'x'"),
                              (lambda: espalier.measured.table(self.file("m.csv", "axes\n")), "has no measured plant"),
                              (lambda: espalier.measured.table(self.file("m.csv", "a,b\n1\n")), "row 2 has 1 cells"),
                              # a word in a column of numbers, no text, a folder, an endless cell, and a copy that was cut
                              (lambda: espalier.measured.table(self.file("m.csv", "a,l\n1,1.5\n2,l.5\n3,2\n")), "'l' of row 3 is 'l.5', no finite number"),
                              (lambda: espalier.measured.table(self.file("m.csv", "a\n1\n2\n1e999\n")), "'a' of row 4 is '1e999'"),
                              (lambda: espalier.measured.table(CHAPTER), "is no file"),
                              (lambda: espalier.measured.table(self.file("m.csv", "a\n" + "1" * 200_000 + "\n")), "is no table"),
                              (lambda: espalier.measured.mtg(self.file("m.mtg", "CODE:\tFORM-A\n# Espalier: the last line is '# end'\nMTG:\nENTITY-CODE\n/P1\n"),
                                                             {"n": {"count": "F"}}), "ends before its last line '# end'"),
                              (lambda: espalier.measured.mtg(self.file("m.mtg", "a,b\n"), {"n": {"count": "F"}}), "is no MTG file"),
                              (lambda: espalier.measured.mtg([], {"n": {"mtg": "axis"}}), "Did you mean 'axes'"),
                              (lambda: espalier.measured.mtg([], {"n": {"plant": "height"}}), "No measure is")):
            with self.assertRaisesRegex(ValueError, message):
                call()


@unittest.skipIf(NUMPY is None, "NumPy is not installed")
class ModelAsFunction(unittest.TestCase):
    MEASURES = {"trunk": {"sum": "l", "of": "I(o,l)", "where": "o == 0"}, "n": {"count": "I"}}

    def model(self, **more: Any) -> espalier.Model:
        made = espalier.Model(CHAPTER / "tree.l", parameters=["length", "branch"], measures=self.MEASURES, steps=6,
                              program=program(), **more)
        self.addCleanup(made.close)
        return made

    def test_rows_in_columns_out(self) -> None:
        model = self.model(defines={})
        self.assertEqual((model.parameters, model.measures), (["length", "branch"], ["trunk", "n"]))
        values = model.run([[1, 0.3], [2, 0.3], [2, 0.3]], seeds=[5, 5, 6])
        self.assertEqual(values.shape, (3, 2))
        self.assertAlmostEqual(values[1, 0], 2 * values[0, 0], places=12)
        self.assertNotEqual(values[1, 0], values[2, 0])
        # one set as a function, and the same plan by the command
        self.assertEqual(list(model([1, 0.3])), list(model.run([[1, 0.3]])[0]))
        with tempfile.TemporaryDirectory() as folder:
            plan = json.loads(model.plan)
            plan["runs"] = {"rows": [{"length": 1, "branch": 0.3, "seed": 5}]}
            Path(folder, "plan.json").write_text(json.dumps(plan), encoding="utf-8")
            self.assertEqual(swept(Path(folder, "plan.json"))["trunk"][0], values[0, 0])

    def test_a_failed_run_is_a_row_of_nan_with_its_message(self) -> None:
        model = self.model(limits={"modules": 30})
        values = model.run([[1, 0.0], [1, 0.9]])
        self.assertTrue(NUMPY.isfinite(values[0]).all() and NUMPY.isnan(values[1]).all())
        self.assertEqual([row for row, _ in model.failures], [1])
        self.assertIn("modules", model.failures[0][1])

    def test_a_machine_over_ssh_makes_the_runs(self) -> None:
        # a stand-in for ssh: as the real one, it gives the words after the host to a shell of another working folder
        with tempfile.TemporaryDirectory() as folder:
            ssh = Path(folder, "ssh")
            ssh.write_text('#!/bin/sh\necho "$@" >"$0.log"\nwhile [ "$1" != -- ]; do shift; done\nshift 2\ncd / && exec sh -c "$*"\n',
                           encoding="utf-8")
            ssh.chmod(0o755)
            here = self.model()
            with unittest.mock.patch.dict(os.environ, {"PATH": f"{folder}:{os.environ['PATH']}"}):
                there = self.model(host="node7")
            rows = [[1, 0.3], [2, 0.2]]
            self.assertEqual(there.run(rows, seeds=[1, 2]).tolist(), here.run(rows, seeds=[1, 2]).tolist())
            self.assertIn("-- node7 ", Path(folder, "ssh.log").read_text(encoding="utf-8"))

    def test_what_goes_wrong_in_runs_is_a_python_warning_once(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "m.l")
            file.write_text("#define Z 0\nLsystem: 1\nderivation length: 2\nStart: { w = 1; }\nAxiom: A(1)\n"
                            "A(x) : w < 0 --> A(log(w))\nA(x) --> A(x/Z)\nB(x) --> B\nendlsystem\n", encoding="utf-8")
            measures = {"n": {"count": "A"}, "b": {"mean": "x", "of": "A(x)", "where": "x > 2"}}
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                with espalier.Model(file, parameters=["w"], measures=measures, program=program(), workers=1) as model:
                    model.run([[1.0], [-1.0], [2.0]])
                    model.run([[1.0], [-1.0], [2.0]])
                texts = [str(one.message) for one in caught]
                self.assertTrue(all(one.category is espalier.RunWarning for one in caught))
                self.assertTrue(any("m.l:7:" in text and "division by 0" in text for text in texts), texts)
                self.assertEqual([text for text in texts if "runs failed" in text][0][:24], "1 of 3 runs failed; thei")
                self.assertIn("The measure 'b' has no value in 2 of 3 runs; it is NaN there. The first is row 0.", texts)
                self.assertEqual(len(texts), len(set(texts)))
                self.assertEqual(sum("has no value" in text for text in texts), 1)
                self.assertTrue(any("division by 0" in text for text in model.warnings), model.warnings)
                caught.clear()
                plan = Path(folder, "plan.json")
                plan.write_text(json.dumps({"model": "m.l", "measures": measures, "runs": {"rows": [{"w": 1}, {"w": -1}]}}),
                                encoding="utf-8")
                espalier.sweep.run(plan, f"{folder}/r.sqlite", program=program())
                self.assertIn("1 of 2 runs failed. The first is run 2", str(caught[0].message))

    def test_mistakes(self) -> None:
        with self.assertRaisesRegex(espalier.ServerFailed, "parameters.lenght.*Did you mean 'length'"):
            espalier.Model(CHAPTER / "tree.l", parameters=["lenght"], measures=self.MEASURES, program=program())
        model = self.model()
        for wrong in ([1, 2], [[1, 2, 3]], [[1, math.nan]]):
            with self.assertRaises(ValueError):
                model.run(wrong)
        with self.assertRaises(ValueError):
            model.run([[1, 0.3]], seeds=[-1])
        self.assertEqual(model.run(NUMPY.empty((0, 2))).shape, (0, 2))
        model.close()
        with self.assertRaises(espalier.EspalierError):
            model.run([[1, 0.3]])


@unittest.skipUnless(shutil.which("Rscript"), "R is not installed (Debian: r-base-core)")
class ModelInR(unittest.TestCase):
    def run_r(self, code: str) -> "subprocess.CompletedProcess[str]":
        source = f'source("{PACKAGE.parent / "r" / "R" / "sweep.R"}"); '
        return subprocess.run(["Rscript", "-e", source + code], capture_output=True, text=True,
                              env=variables(ESPALIER_PROGRAM=program()), stdin=subprocess.DEVNULL)

    def test_a_data_frame_in_and_a_data_frame_out(self) -> None:
        call = ("espalier_run('{}', data.frame(length = c(1, 2, 0.1 + 0.2), seed = 9), "
                "'{{\"trunk\": {{\"sum\": \"l\", \"of\": \"I(o,l)\", \"where\": \"o == 0\"}}}}', '\"steps\": 5')")
        done = self.run_r("x <- " + call.format(CHAPTER / "tree.l") +
                          "; cat(names(x), x$length[3] == 0.1 + 0.2, x$trunk[2] / x$trunk[1])")
        self.assertEqual((done.returncode, done.stdout), (0, "run seed length trunk error TRUE 2"), done.stderr)
        done = self.run_r(call.format(CHAPTER / "nothing.l"))
        self.assertIn("there is no file", done.stderr)


if __name__ == "__main__":
    sys.exit(unittest.main())
