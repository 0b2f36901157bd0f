"""How fast the studio is: runs clients/web/test/studio_benchmark.js in Chromium at a server of its own and prints its rows.

    python3 tests/benchmark/studio_benchmark.py --espalier build/release/bin/espalier

Needs Node, the packages of clients/web and Chromium. The browser draws without a graphics card; the times
without drawing are those of a page whose pictures are not drawn: what a graphics card does not take over.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import List

import results_page

WEB = Path(__file__).resolve().parents[2] / "clients" / "web"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
TITLE = "The studio, in a browser without a graphics card"


def verdict(row: dict) -> str:
    """Whether 95 of 100 times are within the target."""
    if row["target"] is None:
        return ""
    if row["p95"] <= row["target"]:
        return "met"
    if "undrawn" not in row:
        return "not measured without drawing"
    return "met without drawing" if row["undrawn"]["p95"] <= row["target"] else "NOT MET"


def table_of(measured: List[dict]) -> List[List[str]]:
    """The rows to print, those that were measured in part, too."""
    rows = [["in the studio", "times", "median ms", "95 of 100 ms", "without drawing: median", "95 of 100", "target ms", ""]]
    for row in measured:
        undrawn = [f"{row['undrawn'][part]:.1f}" for part in ("median", "p95")] if "undrawn" in row else ["", ""]
        rows.append([row["what"], str(row["times"]), f"{row['median']:.1f}", f"{row['p95']:.1f}", *undrawn, str(row["target"] or ""), verdict(row)])
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--espalier", required=True, help="the program")
    parser.add_argument("--results", help="page to append the table to")
    parser.add_argument("--update", metavar="PAGE", help="page in which the table takes the place of the one before")
    arguments = parser.parse_args()
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not browser or not shutil.which("node") or not (WEB / "node_modules").is_dir():
        print("the studio is not measured: Node, the packages of clients/web or Chromium are missing", file=sys.stderr)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        rows_file = Path(folder) / "rows.json"
        done = subprocess.run(["node", "--test", str(WEB / "test" / "studio_benchmark.js")], capture_output=True, text=True,
                              env={**os.environ, "ESPALIER_PROGRAM": str(Path(arguments.espalier).resolve()),
                                   "ESPALIER_CHROMIUM": browser, "ESPALIER_ROWS": str(rows_file)})
        measured = json.loads(rows_file.read_text(encoding="utf-8")) if rows_file.exists() else []
    print(results_page.table(table_of(measured)))
    if done.returncode != 0:
        print(done.stdout + done.stderr, file=sys.stderr)
        return 1
    rows = table_of(measured)
    if arguments.results:
        results_page.append_table(arguments.results, TITLE, rows)
    if arguments.update:
        results_page.update_tables(arguments.update, {TITLE: results_page.table(rows)})
    return 0


if __name__ == "__main__":
    sys.exit(main())
