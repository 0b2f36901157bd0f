"""Speaks the Model Context Protocol on standard input and output, or over HTTP."""

from __future__ import annotations

import argparse
import signal
import sys
from contextlib import ExitStack

from ..client import Client
from ..connecting import token_in
from ..errors import EspalierError
from ..local_server import PrivateServer
from ..program import find_program
from . import serve
from .http import SESSIONS, serve_http
from .tools import SECONDS, SIMULATIONS, Tools


def main() -> int:
    parser = argparse.ArgumentParser(prog="python3 -m espalier.mcp", description=__doc__)
    for name, kind, meaning in (
            ("server", "ADDRESS", "a running server, as HOST:PORT or unix:PATH; without it a private one is started"),
            ("token-file", "FILE", "the token for --server, in the first line; its role bounds the tools"),
            ("http", "HOST:PORT", "listen here instead (Streamable HTTP); port 0 takes a free one and prints it"),
            ("http-token-file", "FILE", "the token that hosts need, in the first line; needed beyond this machine")):
        parser.add_argument(f"--{name}", metavar=kind, help=meaning)
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with ExitStack() as stack:
        try:
            program = find_program()
            files = options.token_file, options.http_token_file
            token, http_token = (None if file is None else token_in(file) for file in files)
            address = options.server
            if address is None:
                # it starts no commands, dials nobody, and is small
                simulations = SIMULATIONS * (SESSIONS if options.http else 1)
                limits = (f"simulations={simulations}", "memoryBytes=4000000000", f"callSeconds={SECONDS}")
                server = stack.enter_context(PrivateServer(program, [f"--limit={limit}" for limit in limits]))
                address, token = server.address, server.token

            def open_tools(stack: ExitStack) -> Tools:
                return Tools(stack.enter_context(Client(address, name="mcp", token=token)), program)

            if options.http:
                serve_http(options.http, open_tools, http_token)
            else:
                serve(open_tools(stack), sys.stdin.buffer, sys.stdout.buffer)
        except (EspalierError, OSError) as error:
            print(f"espalier.mcp: {error}", file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            return 130
    return 0


sys.exit(main())
