"""Plants in a page: complete HTML for notebooks and files, drawn by three.js.

    with espalier.local() as client:
        plant = client.create(gallery="light-tree", seed=7, environment=[…])
        plant.step(6)
        plant.view()                    # the last line of a notebook's cell shows it
        plant.view().save("plant.html") # the same as a file that needs nothing else
"""

from __future__ import annotations

import base64
import gzip
import html
import json
from pathlib import Path
from typing import List, Sequence, Union

from .errors import EspalierError
from .frame_packing import pack_frame
from .program import drawn_by, find_program

# in an installed package, and in the source tree
SCRIPTS = (Path(__file__).parent / "viewer" / "espalier.js", Path(__file__).parents[2] / "web" / "espalier.js")
# of deflated frames, so that a page stays below 3 MB (frame_packing.py makes a third of them); and the levels of detail that are tried
MOST_BYTES = 5_000_000
DETAILS = ("1", "0.6", "0.4")
# suffixes of files that are no snapshot: those that the program writes, and other pictures
DRAWINGS = frozenset(".png .svg .eps .ps .glb .obj .ply .stl .usda .vtp .vtu .mtg .rsml .csv .string .mp4 .webm .gif "
                     ".html .htm .jpg .jpeg .pdf .gltf".split())
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{title}</title>
<style>html,body,#plant{{margin:0;width:100%;height:100%;overflow:hidden;position:relative}}</style></head>
<body><div id="plant"></div>
<script>const frames = {frames};
(async () => {{
  const plant = document.getElementById("plant");
  try {{
    const packed = Uint8Array.from(atob("{script}"), (character) => character.charCodeAt(0));
    const script = document.createElement("script");
    script.textContent = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
    document.head.append(script);
  }} catch (error) {{
    plant.textContent = `This browser cannot unpack the page (${{error.message}}): use a newer browser.`;
    plant.dataset.state = "failed";
    return;
  }}
  await espalier.showPlant(plant, {order}.map((index) => frames[index]));
}})();</script>
</body></html>
"""


class View:
    """A page with one plant, or with the frames of its growth. A notebook shows it; save() writes it to a file.

    >>> view = client.create(gallery="classic-weed").view()
    >>> len(view.frames), view.frames[0][:4]
    (1, b'glTF')
    """

    def __init__(self, frames: Sequence[bytes], title: str = "Espalier", height: int = 480) -> None:
        """`frames`: binary glTF files (.glb); `height`: of the notebook's cell, in pixels."""
        if not frames:
            raise EspalierError("A view needs at least one frame.")
        self.frames = list(frames)
        self.title = title
        self.height = height

    def html(self) -> str:
        """The page as a text. It loads nothing from other places. Coordinates are rounded to 1/16384 of the plant, normals to half a
        degree; `frames` has the exact ones."""
        script = next((path.read_text(encoding="utf-8") for path in SCRIPTS if path.is_file()), None)
        if script is None:
            raise EspalierError("The viewer's script espalier.js is missing, so no page can show the plant. A copy of the folder "
                                "clients/python alone does not have it: install the package from the whole source tree. The build makes it "
                                "with Node.js: install Node.js 18 or newer with npm (Debian: apt-get install nodejs npm), run "
                                "./dev build in the source tree, then install the package again.")
        # the page unpacks them; equal ones, as after the end of growth, are there once
        different = list(dict.fromkeys(self.frames))
        frames = json.dumps([base64.b64encode(pack_frame(frame)).decode("ascii") for frame in different])
        packed = base64.b64encode(gzip.compress(script.encode("utf-8"), 9, mtime=0)).decode("ascii")
        return PAGE.format(title=html.escape(self.title), script=packed, frames=frames, order=[different.index(frame) for frame in self.frames])

    def __repr__(self) -> str:
        size = sum(len(frame) for frame in self.frames)
        return f"<View of {self.title!r}: {len(self.frames)} frame{'s' * (len(self.frames) != 1)}, {size / 1e6:.1f} MB>"

    def save(self, path: Union[str, "Path"]) -> None:
        """Writes the page."""
        Path(path).write_text(self.html(), encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:{self.height}px;border:0"></iframe>'


def refuse_drawing(path: Path) -> None:
    """A ValueError when a snapshot would be written under the name of a drawing."""
    if path.suffix.lower() not in DRAWINGS:
        return
    ways = {".html": f"A page is written by view().save({path.name!r}).",
            ".glb": f"The drawing as glTF is geometry(): Path({path.name!r}).write_bytes(plant.geometry())."}
    way = ways.get(path.suffix.lower(), f"view() draws the plant. For a file: save_to('{path.stem}.snapshot'), then in a shell "
                                        f"espalier run --resume {path.stem}.snapshot -o {path.name}")
    raise ValueError(f"save_to() writes a snapshot, and {path.name!r} is the name of another kind of file. {way}")


def geometry_of(snapshots: Sequence[bytes]) -> List[bytes]:
    """The binary glTF of each snapshot, drawn by the program `espalier` of this machine. When the frames are too large for
    a page, they are drawn with fewer sides."""
    drawn: List[bytes] = []
    for detail in DETAILS:
        drawn = _draw(snapshots, detail)
        if sum(len(gzip.compress(frame, 1)) for frame in set(drawn)) < MOST_BYTES:
            break
    return drawn


def _draw(snapshots: Sequence[bytes], detail: str) -> List[bytes]:
    program = find_program()
    return [drawn_by(program, snapshot, ".glb", "--instancing", "--detail", detail) for snapshot in snapshots]
