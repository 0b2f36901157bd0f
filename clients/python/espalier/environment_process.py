"""The base of environments: what a subclass may define, and what it is told. environment.py adds the program around it."""

from __future__ import annotations

from typing import Any, ClassVar, Dict, Optional, Sequence

from .geometry import Geometry, form
from .queries import Answer, Columns, Opening, Query, Variable


class EnvironmentProcess:
    """Base class of environments. One object is made for every simulation, so attributes are a simulation's own.

    A subclass defines `answer` (one query at a time), `step` (all queries of all plants together) or `step_columns`
    (the same as arrays: a million queries a second), and may define `opened` (to read its configuration), `save` and `restore` (when it changes from step to step).
    """

    # what the server sends with each query: position heading left up width scale parameters following; and geometry,
    # what all plants look like
    needs: ClassVar[Sequence[str]] = ("position", "heading", "left", "up", "width", "scale", "parameters", "following")
    inputs: ClassVar[Sequence[Variable]] = ()
    outputs: ClassVar[Sequence[Variable]] = ()
    # True for an environment that changes from step to step; it then defines save and restore
    is_stateful: ClassVar[bool] = False

    # set before opened(): who asks
    opening: Opening = Opening("")
    # set before every step: completed steps of the plants, and their age in days
    completed_steps: int = 0
    days: float = 0.0
    # all plants as they are when they ask; None unless `needs` has geometry
    geometry: Optional[Geometry] = None

    @classmethod
    def name(cls) -> str:
        """The name it is offered under: by default the class's name in lower case."""
        return cls.__name__.lower()

    def opened(self) -> None:
        """Called once before the first step, and again on a new object after a simulation starts over."""

    def answer(self, query: Query) -> Answer:
        """The values the query's module gets, in order; None keeps what it sent.

        >>> class Ceiling(espalier.Environment):
        ...     def answer(self, query):
        ...         return [1 if query.position[1] < 3 else 0]
        >>> tip = client.create(gallery="growth-to-a-height", environment=[client.attach(Ceiling)])
        >>> tip.step().statistics["answers"]
        1
        """
        raise NotImplementedError(f"{type(self).__name__} defines neither answer(self, query) nor step(self, queries).")

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        """Answers of all queries of one step, in their order. Called also for a step without queries. Whatever it raises
        fails the step: the trace goes to standard error here, a sentence to who runs the simulation, and the same step is
        asked again when the simulation is stepped again."""
        return [self.answer(query) for query in queries]

    def step_columns(self, queries: Columns) -> Any:
        """Instead of `step`, for many queries: all of them as arrays. Returns an array of one number for every query
        (queries), or of rows of numbers (queries, values), which set the module's parameters in order; None keeps all.
        Numbers of any kind are taken, as doubles; they must be finite.

        >>> class Height(espalier.Environment):
        ...     needs = ("position",)
        ...     def step_columns(self, queries):
        ...         return queries.position[:, 1]                # of NumPy: (queries)
        """
        raise NotImplementedError

    def save(self) -> Any:
        """The complete state as a JSON value."""
        return None

    def restore(self, state: Any) -> None:
        """Goes back to a state that save() returned."""

    def closed(self) -> None:
        """Called when the simulation goes away."""

    @classmethod
    def description(cls) -> Dict[str, Any]:
        """What `environment.describe` answers."""
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
