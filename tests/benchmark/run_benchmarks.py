"""Runs the benchmark program and prints its figures as a table; the JSON is kept."""

import argparse
import json
import re
import subprocess
import sys

COLUMNS = (
    ("modules", "modules", "{:,.0f}", 1),
    ("modules/s", "M modules/s", "{:.1f}", 1e-6),
    ("scanned/s", "M scanned/s", "{:.1f}", 1e-6),
    ("bytes/module", "bytes/module", "{:.1f}", 1),
    ("copies", "x copying", "{:.1f}", 1),
    ("queries", "queries", "{:,.0f}", 1),
    ("queries/s", "k queries/s", "{:.0f}", 1e-3),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--json", required=True, help="file that receives all figures")
    parser.add_argument("names", nargs="*", help="only benchmarks whose name contains one of these")
    options = parser.parse_args()

    command = [options.program, f"--benchmark_out={options.json}", "--benchmark_out_format=json"]
    if options.names:
        command.append("--benchmark_filter=" + "|".join(re.escape(name) for name in options.names))
    finished = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if finished.returncode != 0:
        sys.stdout.write(finished.stdout)
        return finished.returncode

    with open(options.json, encoding="utf-8") as results:
        entries = json.load(results)["benchmarks"]
    if not entries:
        print("no benchmark has such a name")
        return 1
    rows = [["benchmark", "ms"] + [title for _, title, _, _ in COLUMNS]]
    for entry in entries:
        name = entry["name"].replace("/real_time", "")
        if entry.get("error_occurred"):
            rows.append([name, entry["error_message"]] + [""] * len(COLUMNS))
            continue
        row = [name, f"{entry['real_time']:,.2f}"]
        for key, _, form, factor in COLUMNS:
            row.append(form.format(entry[key] * factor) if key in entry else "")
        rows.append(row)

    # columns that no row fills are left out
    used = [i for i in range(len(rows[0])) if any(row[i] for row in rows[1:])]
    widths = {i: max(len(row[i]) for row in rows) for i in used}
    for row in rows:
        cells = [row[i].ljust(widths[i]) if i == 0 else row[i].rjust(widths[i]) for i in used]
        print("  ".join(cells).rstrip())
    return 0


if __name__ == "__main__":
    sys.exit(main())
