"""The Basic Model Interface: all functions, time in pieces, inputs, models of several files; a BMI model as an environment."""

import gc
import importlib
import importlib.util
import io
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
from contextlib import redirect_stderr
from pathlib import Path
from typing import Any, Callable, ClassVar, List, Tuple

from support import REPOSITORY, espalier as command, program, variables

import espalier
from espalier import bmi, wire
from espalier.hosting import Host

# of the BMI 2.0 specification
FUNCTIONS = """initialize update update_until finalize get_component_name get_input_item_count get_output_item_count get_input_var_names
get_output_var_names get_var_grid get_var_type get_var_units get_var_itemsize get_var_nbytes get_var_location get_current_time
get_start_time get_end_time get_time_units get_time_step get_value get_value_ptr get_value_at_indices set_value set_value_at_indices
get_grid_rank get_grid_size get_grid_type get_grid_shape get_grid_spacing get_grid_origin get_grid_x get_grid_y get_grid_z
get_grid_node_count get_grid_edge_count get_grid_face_count get_grid_edge_nodes get_grid_face_edges get_grid_face_nodes
get_grid_nodes_per_face""".split()
MODEL = "#define GAIN 2\nLsystem: 1\nderivation length: 6\nAxiom: A(1)\nA(l) --> F(l)A(l*GAIN)\nendlsystem\n"


class Diffusion:
    """A BMI model in five lines of physics: a row of nodes along y that loses half of what it holds in each step."""

    living: ClassVar[List["Diffusion"]] = []

    def initialize(self, config_file: str) -> None:
        import numpy

        Diffusion.living.append(self)
        self.amount = numpy.array([16.0, 8.0, 4.0, 2.0])
        self.demand = numpy.zeros(4)

    def update(self) -> None:
        self.amount = (self.amount - self.demand) / 2

    def finalize(self) -> None:
        if self in Diffusion.living:
            Diffusion.living.remove(self)

    def get_var_units(self, name: str) -> str:
        return {"amount": "mol m-3", "demand": "-"}[name]

    def get_var_grid(self, name: str) -> int:
        return 0

    def get_grid_type(self, grid: int) -> str:
        return "uniform_rectilinear"

    def get_grid_rank(self, grid: int) -> int:
        return 1

    def get_grid_shape(self, grid: int, shape: Any) -> Any:
        shape[:] = [4]
        return shape

    def get_grid_spacing(self, grid: int, spacing: Any) -> Any:
        spacing[:] = [1.0]
        return spacing

    def get_grid_origin(self, grid: int, origin: Any) -> Any:
        origin[:] = [0.0]
        return origin

    def get_var_type(self, name: str) -> str:
        return "float64"

    def get_var_nbytes(self, name: str) -> int:
        return 32

    def get_var_itemsize(self, name: str) -> int:
        return 8

    def get_value(self, name: str, dest: Any) -> Any:
        dest[:] = self.amount
        return dest

    def set_value(self, name: str, src: Any) -> None:
        self.demand = src


@unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
class Model(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        gc.collect()
        Diffusion.living.clear()
        (self.folder / "m.l").write_text(MODEL, encoding="utf-8")

    def model(self, **more: Any) -> bmi.EspalierBmi:
        settings = {"model": "m.l", "program": program(), "outputs": ["modules", "height", "count:F", "sum:F:1"],
                    "inputs": ["GAIN"], "parameters": {"GAIN": 2}, **more}
        (self.folder / "m.json").write_text(json.dumps(settings), encoding="utf-8")
        made = bmi.EspalierBmi()
        made.initialize(str(self.folder / "m.json"))
        self.addCleanup(made.finalize)
        return made

    def values(self, model: bmi.EspalierBmi) -> List[float]:
        import numpy

        return [float(model.get_value(name, numpy.empty(1))[0]) for name in model.get_output_var_names()]

    def test_has_every_function(self) -> None:
        self.assertEqual([name for name in FUNCTIONS if not callable(getattr(bmi.EspalierBmi, name, None))], [])
        self.assertEqual(len(FUNCTIONS), 41)

    def test_steps_and_says_what_there_is(self) -> None:
        import numpy

        model = self.model(stepDurationDays=0.5)
        self.assertEqual(self.values(model), [1.0, 0.0, 0.0, 0.0])
        model.update()
        self.assertEqual((model.get_current_time(), model.get_time_step(), model.get_end_time(), model.get_time_units()), (0.5, 0.5, 3.0, "d"))
        self.assertEqual(self.values(model), [2.0, 1.0, 1.0, 1.0])
        self.assertEqual((model.get_input_var_names(), model.get_output_item_count()), (("GAIN",), 4))
        self.assertEqual((model.get_var_type("height"), model.get_var_units("height"), model.get_var_nbytes("height")), ("float64", "m", 8))
        self.assertEqual((model.get_grid_type(0), model.get_grid_rank(0), model.get_grid_size(0)), ("scalar", 0, 1))
        pointer = model.get_value_ptr("height")
        model.update()
        # 1 + 2
        self.assertEqual((float(pointer[0]), float(model.get_value_at_indices("height", numpy.empty(1), numpy.array([0]))[0])), (3.0, 3.0))

    def test_time_in_two_halves_is_time_in_one_piece(self) -> None:
        whole, halves = self.model(stepDurationDays=0.1), self.model(stepDurationDays=0.1)
        whole.update_until(0.6)
        halves.update_until(0.3)
        halves.update_until(0.6)
        self.assertEqual(self.values(whole), self.values(halves))
        self.assertEqual(self.values(whole)[1], 63.0)
        self.assertEqual((whole.get_current_time(), halves.get_current_time()), (whole.get_end_time(),) * 2)

    def test_an_input_counts_from_the_next_step_on(self) -> None:
        import numpy

        model = self.model()
        model.update()
        model.set_value("GAIN", numpy.array([10.0]))
        model.update()
        model.update()
        # F(1), F(2): its length was set before; then 2·10
        self.assertEqual(self.values(model)[1], 1.0 + 2.0 + 20.0)

    def test_wrong_calls_are_one_sentence(self) -> None:
        import numpy

        model = self.model()
        model.update_until(6)
        for call, said in ((model.update, "ends after 6 steps"), (lambda: model.update_until(1), "does not go back"),
                           (lambda: model.get_var_type("depth"), "no variable 'depth'"), (lambda: model.get_grid_x(0, None), "a scalar"),
                           (lambda: model.get_grid_size(1), "no grid 1"), (lambda: model.set_value("height", numpy.zeros(1)), "no input"),
                           (lambda: self.model(outputs=["width"]), "no output 'width'"), (lambda: self.model(colour=1), "'colour' is not known"),
                           (lambda: self.model(parameters={}), "needs a value at the start"), (bmi.EspalierBmi().update, "call initialize")):
            with self.subTest(said), self.assertRaisesRegex(bmi.BmiError, said):
                call()

    def refused(self, said: str, call: Callable[[], Any]) -> None:
        with self.subTest(said), self.assertRaisesRegex(bmi.BmiError, said):
            call()

    def test_a_model_of_several_files(self) -> None:
        (self.folder / "parts.h").write_text("#define GAIN 3\n", encoding="utf-8")
        lines = MODEL.replace("#define GAIN 2", '#include "parts.h"')
        (self.folder / "parts.l").write_text(lines, encoding="utf-8")
        inner = self.folder / "inner"
        inner.mkdir()
        (inner / "parts.h").write_text("#define GAIN 4\n", encoding="utf-8")
        (inner / "inner.l").write_text(lines, encoding="utf-8")
        for name, height in (("parts.l", 1.0 + 3.0), ("inner", 1.0 + 4.0), ("inner/inner.l", 1.0 + 4.0)):
            with self.subTest(name):
                model = self.model(model=name, inputs=[], parameters={})
                model.update_until(2)
                self.assertEqual((self.values(model)[1], model.get_end_time()), (height, 6.0))

    def test_a_folder_has_its_world(self) -> None:
        inner = self.folder / "inner"
        inner.mkdir()
        (inner / "inner.l").write_text("Lsystem: 1\nderivation length: 4\nAxiom: F(0)\nF(x) --> F(world.temperature)\nendlsystem\n", encoding="utf-8")
        (inner / "world.json").write_text('{"stepDuration": "6 h", "start": "2026-06-21T00:00Z", "weather": "air.csv"}', encoding="utf-8")
        (inner / "air.csv").write_text("time,temperature\n2026-06-21T00:00Z,10\n2026-06-21T06:00Z,20\n2026-06-22T06:00Z,20\n", encoding="utf-8")
        for days, more in ((0.25, {}), (0.125, {"stepDurationDays": 0.125})):
            with self.subTest(days):
                model = self.model(model="inner", inputs=[], parameters={}, outputs=["sum:F:1"], **more)
                model.update()
                self.assertEqual((model.get_current_time(), model.get_time_step(), model.get_end_time()), (days, days, 4 * days))
                first = self.values(model)[0]
                model.update_until(3 * days)
                self.assertLess(first, self.values(model)[0])
        (inner / "world.json").write_text('{"stepDuration": "6 parsec"}', encoding="utf-8")
        self.refused("stepDuration", lambda: self.model(model="inner", inputs=[], parameters={}))
        (inner / "world.json").write_text('{"weather": "none.csv"}', encoding="utf-8")
        self.refused("no table of weather 'none.csv'", lambda: self.model(model="inner", inputs=[], parameters={}))

    def test_the_configuration_is_not_the_environment_of_the_model(self) -> None:
        # m.json beside m.l
        self.assertEqual(self.values(self.model())[0], 1.0)
        (self.folder / "m.l").write_text(MODEL.replace("A(l) -->", "A(l) -->("), encoding="utf-8")
        self.refused("m.json: the model cannot start.*m.l:5", self.model)

    def written(self, page: str) -> Any:
        """The blocks of a page, with its files written."""
        sys.path.insert(0, str(REPOSITORY / "docs"))
        self.addCleanup(sys.path.pop, 0)
        blocks = importlib.import_module("page_blocks").blocks(page)
        for block in blocks:
            if block.remark == "file":
                (self.folder / block.value).write_text(block.text, encoding="utf-8")
        return blocks

    def test_the_program_of_the_page_runs(self) -> None:
        blocks = self.written((REPOSITORY / "docs/howto/basic-model-interface.md").read_text(encoding="utf-8"))
        script = next(block.text for block in blocks if block.language == "python")
        done = subprocess.run([sys.executable, "-c", script], cwd=self.folder, env=variables(ESPALIER_PROGRAM=program()), capture_output=True,
                              text=True, check=True, timeout=60)
        # three segments of 0.5 above each other, and one of 0.25
        self.assertEqual(done.stdout, "4.0 1.75\n")
        # a configuration of its own name is no environment
        command("derive", str(self.folder / "tree.l"), "--quiet")

    def test_the_component_of_the_page_answers_its_plant(self) -> None:
        page = (REPOSITORY / "docs/howto/basic-model-interface.md").read_text(encoding="utf-8")
        self.written(page)
        shutil.copy(REPOSITORY / "clients" / "bmi" / "example" / "heat.py", self.folder)
        script = re.search(r"```python\n(from espalier.bmi import environment_of.*?)```", page, re.DOTALL)
        line = re.search(r"^\$ espalier (derive warm.l .*) --quiet \| tr -cd F \| wc -c\n(\d+)$", page, re.MULTILINE)
        assert script and line
        (self.folder / "heat_environment.py").write_text(script.group(1), encoding="utf-8")
        words = [word.replace("python3", sys.executable) for word in shlex.split(line.group(1))]
        done = subprocess.run([program(), *words, "--quiet"], cwd=self.folder, env=variables(), capture_output=True, text=True, check=True, timeout=60)
        self.assertEqual(done.stdout.count("F"), int(line.group(2)))

    def test_every_mistake_in_a_configuration_is_one_sentence(self) -> None:
        (self.folder / "empty").mkdir()
        for wrong, said in (({"model": "none.l"}, "there is no file or folder '.*none.l': 'model' names one beside"),
                            ({"model": "empty"}, "cannot start.*no L-system file"), ({"model": 7}, "'model' is the name of a file or folder"),
                            ({"stepDurationDays": "x"}, "'stepDurationDays' is a number above 0, not \"x\""),
                            ({"stepDurationDays": 0}, "a number above 0, not 0"), ({"stepDurationDays": True}, "a number above 0, not true"),
                            ({"inputs": "GAIN"}, "'inputs' is a list of names"), ({"outputs": [3]}, "'outputs' is a list of names"),
                            ({"parameters": [2]}, "'parameters' is an object"), ({"parameters": {"GAIN": "x"}}, "the input 'GAIN' needs a value.*a number"),
                            ({"parameters": {"GAIN": float("nan")}}, "the input 'GAIN' needs a value.*a number"),
                            ({"seed": "x"}, "'seed' is a whole number"), ({"derivationLength": -1}, "cannot start.*derivationLength"),
                            ({"environment": 5}, "'environment' is a name"), ({"environment": "none.json"}, "cannot start.*no environment file"),
                            ({"environment": "nothing-like-it"}, "cannot start.*nothing-like-it"),
                            ({"program": "no-such-program"}, "cannot start.*no program"), ({"gallery": "lilac"}, "either 'model'")):
            self.refused(said, lambda wrong=wrong: self.model(**wrong))  # type: ignore[misc]
        self.refused("cannot be read as JSON", lambda: bmi.EspalierBmi().initialize(str(self.folder)))

    def test_a_second_initialize_ends_the_first_server(self) -> None:
        model = self.model()
        first = model._server
        assert first is not None
        model.update()
        model.initialize(str(self.folder / "m.json"))
        self.assertIsNotNone(first._server._process.poll())
        self.assertEqual(model.get_current_time(), 0.0)
        # one that fails leaves nothing of the one before
        self.refused("cannot be read", lambda: model.initialize(str(self.folder / "none.json")))
        self.refused("call initialize", model.get_current_time)

    def test_without_a_model_nothing_is_answered(self) -> None:
        import numpy

        finalized = self.model()
        finalized.finalize()
        finalized.finalize()
        one, index = numpy.empty(1), numpy.array([0])
        for model in (bmi.EspalierBmi(), finalized):
            calls: Tuple[Callable[[], Any], ...] = (
                model.update, lambda: model.update_until(1.0), model.get_current_time, model.get_end_time, model.get_time_step,
                model.get_input_item_count, model.get_output_item_count, model.get_input_var_names, model.get_output_var_names,
                lambda: model.get_value("height", one), lambda: model.get_value_ptr("height"), lambda: model.set_value("GAIN", one),
                lambda: model.get_value_at_indices("height", one, index), lambda: model.set_value_at_indices("GAIN", index, one),
                lambda: model.get_var_grid("height"), lambda: model.get_var_type("height"), lambda: model.get_var_units("height"),
                lambda: model.get_var_itemsize("height"), lambda: model.get_var_nbytes("height"), lambda: model.get_var_location("height"))
            for number, call in enumerate(calls):
                with self.subTest(number):
                    self.refused("not initialized: call initialize", call)
            self.assertEqual((model.get_component_name(), model.get_time_units()), ("Espalier", "d"))

    def test_numbers_that_are_not_finite_are_refused(self) -> None:
        import numpy

        model = self.model()
        model.update_until(2)
        for when in (float("nan"), float("inf"), float("-inf")):
            self.refused(f"the time {when} is not finite", lambda: model.update_until(when))
        for value in (float("nan"), float("inf")):
            self.refused(f"the input 'GAIN' cannot be {value}", lambda: model.set_value("GAIN", numpy.array([value])))
            self.refused(f"the input 'GAIN' cannot be {value}", lambda: model.set_value_at_indices("GAIN", numpy.array([0]), numpy.array([value])))
        self.refused("'GAIN' takes one number, not", lambda: model.set_value("GAIN", numpy.array([1.0, 2.0])))
        self.refused("'GAIN' takes one number, not 'x'", lambda: model.set_value("GAIN", "x"))
        self.refused("'GAIN' has the index 0", lambda: model.get_value_at_indices("GAIN", numpy.empty(1), numpy.array([3])))
        self.assertEqual((float(model.get_value_ptr("GAIN")[0]), model.get_current_time()), (2.0, 2.0))
        model.get_value_ptr("GAIN")[0] = float("nan")
        self.refused("the input 'GAIN' cannot be nan", model.update)
        model.set_value("GAIN", 2.0)
        model.update()
        self.assertEqual(self.values(model)[1], 7.0)

    def test_the_time_that_was_reached_can_be_asked_for_again(self) -> None:
        # 3 * 0.1 is a little more than 0.3, and the step ends at 0.3
        model = self.model(stepDurationDays=0.1)
        model.update_until(0.3)
        model.update_until(0.3)
        self.assertEqual(self.values(model)[1], 7.0)
        self.assertEqual(model.get_current_time(), 0.3)

    PLANT = "Lsystem: 1\nderivation length: 3\nAxiom: [@M(0,0,0)?E(4)][@M(0,1.4,0)?E(0)][@M(5,9,0)?E(0)]\nendlsystem\n"

    def test_a_bmi_model_says_its_units_and_that_its_state_is_not_saved(self) -> None:
        made = bmi.environment_of(Diffusion, "none", "amount", demand="demand", axes=("y",))
        said = made.description()
        self.assertEqual((said["inputs"], said["outputs"]), ([{"name": "demand", "unit": "1"}], [{"name": "amount", "unit": "mol m-3"}]))
        self.assertEqual((said["stateful"], said["checkpoint"]), (True, False))
        self.assertEqual(Diffusion.living, [])
        self.refused("has 1 dimensions: name as many axes", lambda: bmi.environment_of(Diffusion, "none", "amount", axes=()))
        self.assertEqual(Diffusion.living, [])

    def test_a_bmi_model_is_finalized_with_its_simulation(self) -> None:
        with espalier.local(program()) as client:
            asked = client.attach(bmi.environment_of(Diffusion, "none", "amount", demand="demand", axes=("y",)))
            plant = client.create(self.PLANT, environment=[asked], save=False)
            plant.step(2)
            first = plant.turtle()
            # a simulation that starts over has a new model
            plant.reset()
            plant.step(2)
            gc.collect()
            self.assertEqual([record.parameters for record in plant.turtle()], [record.parameters for record in first])
            self.assertEqual(len(Diffusion.living), 1)
            plant.delete()
        for thread in threading.enumerate():
            if thread.name == "environment bmi":
                thread.join(20)
        gc.collect()
        self.assertEqual(Diffusion.living, [])

    def test_closing_finalizes_the_model_at_once(self) -> None:
        host = Host(bmi.environment_of(Diffusion, "none", "amount", axes=("y",)))
        self.assertEqual(host.handle(wire.request(1, "environment.open", {"simulation": "s"})), wire.result(1, {}))
        self.assertEqual(len(Diffusion.living), 1)
        self.assertEqual(host.handle(wire.request(2, "environment.close", {"simulation": "s"})), wire.result(2, {}))
        self.assertEqual(Diffusion.living, [])

    def test_a_bmi_model_does_not_go_back(self) -> None:
        with espalier.local(program()) as client:
            asked = client.attach(bmi.environment_of(Diffusion, "none", "amount", axes=("y",)))
            plant = client.create(self.PLANT, environment=[asked], save=False)
            plant.step(1)
            saved = plant.save()
            plant.step(2)
            # the trace of the environment goes to standard error
            with self.assertRaisesRegex(espalier.EspalierError, "its state is never saved: reset"), redirect_stderr(io.StringIO()):
                plant.restore(saved)
                plant.step(1)
            plant.reset()
            self.assertEqual(plant.step(1).step, 1)

    def test_the_check_finds_only_the_state(self) -> None:
        script = self.folder / "diffusion.py"
        script.write_text(f"import sys\nsys.path.insert(0, {str(Path(__file__).parent)!r})\nfrom test_bmi import Diffusion\nfrom espalier.bmi import "
                          "environment_of\nenvironment_of(Diffusion, 'none', 'amount', demand='demand', axes=('y',)).serve()\n", encoding="utf-8")
        said = command("environment", "check", f"stdio:'{sys.executable}' '{script}'", status=1).stdout.splitlines()
        self.assertEqual([line for line in said if line.startswith("wrong")],
                         ["wrong state: it has state and does not save it; answer environment.save and restore, and say checkpoint:true"])
        self.assertIn("ok    units: output 'amount' in mol m-3", said)

    def test_a_bmi_model_answers_plants(self) -> None:
        with espalier.local(program()) as client:
            asked = client.attach(bmi.environment_of(Diffusion, "none", "amount", demand="demand", axes=("y",)))
            plant = client.create(self.PLANT, environment=[asked], save=False)
            plant.step(1)
            # (16 - 4)/2 at the ground, 8/2 at the height 1, 2/2 at the border
            self.assertEqual([record.parameters for record in plant.turtle() if record.symbol == "E"], [(6.0,), (4.0,), (1.0,)])


if __name__ == "__main__":
    unittest.main()
