"""The base class of environments, without the program that environment.py adds."""

from __future__ import annotations

from typing import Any, ClassVar, Dict, Optional, Sequence

from .geometry import Geometry, form
from .queries import Answer, Columns, Opening, Query, Variable


class EnvironmentProcess:
    """Base class of environments. One object is made for every simulation, so attributes are a simulation's own.

    A subclass defines `answer` (one query at a time), `step` (all queries of all plants together) or `step_columns`
    (the same as arrays, for many queries). It may define `opened` (to read its configuration), and `save` and `restore`
    (when it changes from step to step).
    """

    # parts of a query that the server sends: position heading left up width scale parameters following; and geometry,
    # the shape of all plants
    needs: ClassVar[Sequence[str]] = ("position", "heading", "left", "up", "width", "scale", "parameters", "following")
    inputs: ClassVar[Sequence[Variable]] = ()
    outputs: ClassVar[Sequence[Variable]] = ()
    # True for an environment that changes from step to step; it then defines save and restore. A class that defines save
    # has True by itself
    is_stateful: ClassVar[bool] = False

    # set before opened(): the simulation
    opening: Opening = Opening("")
    # set before every step: completed steps, and the age of the plants in days
    completed_steps: int = 0
    days: float = 0.0
    # the shape of all plants at their queries; None unless `needs` has geometry
    geometry: Optional[Geometry] = None

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        if "save" in vars(cls) and "is_stateful" not in vars(cls):
            cls.is_stateful = True

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: environment '{self.name()}' after step {self.completed_steps}>"

    @classmethod
    def name(cls) -> str:
        """The name of the environment on a server: by default the class name in lower case."""
        return cls.__name__.lower()

    def opened(self) -> None:
        """Called once before the first step, and again on a new object after a simulation starts over."""

    def answer(self, query: Query) -> Answer:
        """The new values of the parameters of the module, in order; None keeps a parameter.

        >>> class Ceiling(espalier.Environment):
        ...     def answer(self, query):
        ...         return [1 if query.position[1] < 3 else 0]
        >>> tip = client.create(gallery="growth-to-a-height", environment=[client.attach(Ceiling)])
        >>> tip.step().statistics["answers"]
        1
        """
        raise NotImplementedError(f"{type(self).__name__} defines neither answer(self, query) nor step(self, queries).")

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        """The answers to all queries of one step, in order. Called also for a step without queries. An exception fails the
        step: its trace goes to standard error here, and the user of the simulation gets a sentence. The next step of the
        simulation sends the same queries again."""
        return [self.answer(query) for query in queries]

    def step_columns(self, queries: Columns) -> Any:
        """Replaces `step` for many queries: all queries as arrays. Returns an array of one number for every query (queries),
        or of rows of numbers (queries, values), which set the parameters of the module in order; None keeps all. Numbers
        of any type become doubles and must be finite.

        >>> class Height(espalier.Environment):
        ...     needs = ("position",)
        ...     def step_columns(self, queries):
        ...         return queries.position[:, 1]                # of NumPy: (queries)
        """
        raise NotImplementedError

    def note(self, sentence: str) -> None:
        """Says something to the user of the simulation, as a warning of the step: that an input was out of range, that all
        queries were outside of the field. The same sentence is said once in a simulation. Of one step 50 sentences are
        said; the end of one of more than 1,000 bytes is cut off. Call it while a step is answered.

        >>> class Field(espalier.Environment):
        ...     def step(self, queries):
        ...         if all(query.position[1] > 10 for query in queries):
        ...             self.note("all queries are above the measured field")
        ...         return [[0] for query in queries]
        """
        notes = self.__dict__.setdefault("_notes_of_step", [])
        if sentence not in notes and len(notes) < 50:
            notes.append(str(sentence))

    def save(self) -> Any:
        """The complete state as a JSON value."""
        return None

    def restore(self, state: Any) -> None:
        """Goes back to a state that save() returned."""

    def closed(self) -> None:
        """Called when the simulation ends."""

    @classmethod
    def description(cls) -> Dict[str, Any]:
        """The answer to `environment.describe`."""
        summary = (cls.__doc__ or "").strip().split("\n")[0]
        asked = {"geometry": form()} if "geometry" in cls.needs else {}
        return {
            "name": cls.name(),
            "summary": summary,
            "needs": list(cls.needs),
            "inputs": [variable.as_json() for variable in cls.inputs],
            "outputs": [variable.as_json() for variable in cls.outputs],
            "stateful": cls.is_stateful,
            "checkpoint": cls.is_stateful,
            **asked,
        }
