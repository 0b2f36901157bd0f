"""The tools of espalier.mcp: what they do, and tables of their arguments with limits. Hosts read the docstrings."""

from __future__ import annotations

import base64
import json
from contextlib import suppress
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

from ..client import Client
from ..errors import EspalierError, ServerError
from ..program import drawn_by

CANCELLED = 1010  # error of the protocol
SECONDS = 30  # of a call; hosts wait for a minute
SIMULATIONS = 16  # of a session
MODULES = 2_000_000  # of a simulation
SOURCE_CHARACTERS = 1_000_000
ANSWER_CHARACTERS = 50_000
PART_CHARACTERS = 40_000  # of a string
PART_RECORDS = 200  # of the turtle

Arguments = Mapping[str, Any]


def content(value: Any) -> List[Dict[str, Any]]:
    """A text, a PNG, or another value as JSON. A long answer is cut, and says so."""
    if isinstance(value, bytes):
        return [{"type": "image", "data": base64.b64encode(value).decode("ascii"), "mimeType": "image/png"}]
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, allow_nan=False)
    if len(text) > ANSWER_CHARACTERS:
        text = (f"{text[:ANSWER_CHARACTERS]}\n[The answer has {len(text)} characters; {ANSWER_CHARACTERS} of them are "
                "above. Ask for a part: `from` and `count` of query.]")
    return [{"type": "text", "text": text}]


def _chosen(values: Mapping[str, Any], names: Sequence[str]) -> Dict[str, Any]:
    """Those of the named values that are there."""
    return {name: values[name] for name in names if name in values}


