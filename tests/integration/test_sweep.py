"""Sweeps: results that depend on nothing but the plan, killed and merged, measures against an independent computation."""

import csv
import hashlib
import io
import json
import math
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional

from support import GALLERY, espalier, program, variables

# a tree whose numbers are easy to compute: n axes of segments that shrink by R; the variable w scales their width
TREE = """#define R 0.5
#define TWICE(x) (2*(x))
Lsystem: 1
derivation length: 4
Start: { w = 3; half = w/2; }
Axiom: A(1)
A(l) : R < 0 --> A(log(R))
A(l) --> F(l,half*l)[+A(l*R)]A(l*R)
endlsystem
"""
RANDOM = """#define P 0.5
Lsystem: 1
derivation length: 12
Axiom: A
A --> F[+A]A : P
A --> F : 1-P
endlsystem
"""


class Sweep(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        self.write("tree.l", TREE)
        self.write("random.l", RANDOM)

    def write(self, name: str, text: str) -> str:
        (self.folder / name).write_text(text, encoding="utf-8")
        return str(self.folder / name)

    def plan(self, name: str = "plan.json", **members: Any) -> str:
        return self.write(name, json.dumps(members))

    def file(self, name: str) -> str:
        return str(self.folder / name)

    def sweep(self, *arguments: str, status: int = 0) -> "subprocess.CompletedProcess[str]":
        return espalier("sweep", *arguments, status=status)

    def rows(self, results: str) -> List[Dict[str, str]]:
        return list(csv.DictReader(io.StringIO(self.sweep("export", results).stdout)))

    def hash(self, results: str) -> str:
        return hashlib.sha256(self.sweep("export", results).stdout.encode()).hexdigest()

    def results(self, name: str = "r.sqlite", *more: str, **members: Any) -> List[Dict[str, str]]:
        self.sweep(self.plan(**members), "-o", self.file(name), "--quiet", *more)
        return self.rows(self.file(name))

    def mistake(self, **members: Any) -> str:
        return self.sweep(self.plan(**members), "-o", self.file("x.sqlite"), status=1).stderr

    def test_measures_are_those_of_the_string(self) -> None:
        # step k adds 2^(k-1) segments of length R^(k-1), which are half*l wide
        (row,) = self.results(
            model="tree.l", runs={"rows": [{"R": 0.25, "w": 8}]},
            measures={"segments": {"count": "F"}, "all": {"count": "*"}, "length": {"sum": "l", "of": "F(l,w)"},
                      "mean": {"mean": "w*w", "of": "F(l,w)"}, "least": {"minimum": "l", "of": "F(l,w)"},
                      "most": {"maximum": "l", "of": "F(l,w)", "where": "l < 1"}, "middle": {"median": "l", "of": "F(l,w)"},
                      "quarter": {"quantile": 0.25, "value": "l", "of": "F(l,w)"},
                      "deviation": {"deviation": "l", "of": "F(l,w)"},
                      "macro": {"sum": "TWICE(l)+R+half", "of": "F(l,v)"},
                      "early": {"count": "F", "at": [1, 2]}, "half": {"variable": "half"},
                      "tips": {"count": "A(l)", "where": "l < 1"}, "axes": {"mtg": "axes", "of": "F"}})
        lengths = [0.25 ** k for k in range(4) for _ in range(2 ** k)]
        value = {name: float(text) for name, text in row.items() if text}
        self.assertEqual(value["segments"], 15)
        self.assertEqual(value["all"], 15 + 16 + 15 * 3)  # F, A, and [ + ] of each segment
        self.assertEqual(value["length"], sum(lengths))
        self.assertAlmostEqual(value["mean"], sum((4 * x) ** 2 for x in lengths) / 15, places=12)
        self.assertEqual((value["least"], value["most"], value["middle"]), (0.25 ** 3, 0.25, 0.25 ** 3))
        self.assertEqual(value["quarter"], sorted(lengths)[3] + 0.5 * (sorted(lengths)[4] - sorted(lengths)[3]))
        mean = sum(lengths) / 15
        self.assertAlmostEqual(value["deviation"], math.sqrt(sum((x - mean) ** 2 for x in lengths) / 14), places=12)
        self.assertAlmostEqual(value["macro"], sum(2 * x + 0.25 + 4 for x in lengths), places=12)
        self.assertEqual((value["early_1"], value["early_2"], value["half"], value["tips"]), (1, 3, 4, 16))
        # the stem, and a branch at each segment but the last of an axis: 4 orders
        self.assertEqual(value["axes"], 8)

    def test_results_do_not_depend_on_workers_slices_or_order(self) -> None:
        members = dict(model="random.l", parameters={"P": {"uniform": [0.3, 0.6]}},
                       runs={"design": "latin-hypercube", "count": 40}, replicates=3,
                       measures={"n": {"count": "F"}, "height": {"plant": "height"}, "order": {"mtg": "maximumOrder"}})
        plan = self.plan(**members)
        for workers in (1, 3):
            self.sweep(plan, "-o", self.file(f"{workers}.sqlite"), "--workers", str(workers), "--quiet")
        for k in (3, 1, 2):
            self.sweep(plan, "-o", self.file(f"part-{k}.sqlite"), "--slice", f"{k}/3", "--quiet")
        self.assertIn("lacks 80 of 120 runs", self.sweep("export", self.file("part-1.sqlite"), status=1).stderr)
        results = Path(self.file("part-1.sqlite"))
        before = results.read_bytes()
        self.assertIn("holds the results", self.sweep("export", str(results), "--partial", "-o", str(results), status=1).stderr)
        self.assertEqual(results.read_bytes(), before)
        self.sweep("merge", *[self.file(f"part-{k}.sqlite") for k in (2, 3, 1)], "-o", self.file("all.sqlite"))
        hashes = {self.hash(self.file(name)) for name in ("1.sqlite", "3.sqlite", "all.sqlite")}
        self.assertEqual(len(hashes), 1)
        rows = self.rows(self.file("1.sqlite"))
        self.assertEqual([row["run"] for row in rows], [str(i) for i in range(1, 121)])
        self.assertEqual(len({row["n"] for row in rows[:3]} | {row["n"] for row in rows[3:6]}) > 1, True)
        # a run alone gives the string of `derive`
        row = rows[17]
        alone = espalier("derive", self.file("random.l"), "--define", "P=" + row["P"], "--seed", row["seed"], "--quiet").stdout
        self.assertEqual(alone.count("F"), int(row["n"]))

    def test_a_run_with_an_environment_does_not_depend_on_the_runs_before_it(self) -> None:
        # a worker sets one simulation and its environment back for each run; a slice of one run makes them anew
        for model in ("crowded-bush", "leaf-economy", "roots-in-soil", "self-organizing-tree"):
            plan = self.plan(model=str(GALLERY / model), steps=5, replicates=4,
                             measures={"n": {"count": "*"}, "height": {"plant": "height"}, "low": {"plant": "lowest"}})
            self.sweep(plan, "-o", self.file(f"{model}.sqlite"), "--workers", "1", "--quiet")
            parts = [self.file(f"{model}-{k}.sqlite") for k in range(1, 5)]
            for k, part in enumerate(parts, 1):
                self.sweep(plan, "-o", part, "--slice", f"{k}/4", "--quiet")
            self.sweep("merge", *parts, "-o", self.file(f"{model}-all.sqlite"))
            self.assertEqual(self.hash(self.file(f"{model}.sqlite")), self.hash(self.file(f"{model}-all.sqlite")), model)

    def test_a_variable_replaces_what_start_assigns_and_start_computes_with_it(self) -> None:
        rows = self.results(model="tree.l", runs={"rows": [{"w": 10}, {"w": 20}]},
                            measures={"half": {"variable": "half"}, "width": {"maximum": "d", "of": "F(l,d)"}})
        self.assertEqual([(row["half"], row["width"]) for row in rows], [("5", "5"), ("10", "10")])

    def kill_and_continue(self, kills: int) -> None:
        plan = self.plan(model="random.l", parameters={"P": {"uniform": [0.45, 0.55]}},
                         runs={"design": "random", "count": min(4000 * kills, 100_000)}, measures={"n": {"count": "F"}}, steps=14)
        draw = random.Random(1)
        command = [program(), "sweep", plan, "-o", self.file("killed.sqlite"), "--quiet", "--workers", "2"]
        results = self.file("killed.sqlite")
        before = 0
        progresses = 0
        for kill in range(kills):
            size = size_of(results)
            started = subprocess.Popen(command, env=variables(), stdin=subprocess.DEVNULL)
            # every second kill comes after rows were written, however slow the machine is
            while kill % 2 == 1 and size_of(results) <= size and started.poll() is None:
                time.sleep(0.01)
            time.sleep(draw.uniform(0.02, 0.25))
            started.send_signal(signal.SIGKILL)
            started.wait()
            if Path(results).exists():
                table = self.sweep("export", results, "--partial").stdout if sqlite_has_tables(results) else "\n"
                count = len(table.splitlines()) - 1
                self.assertGreaterEqual(count, before)
                progresses += count > before
                before = count
        self.assertGreater(progresses, 0)
        self.sweep(plan, "-o", self.file("killed.sqlite"), "--quiet")
        self.sweep(plan, "-o", self.file("whole.sqlite"), "--quiet")
        self.assertEqual(self.hash(self.file("killed.sqlite")), self.hash(self.file("whole.sqlite")))

    def test_a_killed_sweep_continues_and_no_run_is_lost_or_doubled(self) -> None:
        self.kill_and_continue(10)

    def test_a_plan_may_come_from_standard_input_and_results_are_no_text(self) -> None:
        plan = self.plan(model=self.file("random.l"), measures={"n": {"count": "F"}})
        with open(plan, "rb") as text:
            subprocess.run([program(), "sweep", "-", "-o", self.file("a.sqlite"), "--quiet"], stdin=text, check=True, timeout=120)
        self.sweep(plan, "-o", self.file("b.sqlite"), "--quiet")
        self.assertEqual(self.hash(self.file("a.sqlite")), self.hash(self.file("b.sqlite")))
        self.assertIn("espalier sweep export results.sqlite -o table.csv", self.sweep(plan, "-o", "table.csv", status=2).stderr)

    def test_a_pipe_that_carries_something_else_says_so(self) -> None:
        plan = self.plan(model="random.l", parameters={"P": {"uniform": [0.3, 0.6]}},
                         measures={"n": {"count": "F"}})
        for sent in (b"xx\n", b'{"n":1}\n', b"\xff" * 16):
            done = subprocess.run([program(), "sweep", plan, "--pipe"], input=sent, capture_output=True, check=False, timeout=120)
            self.assertEqual(done.returncode, 1, sent)
            self.assertIn(b"meant for espalier.Model", done.stderr)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all sweep")
    def test_long_a_sweep_that_is_killed_a_hundred_times(self) -> None:
        self.kill_and_continue(100)

    def test_a_run_that_fails_is_recorded_and_the_others_go_on(self) -> None:
        plan = self.plan(model="tree.l", runs={"rows": [{"R": r} for r in (0.5, -30.0, 0.6)]},
                         measures={"n": {"count": "F"}})
        done = self.sweep(plan, "-o", self.file("r.sqlite"))
        self.assertIn("1 of 3 runs failed. The first is run 2: step 1", done.stderr)
        rows = self.rows(self.file("r.sqlite"))
        self.assertEqual([row["n"] for row in rows], ["15", "", "15"])
        self.assertRegex(rows[1]["error"], r"step 1.*'A'.*tree\.l:7")

    def test_a_warning_of_the_model_or_of_a_measure_is_shown(self) -> None:
        model = self.write("zero.l", "Lsystem: 1\nderivation length: 2\nAxiom: A(1)\nA(x) --> A(x/(x-1))\nendlsystem\n")
        done = self.sweep(self.plan(model=model, measures={"n": {"count": "A"}}, replicates=5), "-o", self.file("a.sqlite"))
        self.assertIn("warning in run 1 and perhaps in others: ", done.stderr)
        self.assertRegex(done.stderr, r"zero.l:4:12: warning: division by 0; the divisor counts as 1")
        done = self.sweep(self.plan(model="tree.l", measures={"n": {"mean": "w/(l-l)", "of": "F(l,w)"}}), "-o",
                          self.file("b.sqlite"))
        self.assertRegex(done.stderr, r"warning in run 1 .*division by 0(.|\n)*w/\(l-l\)")

    def test_a_warning_of_the_compiler_about_the_values_of_a_run_is_shown(self) -> None:
        self.write("length.l", "#define N 3\nLsystem: 1\nderivation length: N\nAxiom: A\nA --> AF\nendlsystem\n")
        plan = self.plan(model="length.l", runs={"rows": [{"N": 3}, {"N": -2}]}, measures={"f": {"count": "F"}})
        done = self.sweep(plan, "-o", self.file("r.sqlite"))
        self.assertRegex(done.stderr, r"warning in run 2 .*length\.l:3:20: warning: the value of 'derivation length:' is out of range")
        self.assertEqual(done.stderr.count("out of range"), 1)

    def test_a_file_of_results_without_its_second_file_says_so(self) -> None:
        self.results("r.sqlite", model="random.l", replicates=2000, measures={"n": {"count": "F"}})
        # what is on the disk while the newest pages are in the second file
        Path(self.file("alone.sqlite")).write_bytes(Path(self.file("r.sqlite")).read_bytes()[:4096])
        done = self.sweep("export", self.file("alone.sqlite"), "--partial", status=1)
        self.assertIn("or was copied without", done.stderr)

    def test_a_measure_without_a_value_is_named_with_the_number_of_runs(self) -> None:
        plan = self.plan(model="tree.l", runs={"rows": [{"w": w} for w in (4, 1, 2, 9)]},
                         measures={"thick": {"mean": "d", "of": "F(l,d)", "where": "d > 1"}, "n": {"count": "F"}})
        done = self.sweep(plan, "-o", self.file("r.sqlite"))
        self.assertIn("the measure 'thick' has no value in 2 of 4 runs. The first is run 2\n", done.stderr)
        self.assertNotIn("'n' has no value", done.stderr)

    def test_a_measure_after_the_last_step(self) -> None:
        measures = {"n": {"count": "F", "at": [2, 9]}}
        self.assertIn("measures.n.at: there is no step 9: the derivation length of the model is 4. Give a step up to that, or more "
                      "steps with the plan's member 'steps'", self.mistake(model="tree.l", measures=measures))
        self.assertIn("measures.n.at: expected a whole number from 0 to 5, found 9",
                      self.mistake(model="tree.l", steps=5, measures=measures))
        self.results("long.sqlite", model="tree.l", steps=9, measures=measures)
        # a macro that is the length: some runs are shorter
        self.write("length.l", "#define N 3\nLsystem: 1\nderivation length: N\nAxiom: A\nA --> AF\nendlsystem\n")
        done = self.sweep(self.plan(model="length.l", runs={"rows": [{"N": 9}, {"N": 4}]}, measures=measures), "-o",
                          self.file("r.sqlite"))
        self.assertIn("warning in run 2 and perhaps in others: measures.n.at: the run has ended with step 4, so that there is no "
                      "value of step 9", done.stderr)
        self.assertEqual([(row["n_2"], row["n_9"]) for row in self.rows(self.file("r.sqlite"))], [("2", "9"), ("2", "")])

    def test_an_environment_is_configured_by_pointers_and_starts_anew_in_each_run(self) -> None:
        rows = self.results(
            model=str(GALLERY / "branch-tiers" / "branch-tiers.l"), environment={"type": "honda", "radius": 0.5}, steps=6,
            parameters={"reach": {"environment": "/radius"}}, runs={"rows": [{"reach": 0.01}, {"reach": 2}, {"reach": 0.010001}]},
            measures={"n": {"count": "*"}})
        self.assertNotEqual(rows[0]["n"], rows[1]["n"])
        self.assertEqual(rows[0]["n"], rows[2]["n"])
        alone = self.write("honda.json", json.dumps({"type": "honda", "radius": 2}))
        text = espalier("run", str(GALLERY / "branch-tiers" / "branch-tiers.l"), "--environment", alone, "--steps", "6",
                        "--seed", "1", "--quiet", "-o", self.file("a.csv"))
        self.assertEqual(text.returncode, 0)

    def test_mistakes_of_a_plan(self) -> None:
        n = {"n": {"count": "F"}}
        self.assertIn("parameters.Rr: the model has no #define and no variable 'Rr'. Did you mean 'R'?",
                      self.mistake(model="tree.l", runs={"rows": [{"Rr": 1}]}, measures=n))
        self.assertIn("measures.n: the model has no module 'G'", self.mistake(model="tree.l", measures={"n": {"count": "G"}}))
        self.assertIn("measures.n: unknown name 'ww'",
                      self.mistake(model="tree.l", measures={"n": {"sum": "ww", "of": "F(l,w)"}}))
        for expression in ("l --> F", "l) : (1", "l; x = 2", "ran(1)", "{ l }", ""):
            self.mistake(model="tree.l", measures={"n": {"sum": expression, "of": "F(l,w)"}})
        self.assertIn("there is no file 'nothing.l'", self.mistake(model="nothing.l", measures=n))
        self.assertIn("there is no number at '/radios/1' of the environment", self.mistake(
            model="tree.l", environment={"type": "honda"}, parameters={"x": {"environment": "/radios/1"}},
            runs={"rows": [{"x": 1}]}, measures=n))
        published = str(GALLERY / "branch-tiers" / "branch-tiers.l")
        self.assertIn("is a file or a program without JSON, whose numbers no plan can change: give 'environment' in the plan",
                      self.mistake(model=published, parameters={"/radius": {"uniform": [0, 1]}},
                                   runs={"design": "random", "count": 2}, measures=n))
        forest = self.write("forest.json", json.dumps({"models": [{"name": "t", "file": "tree.l"}], "plants": [{}]}))
        self.assertIn("this is a JSON file, not a model", self.mistake(model=forest, measures=n))
        self.write("comma.csv", "R;w\n0,5;1\n")
        self.assertIn("comma.csv:2: '0,5' in the column 'R' is not a number: give a finite number in every cell, with a point",
                      self.mistake(model="tree.l", runs={"table": "comma.csv"}, measures=n))
        self.assertIn("runs: missing", self.mistake(model="tree.l", parameters={"R": {"uniform": [0, 1]}}, measures=n))
        self.assertIn("two columns 'N'", self.mistake(model="tree.l", runs={"rows": [{"R": 1}]},
                                                      measures={"n": n["n"], "N": n["n"]}))
        self.assertIn("error", self.mistake(model="tree.l", defines={"R": "(("}, measures=n))

    def test_results_of_another_plan_model_or_program_are_not_touched(self) -> None:
        measures = {"n": {"count": "F"}}
        self.results("r.sqlite", model="tree.l", measures=measures)
        other = self.plan("other.json", model="tree.l", seed=2, measures=measures)
        self.assertIn("its plan differs", self.sweep(other, "-o", self.file("r.sqlite"), status=1).stderr)
        self.write("tree.l", TREE + "\n")
        done = self.sweep(self.file("plan.json"), "-o", self.file("r.sqlite"), status=1)
        self.assertIn("the model, its environment or the version of the program differs", done.stderr)
        self.sweep(self.file("plan.json"), "-o", self.file("new.sqlite"), "--quiet")
        done = self.sweep("merge", self.file("r.sqlite"), self.file("new.sqlite"), "-o", self.file("m.sqlite"), status=1)
        self.assertIn("is no part of the sweep", done.stderr)
        self.write("no.sqlite", "text " * 1000)
        self.assertIn("is no file of results", self.sweep("export", self.file("no.sqlite"), status=1).stderr)
        self.assertIn("there is no file", self.sweep("export", self.file("none.sqlite"), status=1).stderr)

    def test_a_full_disk_loses_no_run(self) -> None:
        plan = self.plan(model="random.l", parameters={"P": {"uniform": [0.3, 0.5]}}, runs={"design": "random", "count": 6000},
                         measures={"n": {"count": "F"}}, steps=6)
        # a limit of 100 kB a file stands for the disk
        done = subprocess.run(["bash", "-c", f"ulimit -f 100; exec {program()} sweep {plan} -o {self.file('r.sqlite')} --quiet"],
                              env=variables(), capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("the same command continues", done.stderr)
        self.sweep(plan, "-o", self.file("r.sqlite"), "--quiet")
        self.sweep(plan, "-o", self.file("whole.sqlite"), "--quiet")
        self.assertEqual(self.hash(self.file("r.sqlite")), self.hash(self.file("whole.sqlite")))
        self.assertIn("a folder that exists", self.sweep(plan, "-o", self.file("no/r.sqlite"), status=1).stderr)

    def test_an_interrupt_lets_the_running_plants_finish(self) -> None:
        plan = self.plan(model="random.l", replicates=2_000_000, measures={"n": {"count": "F"}})
        process = subprocess.Popen([program(), "sweep", plan, "-o", self.file("r.sqlite")], env=variables(),
                                   stderr=subprocess.PIPE, text=True)
        while not Path(self.file("r.sqlite")).exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertIn("of 2000000 runs. The same command continues", errors)

    def test_one_program_at_a_time_writes_a_file(self) -> None:
        self.results("r.sqlite", model="tree.l", measures={"n": {"count": "F"}})
        connection = sqlite3.connect(self.file("r.sqlite"))
        connection.execute("BEGIN EXCLUSIVE")
        done = self.sweep(self.file("plan.json"), "-o", self.file("r.sqlite"), status=1)
        connection.close()
        self.assertIn("another program has", done.stderr)

    def test_files_of_every_second_run_are_kept(self) -> None:
        self.results("r.sqlite", model="tree.l", runs={"rows": [{"R": 0.1 * k} for k in range(1, 6)]},
                     measures={"n": {"count": "F"}}, files=[{"name": "tree.string", "every": 2}])
        self.assertEqual(sorted(os.listdir(self.file("r.files"))), ["tree-000002.string", "tree-000004.string"])

    def test_the_schema_has_the_members_that_the_reader_knows(self) -> None:
        schema = json.loads(self.sweep("--schema").stdout)
        message = self.mistake(model="tree.l", nosuchmember=1, measures={"n": {"count": "F"}})
        listed = " ".join(message.split("Available: ")[1].split()).rstrip(".").split(", ")
        self.assertEqual(sorted(listed), sorted(schema["properties"]))
        message = self.mistake(model="tree.l", measures={"n": {"nosuchmember": "F"}})
        listed = " ".join(message.split("Available: ")[1].split()).rstrip(".").split(", ")
        self.assertEqual(sorted(listed), sorted(schema["$defs"]["measure"]["properties"]))

    def test_without_slurm_the_command_says_what_it_would_submit(self) -> None:
        plan = self.plan(model="tree.l", measures={"n": {"count": "F"}})
        empty = self.folder / "bin"
        empty.mkdir()
        done = espalier("sweep", plan, "-o", self.file("r.sqlite"), "--slurm", "--slices", "3", status=1, PATH=str(empty))
        self.assertIn("Slurm is not here", done.stderr)
        self.assertIn("sbatch --parsable --array=1-3 --export=ALL,ESPALIER_OFFSET=0", done.stderr)
        # the script is what makes the slices
        for k in range(1, 4):
            subprocess.run(["bash", self.file("r.slurm.sh")], check=True, capture_output=True,
                           env=variables(SLURM_ARRAY_TASK_ID=str(k)))
        subprocess.run(["bash", self.file("r.slurm-merge.sh")], check=True, capture_output=True)
        self.assertEqual(len(self.rows(self.file("r.sqlite"))), 1)


def size_of(file: str) -> int:
    return Path(file).stat().st_size if Path(file).exists() else 0


def sqlite_has_tables(file: str) -> bool:
    """Whether the first transaction, which makes the tables, has come to its end."""
    connection: Optional[sqlite3.Connection] = None
    try:
        connection = sqlite3.connect(file)
        return connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 2
    finally:
        if connection is not None:
            connection.close()


if __name__ == "__main__":
    unittest.main()
