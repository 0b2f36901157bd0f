"""Espalier from Python: environments that plants grow against, and a client of the server. Standard library only."""

from . import measured, sweep
from .asynchronous import AsyncClient, AsyncSimulation, AsyncStream
from .breeding import BredPlant, serve_fitness
from .client import Client, Simulation, Stream
from .shapes import CompiledModel, Frame, StepResult, TurtleRecord
from .environment import Environment
from .errors import (ConnectionLost, EspalierError, ModelWarning, ProtocolError, RunWarning, ServerError,
                     ServerFailed)
from .geometry import Geometry
from .local_server import Local, local
from .model import Model
from .queries import Answer, Columns, Following, Opening, Query, Variable
from .server import Server
from .viewing import View
from .version import VERSION as __version__

__all__ = [
    "Answer", "AsyncClient", "AsyncSimulation", "AsyncStream", "BredPlant", "Client", "Columns", "CompiledModel",
    "ConnectionLost", "Environment", "EspalierError", "Following", "Frame", "Geometry", "Local", "Model", "ModelWarning", "Opening",
    "ProtocolError", "Query", "RunWarning", "Server", "ServerError", "ServerFailed", "Simulation", "StepResult", "Stream",
    "TurtleRecord", "Variable", "View", "__version__", "local", "measured", "serve_fitness", "sweep",
]
