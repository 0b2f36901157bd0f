"""The Basic Model Interface in C++ against the installed package: a driver of a simulation, and a component as an environment."""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, ClassVar, Dict, List

from installation import Installed, run
from support import REPOSITORY, SECONDS, program, stdio, variables
from test_bmi import FUNCTIONS

from espalier import bmi

EXAMPLE = REPOSITORY / "clients" / "bmi" / "example"
MODEL = """#define GROW 0.5
#define UNUSED 1
Lsystem: 1
derivation length: 8
Axiom: [&(90)f(0)]A(1)?E(1)
f(t) --> f(world.time)
A(l) > ?E(x) : x > 0.3 --> F(l*GROW)[+(30)A(l*0.9)?E(1)][-(30)/(90)A(l*0.8)?E(1)]A(l)
?E(x) --> ?E(1)
endlsystem
"""
SETTINGS = {"model": "m.l", "seed": 3, "stepDurationDays": 0.5, "inputs": ["GROW"], "parameters": {"GROW": 0.5}, "environment": "shadow",
            "outputs": ["modules", "height", "count:F", "sum:F:1", "sum:f:1"]}
# every function of the interface, in one piece and in halves; what each says about mistakes
DRIVER = r"""
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include "clients/bmi/espalier_bmi.h"

void say(bmi::Bmi& model) {
  std::printf("%a", model.GetCurrentTime());
  for (const std::string& name : model.GetOutputVarNames()) {
    double value = 0.0, same = 0.0;
    int index = 0;
    model.GetValue(name, &value);
    model.GetValueAtIndices(name, &same, &index, 1);
    if (value != same || value != *static_cast<double*>(model.GetValuePtr(name))) std::printf(" DIFFERENT");
    std::printf(" %a", value);
  }
  std::printf("\n");
}
void refused(const std::function<void()>& call) {
  try { call(); std::printf("NOT REFUSED\n"); } catch (const espalier::bmi::BmiError& error) { std::printf("refused: %s\n", error.what()); }
}
int main(int, char** arguments) {
  espalier::bmi::EspalierBmi own;
  bmi::Bmi& model = own;
  double grow = 0.25;
  const std::string mode = arguments[1];
  if (mode == "mistakes") {
    for (char** file = arguments + 2; *file != nullptr; ++file) refused([&] { model.Initialize(*file); });
    refused([&] { model.Update(); });
    return 0;
  }
  model.Initialize(arguments[2]);
  if (mode == "whole") { model.UpdateUntil(4.0); say(model); return 0; }
  if (mode == "halves") { model.UpdateUntil(1.3); model.UpdateUntil(4.0); say(model); return 0; }
  if (mode == "facts") {
    std::printf("%s %d %d %s %s\n", model.GetComponentName().c_str(), model.GetInputItemCount(), model.GetOutputItemCount(),
                model.GetInputVarNames()[0].c_str(), model.GetOutputVarNames()[1].c_str());
    std::printf("%d %s %s %d %d %s\n", model.GetVarGrid("height"), model.GetVarType("height").c_str(), model.GetVarUnits("height").c_str(),
                model.GetVarItemsize("height"), model.GetVarNbytes("GROW"), model.GetVarLocation("GROW").c_str());
    std::printf("%g %g %s %g\n", model.GetStartTime(), model.GetEndTime(), model.GetTimeUnits().c_str(), model.GetTimeStep());
    std::printf("%d %d %s %d %d %d\n", model.GetGridRank(0), model.GetGridSize(0), model.GetGridType(0).c_str(), model.GetGridNodeCount(0),
                model.GetGridEdgeCount(0), model.GetGridFaceCount(0));
    int number = 0, one = 1;
    double real = NAN;
    refused([&] { model.GetGridShape(0, &number); }); refused([&] { model.GetGridSpacing(0, &real); });
    refused([&] { model.GetGridOrigin(0, &real); }); refused([&] { model.GetGridX(0, &real); });
    refused([&] { model.GetGridY(0, &real); }); refused([&] { model.GetGridZ(0, &real); });
    refused([&] { model.GetGridEdgeNodes(0, &number); }); refused([&] { model.GetGridFaceEdges(0, &number); });
    refused([&] { model.GetGridFaceNodes(0, &number); }); refused([&] { model.GetGridNodesPerFace(0, &number); });
    refused([&] { model.GetGridSize(1); }); refused([&] { model.GetVarType("depth"); });
    refused([&] { model.SetValue("height", &grow); }); refused([&] { model.SetValue("GROW", &real); });
    refused([&] { model.GetValueAtIndices("GROW", &real, &one, 1); }); refused([&] { model.UpdateUntil(NAN); });
    model.UpdateUntil(4.0);
    refused([&] { model.UpdateUntil(1.0); }); refused([&] { model.Update(); });
    model.Finalize();
    model.Finalize();
    refused([&] { model.GetCurrentTime(); });
    return 0;
  }
  int index = 0;
  say(model);
  for (int step = 1; step <= 8; ++step) {
    if (step == 3) model.SetValueAtIndices("GROW", &index, 1, &grow);
    if (step == 6) *static_cast<double*>(model.GetValuePtr("GROW")) = 0.75;
    model.Update();
    say(model);
  }
}
"""
# the component of clients/bmi/example/heat.py, which adds in the same order as heat.hxx
HEAT_ENVIRONMENT = """
import sys
sys.path.insert(0, {package!r})
from espalier.bmi import environment_of
from heat import Heat

environment_of(Heat, "heat.cfg", "plate_surface__temperature", demand="plate_surface__heat_loss", axes=("x", "y")).serve()
"""
WARM = """Lsystem: 1
derivation length: 6
Axiom: F(1)A?E(0.5)
A > ?E(t) : t > 1 --> F(1)[+(40)A?E(0.5)][-(40)A?E(0.5)]A
?E(t) --> ?E(0.5+t*0.01)
endlsystem
"""


@unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
class BmiInCpp(Installed):
    project: Path
    programs: Path
    built: ClassVar[Dict[str, Path]] = {}  # plug-ins by their sources

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.project = cls.folder / "project"
        shutil.copytree(EXAMPLE, cls.project)
        (cls.project / "functions.cpp").write_text(DRIVER, encoding="utf-8")
        with (cls.project / "CMakeLists.txt").open("a", encoding="utf-8") as file:
            file.write("add_executable(functions functions.cpp)\ntarget_link_libraries(functions PRIVATE espalier::bmi)\n")
        cls.programs = cls.build_project(cls(), cls.project)

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)
        (self.work / "m.l").write_text(MODEL, encoding="utf-8")
        (self.work / "heat.cfg").write_text("7 9 1 0.2\n", encoding="utf-8")
        (self.work / "warm.l").write_text(WARM, encoding="utf-8")

    def configured(self, name: str = "bmi.json", **more: Any) -> str:
        (self.work / name).write_text(json.dumps({**SETTINGS, **more}), encoding="utf-8")
        return str(self.work / name)

    def driven(self, *arguments: str) -> List[str]:
        return run(str(self.programs / "functions"), *arguments).splitlines()

    def plugin(self, source: str, name: str) -> str:
        """A plug-in built against the installed headers, with the warnings that a strict project has."""
        if source in self.built:
            shutil.copy(self.built[source], self.work / f"lib{name}.so")
            return f"./lib{name}.so"
        (self.work / f"{name}.cpp").write_text(source, encoding="utf-8")
        include = self.prefix / "include" / "espalier"
        run("c++", "-std=c++20", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", f"-I{include}", f"-I{include}/clients/bmi", f"-I{EXAMPLE}",
            str(self.work / f"{name}.cpp"), "-o", str(self.work / f"lib{name}.so"))
        self.built[source] = self.folder / f"{len(self.built)}.so"
        shutil.copy(self.work / f"lib{name}.so", self.built[source])
        return f"./lib{name}.so"

    def derived(self, *arguments: str) -> str:
        done = subprocess.run([program(), "derive", *arguments, "--quiet"], cwd=self.work, capture_output=True, text=True, timeout=SECONDS,
                              check=False, env=variables())
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_the_values_are_those_of_the_server_bit_for_bit(self) -> None:
        import numpy

        configuration = self.configured(program=program())
        model = bmi.EspalierBmi()
        model.initialize(configuration)
        self.addCleanup(model.finalize)

        def line() -> str:
            values = [model.get_current_time(), *(float(model.get_value(name, numpy.empty(1))[0]) for name in SETTINGS["outputs"])]  # type: ignore[attr-defined]
            return " ".join(value.hex() for value in values)

        expected = [line()]
        for step in range(1, 9):
            if step in (3, 6):
                model.set_value("GROW", numpy.array([0.25 if step == 3 else 0.75]))
            model.update()
            expected.append(line())
        found = [" ".join(float.fromhex(word).hex() for word in each.split()) for each in self.driven("steps", configuration)]
        self.assertEqual(found, expected)
        self.assertGreater(float.fromhex(found[-1].split()[2]), 1.0)
        # the model lives in the time of the interface: the eighth step begins after three and a half days
        self.assertEqual(float.fromhex(found[-1].split()[5]), 3.5)
        # and those of the run in the program itself
        string = self.derived("m.l", "--environment", "shadow", "--seed", "3", "--steps", "2")
        self.assertEqual(float.fromhex(found[2].split()[3]), string.count("F("))

    def test_a_folder_has_its_world(self) -> None:
        # steps of 12 h, on which the model is as with stepDurationDays 0.5
        folder = self.work / "tree"
        folder.mkdir()
        shutil.copy(self.work / "m.l", folder / "tree.l")
        expected = self.driven("steps", self.configured())
        (folder / "world.json").write_text('{"stepDuration": "12 h"}', encoding="utf-8")
        self.assertEqual(self.driven("steps", self.configured(model="tree", stepDurationDays=None)), expected)
        (folder / "world.json").write_text('{"stepDuration": "3 h"}', encoding="utf-8")
        self.assertEqual(self.driven("steps", self.configured(model="tree")), expected)
        self.assertNotEqual(self.driven("steps", self.configured(model="tree", stepDurationDays=None)), expected)

    def test_time_in_two_halves_is_time_in_one_piece(self) -> None:
        configuration = self.configured()
        self.assertEqual(self.driven("whole", configuration), self.driven("halves", configuration))

    def test_every_function_answers_or_says_why_not(self) -> None:
        said = self.driven("facts", self.configured())
        self.assertEqual(said[:4], ["Espalier 1 5 GROW height", "0 double m 8 8 node", "0 4 d 0.5", "0 1 scalar 1 0 0"])
        self.assertEqual(said[4:14], ["refused: a scalar has no points, edges or faces."] * 10)
        self.assertEqual(said[14:], [f"refused: {text}" for text in (
            "there is no grid 1: all variables are on grid 0.", "there is no variable 'depth'. Variables: GROW, modules, height, count:F, sum:F:1, sum:f:1.",
            "'height' is no input. Inputs: GROW.", "the input 'GROW' cannot be nan: set it to a finite number.", "'GROW' has the index 0 only.",
            "the time nan is not finite: give a number of days from 0 on.", "the time 1 is before 4: a model does not go back. Initialize it again.",
            "the model ends after 8 steps: initialize it with a larger 'derivationLength'.",
            "the model is not initialized: call Initialize(config_file) first.")])

    def test_the_interface_has_the_functions_of_the_specification_in_their_order(self) -> None:
        header = (REPOSITORY / "clients" / "bmi" / "bmi.hxx").read_text(encoding="utf-8")
        found = [re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower() for name in re.findall(r"virtual [\w:<> *]*?(\w+)\(", header)]
        self.assertEqual(found, FUNCTIONS)

    def test_every_mistake_in_a_configuration_is_one_sentence(self) -> None:
        (self.work / "empty").mkdir()
        (self.work / "broken.l").write_text(MODEL.replace("A(l) >", "A(l"), encoding="utf-8")
        (self.work / "stranger").mkdir()
        (self.work / "stranger" / "m.l").write_text(MODEL, encoding="utf-8")
        (self.work / "stranger" / "m.json").write_text('{"type":"plugin","library":"./x.so"}', encoding="utf-8")
        wrong: List[Any] = [({"model": "none.l"}, "there is no file or folder '.*none.l': 'model' names one beside"),
                            ({"model": "empty"}, "no L-system file"), ({"model": 7}, "'model' is the name of a file or folder"),
                            ({"model": "broken.l"}, "broken.l:7:"), ({"stepDurationDays": 0}, "'stepDurationDays' is a number above 0, not 0"),
                            ({"inputs": "GROW"}, "'inputs' is a list of names"), ({"outputs": ["width"]}, "no output 'width'"),
                            ({"parameters": {}}, "the input 'GROW' needs a value at the start"), ({"seed": -1}, "'seed' is a whole number"),
                            ({"environment": "shadw"}, "Did you mean 'shadow'"), ({"environment": "none.json"}, "no environment file"),
                            ({"environment": {"type": "plugin"}}, "needs a member 'library'"), ({"colour": 1}, "'colour' is not known"),
                            ({"gallery": "lilac"}, "either 'model'"), ({"model": "stranger", "environment": None}, "may come from a stranger")]
        files = [self.configured(f"{i}.json", **settings) for i, (settings, _) in enumerate(wrong)]
        # a mistake in the model is its diagnostic, with the line and a hint below the sentence
        said = [line for line in self.driven("mistakes", *files, str(self.work / "none")) if not line.startswith(" ")]
        self.assertEqual(len(said), len(wrong) + 2, said)
        for line, (_, expected) in zip(said, [*wrong, (None, "cannot be read"), (None, "call Initialize")]):
            self.assertRegex(line, rf"^refused: .*{expected}")

    def test_the_driver_of_the_page_runs(self) -> None:
        page = (REPOSITORY / "docs" / "howto" / "basic-model-interface.md").read_text(encoding="utf-8")
        for name in ("tree.l", "tree-bmi.json"):
            block = re.search(rf"<!-- file {name} -->\n```\w*\n(.*?)```", page, re.DOTALL)
            assert block is not None
            (self.work / name).write_text(block.group(1), encoding="utf-8")
        lines = run(str(self.programs / "driver"), str(self.work / "tree-bmi.json"), "GROW", "0.25").splitlines()
        shown = re.search(r"\$ bmi/build/driver tree-bmi.json GROW 0.25\n(.*?)\n…", page)
        assert shown is not None
        self.assertEqual([len(lines), lines[0][:len(shown.group(1))]], [3, shown.group(1)])
        # the CMake file of the page is a part of the example's
        for block in re.findall(r"```cmake\n(.*?)```", page, re.DOTALL):
            self.assertIn(block, (EXAMPLE / "CMakeLists.txt").read_text(encoding="utf-8"))

    HEAT_PLUGIN = (EXAMPLE / "heat_plugin.cpp").read_text(encoding="utf-8")

    def test_a_component_answers_as_the_same_model_in_python_bit_for_bit(self) -> None:
        library = self.plugin(self.HEAT_PLUGIN, "heat")
        shutil.copy(EXAMPLE / "heat.py", self.work)
        (self.work / "heat_environment.py").write_text(HEAT_ENVIRONMENT.format(package=str(REPOSITORY / "clients" / "python")), encoding="utf-8")
        other = stdio([sys.executable, str(self.work / "heat_environment.py")])
        for more in ((), ("--every",), ("--steps", "9")):
            found = self.derived("warm.l", "--environment", library, *more)
            self.assertEqual(found, self.derived("warm.l", "--environment", other, *more))
        self.assertNotEqual(found, self.derived("warm.l", "--environment", "constant", "--steps", "9"))

    def test_a_run_that_is_resumed_has_the_state_of_one_in_one_piece(self) -> None:
        library = self.plugin(self.HEAT_PLUGIN, "heat")
        subprocess.run([program(), "run", "warm.l", "--environment", library, "--steps", "9", "--quiet", "-o", "whole.csv"],
                       cwd=self.work, check=True, timeout=SECONDS)
        subprocess.run([program(), "run", "warm.l", "--environment", library, "--steps", "4", "--quiet", "-o", "half.snapshot"], cwd=self.work,
                       check=True, timeout=SECONDS)
        subprocess.run([program(), "run", "--resume", "half.snapshot", "--environment", library, "--steps", "9", "--quiet", "-o", "end.csv"],
                       cwd=self.work, check=True, timeout=SECONDS)
        self.assertEqual((self.work / "end.csv").read_bytes(), (self.work / "whole.csv").read_bytes())

    def test_two_components_in_one_simulation_do_not_meet(self) -> None:
        source = self.HEAT_PLUGIN.replace('.demand = "plate_surface__heat_loss", ', "")
        warm = self.plugin(source, "heat")
        cold = self.plugin(source.replace('"heat"', '"cold"').replace("heat.cfg", "cold.cfg"), "cold")
        (self.work / "cold.cfg").write_text("7 9 1 0\n", encoding="utf-8")
        (self.work / "cool.cfg").write_text("7 9 1 0.1\n", encoding="utf-8")
        model = "Module: ?Heat(v), ?Cold(v)\nLsystem: 1\nderivation length: 3\nAxiom: [f(3)?Heat(0)][f(3)?Cold(0)]\nendlsystem\n"
        (self.work / "two.l").write_text(model, encoding="utf-8")
        entries = [{"type": "plugin", "name": "Heat", "library": warm}, {"type": "plugin", "name": "Cold", "library": cold}]
        answers = []
        for more in ({}, {"configurationFile": "cool.cfg"}):
            (self.work / "two.json").write_text(json.dumps([{**entries[0], **more}, entries[1]]), encoding="utf-8")
            answers.append([float(word) for word in re.findall(r"\?\w+\(([^)]*)\)", self.derived("two.l", "--environment", "two.json"))])
        # the middle keeps its heat in one of them
        self.assertEqual([each[1] for each in answers], [100.0, 100.0])
        self.assertTrue(0.0 < answers[0][0] < answers[1][0] < 100.0, answers)

    def test_a_component_that_fails_says_so_and_the_step_can_be_tried_again(self) -> None:
        source = self.HEAT_PLUGIN.split("ESPALIER_BMI")[0] + """
struct Moody : Heat {
  void Update() override {
    static int calls = 0;
    if (++calls == 3) { Heat::Update(); throw std::runtime_error("the third call fails"); }
    Heat::Update();
  }
};
""" + "ESPALIER_BMI" + self.HEAT_PLUGIN.split("ESPALIER_BMI")[1].replace("<Heat>", "<Moody>")
        library = self.plugin(source, "moody")
        done = subprocess.run([program(), "run", "warm.l", "--environment", library, "--steps", "6", "--quiet", "-o", "part.snapshot"], cwd=self.work,
                              capture_output=True, text=True, timeout=SECONDS, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("environment plug-in 'heat' failed in step: the third call fails", done.stderr)
        subprocess.run([program(), "run", "--resume", "part.snapshot", "--environment", library, "--steps", "2", "--quiet", "-o", "x.snapshot"],
                       cwd=self.work, check=True, timeout=SECONDS)

    def test_what_a_component_cannot_do_is_one_sentence(self) -> None:
        library = self.plugin(self.HEAT_PLUGIN, "heat")
        (self.work / "heat.cfg").unlink()
        cases = [(library, "'heat' refuses its configuration: 'heat.cfg' must hold four numbers")]
        (self.work / "named.json").write_text(json.dumps({"type": "plugin", "library": library, "configurationFile": 3}), encoding="utf-8")
        cases.append(("named.json", "'configurationFile' is a text: the name of a file"))
        for environment, said in cases:
            done = subprocess.run([program(), "derive", "warm.l", "--environment", environment], cwd=self.work, capture_output=True, text=True,
                                  timeout=SECONDS, check=False)
            self.assertEqual((done.returncode != 0, done.stderr.count("\n")), (True, 1), done.stderr)
            self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main()
