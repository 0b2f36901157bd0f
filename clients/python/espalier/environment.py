"""An environment in Python: a subclass with one method, and it is a program that grows plants talk to.

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
    """

    @classmethod
    def serve(cls, arguments: Optional[Sequence[str]] = None) -> NoReturn:
        """Runs the environment as a program and does not return; the command line says how it meets the server.

        `--offer HOST:PORT` connects to a server and offers itself, `--listen HOST:PORT` waits for a server to connect,
        and without either the messages go through standard input and output, for a server that starts the program.
        """
        sys.exit(main(cls, sys.argv[1:] if arguments is None else arguments))
