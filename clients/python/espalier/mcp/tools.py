"""The tools of espalier.mcp: names, descriptions for hosts, and the arguments that they take within limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Mapping, Tuple

SECONDS = 30  # of a call; hosts wait for a minute
SIMULATIONS = 16  # of a session
SESSIONS = 8  # over HTTP
MODULES = 2_000_000  # of a simulation
SOURCE_CHARACTERS = 1_000_000
ANSWER_CHARACTERS = 50_000
PART_CHARACTERS = 40_000  # of a string

Arguments = Mapping[str, Any]


class Unfit(Exception):
    """Arguments that a tool does not take. The message is a whole sentence."""


@dataclass(frozen=True)
class Tool:
    """A tool, with its arguments as JSON Schema."""

    description: str
    properties: Mapping[str, Mapping[str, Any]]
    required: Tuple[str, ...] = ()

    def schema(self) -> Dict[str, Any]:
        return {"type": "object", "properties": {name: dict(schema) for name, schema in self.properties.items()},
                "required": list(self.required), "additionalProperties": False}


def _text(description: str, longest: int = 200) -> Dict[str, Any]:
    return {"type": "string", "description": description, "maxLength": longest}


def _number(description: str, least: int, greatest: int) -> Dict[str, Any]:
    return {"type": "integer", "description": description, "minimum": least, "maximum": greatest}


_SIMULATION = _text("the `simulation` of create")
_PLANT = _number("number of the plant, from 0", 0, 9999)
_FAR = 2**31

TOOLS: Mapping[str, Tool] = {
    "check": Tool("Compile an L-system (the cpfg dialect, from `Lsystem: 1` to `endlsystem`) and say every mistake with its place.",
                  {"source": _text("the text of the model", SOURCE_CHARACTERS)}, ("source",)),
    "gallery": Tool("List the models of the gallery, or read the files of one.", {"name": _text("a model of the list")}),
    "environments": Tool("List the environments that plants can ask, or describe one: configuration, units, sources.",
                         {"name": _text("an environment of the list")}),
    "create": Tool("Plant a model, at step 0. Give `source` or `gallery`.",
                   {"source": _text("the text of the model", SOURCE_CHARACTERS), "gallery": _text("a model of the gallery"),
                    "environment": {"type": "array", "description": 'what answers the queries of plants: [{"type": "honda", "radius": 0.5}]',
                                    "items": {"type": "object"}, "maxItems": 16},
                    "seed": _number("of the random numbers; the same seed gives the same plant", 0, 2**53),
                    "parameters": {"type": "object", "description": "values of #define by name"}}),
    "step": Tool("Make steps. Ends early when the model is finished.",
                 {"simulation": _SIMULATION, "steps": _number("how many", 1, 10_000)}, ("simulation",)),
    "explain": Tool("Say which production the next step applies to a module, and why not the others.",
                    {"simulation": _SIMULATION, "module": _number("its index in the string, from 0; brackets count", 0, _FAR), "plant": _PLANT},
                    ("simulation", "module")),
    "render": Tool("Draw the plants as they are, as a PNG.",
                   {"simulation": _SIMULATION, "width": _number("in pixels", 16, 2000), "height": _number("in pixels", 16, 2000)},
                   ("simulation",)),
    "query": Tool("Read the state: the derived string, statistics, turtle records (position, heading, width of every module), or the hash.",
                  {"simulation": _SIMULATION,
                   "what": {"type": "string", "enum": ["string", "statistics", "turtle", "state-hash", "information"], "description": "the part"},
                   "plant": _PLANT, "from": _number("first character or record", 0, _FAR),
                   "count": _number("characters, or records (200 at most)", 1, PART_CHARACTERS)}, ("simulation", "what")),
    "delete": Tool("Delete a simulation of create.", {"simulation": _SIMULATION}, ("simulation",)),
}

_TYPES: Mapping[str, Tuple[type, str]] = {"string": (str, "a text"), "integer": (int, "a whole number"), "array": (list, "a list"), "object": (dict, "an object")}


def _problem(value: Any, schema: Mapping[str, Any]) -> str:
    """What does not fit, as the end of a sentence; empty: nothing."""
    kind, name = _TYPES[schema["type"]]
    if not isinstance(value, kind) or isinstance(value, bool):
        return f"must be {name}"
    if "enum" in schema and value not in schema["enum"]:
        return f"must be one of {', '.join(schema['enum'])}"
    if isinstance(value, str) and len(value) > schema.get("maxLength", len(value)):
        return f"has {len(value)} characters; {schema['maxLength']} are the most"
    if isinstance(value, list):
        if len(value) > schema["maxItems"]:
            return f"has {len(value)} entries; {schema['maxItems']} are the most"
        if not all(isinstance(item, dict) for item in value):
            return "must be a list of objects"
    if isinstance(value, int) and not schema["minimum"] <= value <= schema["maximum"]:
        return f"must be from {schema['minimum']} to {schema['maximum']}"
    return ""


def fitting(name: str, arguments: Any) -> Arguments:
    """The arguments of a tool, checked. Unfit: some are missing, unknown or out of bounds."""
    tool = TOOLS[name]
    if not isinstance(arguments, dict):
        raise Unfit(f"The arguments of {name} must be an object.")
    for word in tool.required:
        if word not in arguments:
            raise Unfit(f"{name} needs `{word}`: {tool.properties[word]['description']}.")
    for word, value in arguments.items():
        if word not in tool.properties:
            raise Unfit(f"{name} has no argument `{word[:100]}`. It takes: {', '.join(tool.properties)}.")
        if problem := _problem(value, tool.properties[word]):
            raise Unfit(f"`{word}` of {name} {problem}.")
    return arguments
