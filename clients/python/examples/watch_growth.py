"""Grows a gallery model on a running server and prints the turtle stream of every step.

    espalier serve --listen 127.0.0.1:4321 --gallery clients/gallery &
    python3 clients/python/examples/watch_growth.py 127.0.0.1:4321 growth-to-a-height height
"""

from __future__ import annotations

import sys

from espalier import Client, EspalierError


def main(address: str, model: str, process: str) -> int:
    try:
        with Client(address, name="watch_growth") as client:
            simulation = client.create(gallery=model, environment=[{"type": process}])
            with simulation.stream("turtle") as stream:
                for frame in stream:
                    tallest = max((record.position[1] for record in frame.records), default=0.0)
                    print(f"step {frame.step}: {len(frame.records)} modules, height {tallest:g}")
                    if not frame.finished:
                        simulation.step()
            print(simulation.string())
            simulation.delete()
    except EspalierError as error:
        print(f"watch_growth: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: watch_growth.py HOST:PORT GALLERY-MODEL ENVIRONMENT")
    sys.exit(main(*sys.argv[1:]))
