"""Configurations of environment processes drawn at random from their JSON schemas, and models whose modules go to
places that are too far, too near or equal. Used by test_random_configurations."""

import random
from typing import Any, Dict, Mapping

NUMBERS = (0, 1, 2, 3, 7, -1, 0.5, 1e-9, 1e-300, 5e-324, 1e9, 1e15, 65536, 1000, 1e6, 10000, -0.0, 90, 180)
PLACES = ("1", "1", "1", "0", "2", "10^9", "10^12", "-1", "3", "0.5")
TEXTS = ("", "x", "?E", "a" * 30)
DEEPEST = 5


def value(draw: random.Random, schema: Any, depth: int = 0) -> Any:
    """Something that a schema allows, near its bounds more often than elsewhere."""
    if depth > DEEPEST or not isinstance(schema, dict):
        return draw.choice(NUMBERS)
    if "enum" in schema:
        return draw.choice(schema["enum"])
    for several in ("oneOf", "anyOf"):
        if several in schema:
            return value(draw, draw.choice(schema[several]), depth + 1)
    kind = schema.get("type")
    kind = draw.choice(kind) if isinstance(kind, list) else kind
    if kind == "array":
        return [value(draw, schema.get("items", {}), depth + 1) for _ in range(length(draw, schema))]
    if kind == "object":
        needed = schema.get("required", ())
        return {name: value(draw, member, depth + 1) for name, member in schema.get("properties", {}).items()
                if name in needed or draw.random() < 0.3}
    if kind == "boolean":
        return draw.random() < 0.5
    if kind == "string":
        return draw.choice(TEXTS)
    return number(draw, schema, kind == "integer")


def length(draw: random.Random, schema: Mapping[str, Any]) -> int:
    least, most = schema.get("minItems"), schema.get("maxItems")
    found = int(least) if least is not None else draw.choice((0, 1, 2, 3, 6))
    return int(most) if most is not None and most < 20 and draw.random() < 0.3 else found


def number(draw: random.Random, schema: Mapping[str, Any], is_whole: bool) -> Any:
    least, most = schema.get("minimum"), schema.get("maximum")
    choices = [n for n in NUMBERS if (least is None or n >= least) and (most is None or n <= most)]
    choices += 3 * [bound for bound in (least, most) if bound is not None]
    found = draw.choice(choices) if choices else 1
    return int(found) if is_whole else found


def configuration(draw: random.Random, process: Mapping[str, Any]) -> Dict[str, Any]:
    """Of one process as environment.list names it: what it needs, and some of its other keys."""
    schema = process["schema"]
    share = draw.choice((0.1, 0.3))
    made = {name: value(draw, member) for name, member in schema.get("properties", {}).items()
            if name != "type" and (name in schema.get("required", ()) or draw.random() < share)}
    return {**made, "type": process["name"]}


def world(draw: random.Random) -> Dict[str, Any]:
    """A place, a time and weather, or less of them."""
    made: Dict[str, Any] = {}
    if draw.random() < 0.5:
        made.update(latitude=draw.choice((0, 51, 90, -89.9)), longitude=draw.choice((0, 7, -180)),
                    start=draw.choice(("2026-06-21T12:00", "2026-12-21", "2024-02-29T23:59Z")))
    if draw.random() < 0.5:
        made["stepDuration"] = draw.choice((1, "1 h", "30 min", 40, 1e-6))
    if draw.random() < 0.4:
        head = draw.choice(("global", "global,diffuse", "direct,diffuse", "direct", "temperature"))
        rows = [f"{day}" + "".join(f",{draw.choice((0, 1, 50))}" for _ in head.split(","))
                for day in draw.choice(((0, 1), (0, 0.5, 1, 1000)))]
        made["weather"] = "\n".join([f"time,{head}", *rows]) + "\n"
    return made


def model(draw: random.Random) -> Dict[str, Any]:
    """A branching plant with polygons, whose queries send numbers at random."""
    a, b, c, d, e = (draw.choice(PLACES) for _ in range(5))
    source = f"""Lsystem: 1
derivation length: 1000
Axiom: A
A --> F({a})[+(30)LF(1)?E({b},{c},1,1,{d})]/(137)F({a})?E({b},1,{e},1,1)A
L --> L
?E(a,b,c,d,e) --> ?E(a,b,c,d,e)
homomorphism
L --> {{.f(1)-(90).f(1).}}
endlsystem
"""
    view = "line style: cylinder\ninitial line width: 0.1\n"
    return {"files": {"random.l": source, "random.v": view}, "main": "random.l"}