class Tools:
    """The actions of the tools, over a client of a server."""

    def __init__(self, client: Client, program: str, seconds: float = SECONDS) -> None:
        self._client = client
        self._program = program
        self._seconds = seconds
        self._made: List[str] = []  # simulations

    def call(self, name: str, arguments: Any) -> List[Dict[str, Any]]:
        """The answer of a tool. EspalierError: the arguments do not fit, or the tool cannot do it."""
        return content(TOOLS[name].answer(self, fitting(name, arguments)))

    def close(self) -> None:
        """Deletes the simulations that are left."""
        while self._made:
            with suppress(EspalierError):  # it is gone, or the server is
                self._client.call("simulation.delete", {"simulation": self._made.pop()})

    def _ask(self, method: str, parameters: Mapping[str, Any]) -> Any:
        """A request that is given up when it takes too long."""
        try:
            return self._client.call(method, parameters, seconds=self._seconds)
        except ServerError as error:
            if error.code != CANCELLED:
                raise
            raise EspalierError(f"{error} A call may take {self._seconds:g} seconds: ask for fewer steps.") from None

    def check(self, arguments: Arguments) -> Any:
        """Compile an L-system (the cpfg dialect, `Lsystem: 1` to `endlsystem`) and say every mistake with its place."""
        checked = self._ask("model.check", arguments)
        result = "The model is not valid."
        if checked["valid"]:
            result = (f"The model is valid. Derivation length {checked['derivationLength']}; "
                      f"symbols: {' '.join(checked['symbols'])}")
        return "\n".join([*(item["text"] for item in checked["diagnostics"]), result])

    def gallery(self, arguments: Arguments) -> Any:
        """List the models of the gallery, or read the files of one."""
        if "name" not in arguments:
            return "\n".join(self._ask("model.list", {})["entries"])
        read = self._ask("model.read", {"gallery": arguments["name"]})
        parts = [f"=== {name}\n{held}" for name, held in read["files"].items()]
        if read.get("environment"):
            parts.append(f"=== environment for create\n{json.dumps(read['environment'])}")
        return "\n".join(parts)

    def environments(self, arguments: Arguments) -> Any:
        """List the environments that plants can ask, or describe one: configuration, units, sources."""
        known = {item["name"]: item for item in self._ask("environment.list", {})["environments"]}
        name = arguments.get("name")
        if name is None:
            return list(known)
        if name not in known:
            raise EspalierError(f"There is no environment '{name}'. `environments` without a name lists them.")
        return known[name]

    def create(self, arguments: Arguments) -> Any:
        """Plant a model, at step 0. Give `source` or `gallery`."""
        model = _chosen(arguments, ("source", "gallery"))
        if len(model) != 1:
            raise EspalierError("create takes either `source`, the text of a model, or `gallery`, the name of one.")
        if len(self._made) >= SIMULATIONS:
            raise EspalierError(f"There are {SIMULATIONS} simulations. Call `delete` for one: {' '.join(self._made)}")
        created = self._ask("simulation.create", {
            "model": model, "save": False, "limits": {"modules": MODULES, "queries": MODULES},
            **_chosen(arguments, ("environment", "seed", "parameters"))})
        self._made.append(created["simulation"])
        shown = _chosen(created, ("simulation", "step", "seed", "derivationLength", "plants", "finished"))
        return {**shown, "diagnostics": [item["text"] for item in created.get("diagnostics", [])]}

    def step(self, arguments: Arguments) -> Any:
        """Make steps. Ends early when the model is finished."""
        return self._ask("simulation.step", arguments)

    def explain(self, arguments: Arguments) -> Any:
        """Say which production the next step applies to a module, and why not the others."""
        return self._ask("simulation.get", {**arguments, "what": "explanation"})["explanation"]

    def render(self, arguments: Arguments) -> Any:
        """Draw the plants as they are, as a PNG."""
        saved = self._ask("simulation.save", {"simulation": arguments["simulation"]})
        options = ("--size", f"{arguments['width']}x{arguments['height']}")
        return drawn_by(self._program, base64.b64decode(saved["snapshot"]), ".png", *options, seconds=self._seconds)

    def query(self, arguments: Arguments) -> Any:
        """Read the state: derived string, statistics, turtle records (position, heading, width of modules) or hash."""
        what, first, count = arguments["what"], arguments["from"], arguments["count"]
        asked = _chosen(arguments, ("simulation", "what", "plant") if what == "string" else ("simulation", "what"))
        found = self._ask("simulation.get", asked)
        if what == "turtle":
            part = found["records"][first:first + min(count, PART_RECORDS)]
            return {"first": first, "of": len(found["records"]), "records": part}
        if what == "string":
            part, whole = found["string"][first:first + count], found["string"]
            return part if part == whole else f"{part}\n[Characters {first} to {first + len(part)} of {len(whole)}.]"
        return found

    def delete(self, arguments: Arguments) -> Any:
        """Delete a simulation of create."""
        self._ask("simulation.delete", arguments)
        self._made = [simulation for simulation in self._made if simulation != arguments["simulation"]]
        return "The simulation is deleted."


def _text(description: str, longest: int = 200) -> Dict[str, Any]:
    return {"type": "string", "description": description, "maxLength": longest}


def _number(description: str, least: int, greatest: int, **default: int) -> Dict[str, Any]:
    return {"type": "integer", "description": description, "minimum": least, "maximum": greatest, **default}


ARGUMENTS: Mapping[str, Mapping[str, Any]] = {  # as JSON Schema
    "source": _text("the text of the model", SOURCE_CHARACTERS),
    "gallery": _text("a model of the gallery"),
    "name": _text("an entry of the list"),
    "environment": {"type": "array", "items": {"type": "object"}, "maxItems": 16,
                    "description": 'what answers the queries of plants: [{"type": "honda", "radius": 0.5}]'},
    "seed": _number("of the random numbers; the same seed gives the same plant", 0, 2**53),
    "parameters": {"type": "object", "description": "values of #define by name"},
    "simulation": _text("the `simulation` of create"),
    "steps": _number("how many", 1, 10_000, default=1),
    "module": _number("its index in the string, from 0; brackets count", 0, 2**31),
    "plant": _number("number of the plant, from 0", 0, 9999, default=0),
    "width": _number("in pixels", 16, 2000, default=800),
    "height": _number("in pixels", 16, 2000, default=600),
    "what": {"type": "string", "enum": ["string", "statistics", "turtle", "state-hash", "information"],
             "description": "the part"},
    "from": _number("first character or record", 0, 2**31, default=0),
    "count": _number(f"characters, or records ({PART_RECORDS} at most)", 1, PART_CHARACTERS, default=PART_CHARACTERS),
}


