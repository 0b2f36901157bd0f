"""`python3 -m espalier.survey SOURCE TARGET`: see the package."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import List, Optional, Tuple

from . import __doc__ as about
from .geotiff import heights_of, write_geotiff
from .las import require_place, surface_points, write_las
from .vtp import SurveyError, read_vtp, require_file, write_obj
from ..fields import FieldError, read_vti


def _origin(text: str) -> Tuple[float, float, float]:
    try:
        east, north, height = (float(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError("give three numbers: east,north,height") from None
    return east, north, height


def _write(options: argparse.Namespace, part: Path) -> None:
    kinds = (Path(options.source).suffix, part.suffix)
    require_file(options.source)
    require_place(options.origin)
    if kinds == (".vtp", ".las"):
        write_las(surface_points(read_vtp(options.source), options.spacing), part, options.origin)
    elif kinds == (".vtp", ".obj"):
        write_obj(read_vtp(options.source), part)
    elif kinds == (".vti", ".tif"):
        fields = read_vti(options.source)
        chosen = options.quantity or next(iter(fields.quantities))
        content = heights_of(fields, options.quantity, options.over, options.map or None)
        write_geotiff(content, part, options.epsg, options.origin, fields.quantities[chosen][0])
    else:
        raise SurveyError(f"there is no way from '{kinds[0]}' to '{kinds[1]}': give .vtp and .las, .vtp and .obj, or .vti and .tif.")


def main(arguments: "Optional[List[str]]" = None) -> int:
    parser = argparse.ArgumentParser("python3 -m espalier.survey", description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", help="a .vtp or .vti file")
    parser.add_argument("target", help=".las, .obj or .tif")
    parser.add_argument("--origin", type=_origin, default=(0.0, 0.0, 0.0), help="east,north,height of the origin of the world")
    parser.add_argument("--spacing", type=float, default=0.01, help="for .las: the largest distance of points (0.01)")
    parser.add_argument("--quantity", help="for .tif: the quantity of a file with several")
    parser.add_argument("--over", default="mean", help="for .tif: mean, sum, least or most of a column of cells (mean)")
    parser.add_argument("--map", action="store_true", help="for .tif: the field has one layer in z, and y is north (so is 'height')")
    parser.add_argument("--epsg", type=int, help="for .tif: the number of the projection")
    options = parser.parse_args(arguments)
    into = Path(options.target)
    try:
        # the target is as it was until the new file is complete
        with tempfile.TemporaryDirectory(dir=into.parent, prefix=".espalier-") as folder:
            part = Path(folder) / into.name
            _write(options, part)
            os.replace(part, into)
    except (SurveyError, FieldError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except OverflowError as error:
        print(f"error: a number of {options.source} or of the options is too large ({error}).", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"error: {into} cannot be written ({error.strerror or error}): give a path in a folder that exists, that you may write to and that has room.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
