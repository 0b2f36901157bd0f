"""Plots of the numbers of a simulation, with matplotlib."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Sequence

from .errors import EspalierError
from .shapes import StepResult


def plotted(history: Sequence[StepResult], records: Callable[[], Dict[str, List[Any]]], names: Sequence[str],
            by: Optional[str]) -> Any:
    """The axes with the columns `names`: statistics of `history`, or columns of the turtle records."""
    steps: Dict[str, List[Any]] = {"step": [made.step for made in history]}
    for name in sorted({key for made in history for key in made.statistics}):
        steps[name] = [made.statistics.get(name) for made in history]
    is_statistic = all(name in steps for name in names) or (not history and tuple(names) == ("modules",))
    columns = steps if is_statistic else records()
    over = by or ("step" if is_statistic else "module")
    for name in (*names, over):
        if name not in columns and (history or not is_statistic):
            raise EspalierError(f"There is no column '{name}'. Statistics: {', '.join(steps)}. Of the turtle records: "
                                f"{', '.join(records())}.")
    try:
        from matplotlib import pyplot  # type: ignore[import]
    except ImportError:
        raise EspalierError("plot() needs matplotlib (Debian: python3-matplotlib). The figures are in `history`.") from None
    axes = pyplot.figure().add_subplot()
    for name in names:
        axes.plot(columns.get(over, []), columns.get(name, []), "-" if is_statistic else ".", label=name)
    axes.set_xlabel(over)
    axes.legend()
    return axes