class Tool(NamedTuple):
    """A tool, with the names of the arguments that it needs and of others that it takes."""

    answer: Callable[[Tools, Arguments], Any]
    needs: Sequence[str] = ()
    takes: Sequence[str] = ()

    def described(self, name: str) -> Dict[str, Any]:
        """The tool as hosts see it."""
        return {"name": name, "description": self.answer.__doc__ or name, "inputSchema": {
            "type": "object", "properties": _chosen(ARGUMENTS, (*self.needs, *self.takes)),
            "required": self.needs, "additionalProperties": False}}


TOOLS: Mapping[str, Tool] = {
    "check": Tool(Tools.check, needs=("source",)),
    "gallery": Tool(Tools.gallery, takes=("name",)),
    "environments": Tool(Tools.environments, takes=("name",)),
    "create": Tool(Tools.create, takes=("source", "gallery", "environment", "seed", "parameters")),
    "step": Tool(Tools.step, needs=("simulation",), takes=("steps",)),
    "explain": Tool(Tools.explain, needs=("simulation", "module"), takes=("plant",)),
    "render": Tool(Tools.render, needs=("simulation",), takes=("width", "height")),
    "query": Tool(Tools.query, needs=("simulation", "what"), takes=("plant", "from", "count")),
    "delete": Tool(Tools.delete, needs=("simulation",)),
}

_TYPES: Mapping[str, Tuple[Any, str]] = {
    "string": (str, "a text"), "integer": (int, "a whole number"), "array": (list, "a list"),
    "object": (dict, "an object")}


def _problem(value: Any, schema: Mapping[str, Any]) -> str:
    """The problem of a value, as the end of a sentence; empty: none."""
    kind, name = _TYPES[schema["type"]]
    if not isinstance(value, kind) or isinstance(value, bool):
        return f"must be {name}"
    if "enum" in schema and value not in schema["enum"]:
        return f"must be one of {', '.join(schema['enum'])}"
    for bound, counted in (("maxLength", "characters"), ("maxItems", "entries")):
        if bound in schema and len(value) > schema[bound]:
            return f"has {len(value)} {counted}; {schema[bound]} are the most"
    if "items" in schema and not all(isinstance(item, dict) for item in value):
        return "must be a list of objects"
    if "minimum" in schema and not schema["minimum"] <= value <= schema["maximum"]:
        return f"must be from {schema['minimum']} to {schema['maximum']}"
    return ""


def fitting(name: str, arguments: Any) -> Arguments:
    """The arguments of a tool, checked and with defaults. EspalierError: some are missing, unknown or out of bounds."""
    needs, known = TOOLS[name].needs, _chosen(ARGUMENTS, (*TOOLS[name].needs, *TOOLS[name].takes))
    if not isinstance(arguments, dict):
        raise EspalierError(f"The arguments of {name} must be an object.")
    for word in needs:
        if word not in arguments:
            raise EspalierError(f"{name} needs `{word}`: {known[word]['description']}.")
    for word, value in arguments.items():
        if word not in known:
            raise EspalierError(f"{name} has no argument `{word[:100]}`. It takes: {', '.join(known)}.")
        if problem := _problem(value, known[word]):
            raise EspalierError(f"`{word}` of {name} {problem}.")
    return {**{word: schema["default"] for word, schema in known.items() if "default" in schema}, **arguments}
