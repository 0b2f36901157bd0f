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
        report = script("patterns").filtered()
        self.assertGreaterEqual(len(report.filters), 4)
        self.assertGreaterEqual(len(report.held_out), 2)
        self.assertTrue(report.planted_survives)
        self.assertLess(len(report.survivors), 0.05 * report.sets)
        self.assertGreater(len(report.survivors), 3)
        # the survivors foretell patterns that have not filtered them
        self.assertGreater(report.hit_rate, 3 * report.hit_rate_of_all)


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
        source = f'source("{PACKAGE.parent / "r" / "sweep.R"}"); '
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
