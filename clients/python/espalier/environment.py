"""An environment in Python: a subclass with one method is a complete program.

    from espalier import Environment

    class Ceiling(Environment):
        def answer(self, query):
            return [1 if query.position[1] < 3 else 0]

    Ceiling.serve()
"""

from __future__ import annotations

import sys
from typing import NoReturn, Optional, Sequence

from .environment_process import EnvironmentProcess
from .hosting import main


class Environment(EnvironmentProcess):
    """Base class of environments: a subclass is also a program, by serve().

    A subclass defines `answer` (one query at a time), `step` (all queries of all plants together) or `step_columns` (the
    same as arrays, for many queries). It may define `opened` (to read its configuration), and `save` and `restore` (when
    it changes from step to step). Every simulation gets an object of its own, so attributes belong to one simulation.

    >>> class Ceiling(espalier.Environment):
    ...     def answer(self, query):
    ...         return [1 if query.position[1] < 3 else 0]
    >>> client.create(gallery="light-tree", environment=Ceiling, seed=7).step(2).statistics["answers"]
    4
    """

    @classmethod
    def serve(cls, arguments: Optional[Sequence[str]] = None) -> NoReturn:
        """Runs the environment as a program and does not return. The command line chooses the connection.

        `--offer HOST:PORT` connects to a server and offers the environment. `--listen HOST:PORT` waits for servers. Without
        both, messages use standard input and output, for a server that starts the program.
        """
        sys.exit(main(cls, sys.argv[1:] if arguments is None else arguments))
