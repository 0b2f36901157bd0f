"""Runs the benchmark program and prints its figures: the targets met or not met, no-cliff rows, everything else.

All figures are kept as JSON; with --baseline each row also says how the time compares with an earlier JSON.
"""

import argparse
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

import results_page

MILLION = 1e6

# benchmark, counter, what it counts, target, figure of the reference program: README.md says where they are from
TARGETS = (
    ("derive/d0l/11", "modules/s", "final modules/s", 1500 * MILLION, 146 * MILLION),
    ("derive/parametric/20", "modules/s", "final modules/s", 280 * MILLION, 28 * MILLION),
    ("derive/parametric/22", "modules/s", "final modules/s", 280 * MILLION, 26 * MILLION),
    ("derive/signal-up/123", "scanned/s", "modules read/s", 260 * MILLION, 26 * MILLION),
    ("derive/diffusion/123", "scanned/s", "modules read/s", 130 * MILLION, 13 * MILLION),
    ("derive/signal-down/123", "scanned/s", "modules read/s", 230 * MILLION, 23 * MILLION),
    ("derive/stochastic/13", "modules/s", "final modules/s", 480 * MILLION, 48 * MILLION),
    ("open/height/1", "queries/s", "queries/s", 8 * MILLION, 0.4 * MILLION),
    ("remote/inside", "queries/s", "queries/s", 8 * MILLION, None),
    ("remote/tcp-binary", "queries/s", "queries/s", 3 * MILLION, 0.4 * MILLION),
    ("remote/tcp-text", "queries/s", "queries/s", 0.4 * MILLION, 0.4 * MILLION),
    ("scene/d0l/8", "modules/s", "modules drawn/s", 20 * MILLION, None),
    ("scene/d0l/9", "modules/s", "modules drawn/s", 20 * MILLION, None),
    ("scene/parametric/17", "modules/s", "modules drawn/s", 20 * MILLION, None),
    ("scene/parametric/19", "modules/s", "modules drawn/s", 20 * MILLION, None),
)
# milliseconds of derivation by the reference program for the same models and steps; the target is a fifth, the goal a tenth
FIELD_REFERENCES = {"field-models/blocks/20": 109.0, "field-models/accounts/15/40": 381.0}
TEXT_TARGETS = {"d0l": 2.0, "stochastic": 2.0, "parametric": 0.4, "parameters": 0.4, "diffusion": 0.4}  # GB/s by two threads
FIELD_TARGET = 5.0
FIELD_GOAL = 10.0
MEMORY_TARGET = 1.1  # resident memory over the two strings' 2 bytes a module and 8 a parameter; pages are not divided
START_UP_TARGET = 5.0  # milliseconds of the whole process that derives a small model, above those of a process that does nothing
THREAD_TARGET = 0.9  # gain of two threads over the gain of two threads that copy

VIEWERS_CPU_TARGET = 1.1  # processor time of the thread that steps, with 50 viewers over without
VIEWERS_WALL_TARGET = 1.5  # the median time of such a step

ROUND_TRIP_TARGET = 3.0  # median of a step of a small plant over a bare echo of as many bytes, each alone on the machine

SWEEP_TARGET = 1.05  # runs of a sweep over the same runs in a bare loop
SWEEP_MINUTES = 10.0  # of 10^5 runs by two workers

# milliseconds when the work on them began, of one thread
ENVIRONMENTS_BEFORE = {"trees-by-account": 752.0, "stand-year": 5100.0, "self-organizing-tree": 1200.0, "roots-in-soil": 1700.0}
ENVIRONMENT_TARGET = 3.0  # x before

# model, format and derivation length; whole commands that write plants over 10^6 modules
WHOLE_COMMANDS = (("twigs", ".png", 17), ("twigs", ".glb", 17), ("twigs", ".obj", 17), ("twigs", ".png", 19), ("twigs", ".glb", 19),
                  ("drawn-twigs", ".glb", 17), ("drawn-twigs", ".png", 17), ("drawn-twigs", ".glb", 19))
WHOLE_COMMAND_TARGET = 1.6  # time of one thread over that of two

OTHER_COLUMNS = (
    ("modules", "modules", "{:,.0f}", 1),
    ("modules/s", "M modules/s", "{:.1f}", 1e-6),
    ("scanned/s", "M read/s", "{:.1f}", 1e-6),
    ("bytes/module", "bytes/module", "{:.1f}", 1),
    ("queries", "queries", "{:,.0f}", 1),
    ("queries/s", "M queries/s", "{:.2f}", 1e-6),
    ("bytes/s", "GB/s", "{:.2f}", 1e-9),
)


def print_table(title: str, rows: list[list[str]], page: results_page.Page) -> None:
    """The first row holds the titles; columns that no row fills are left out."""
    if len(rows) < 2:
        return
    page.add_table(title, rows)
    used = [i for i in range(len(rows[0])) if any(row[i] for row in rows[1:])]
    widths = {i: max(len(row[i]) for row in rows) for i in used}
    print(f"\n{title}")
    for row in rows:
        cells = [row[i].ljust(widths[i]) if i == 0 else row[i].rjust(widths[i]) for i in used]
        print("  " + "  ".join(cells).rstrip())


def milliseconds(entry: dict) -> float:
    return entry.get("best ms", entry["real_time"])


def against(entry: dict, baseline: dict) -> str:
    """Time of the baseline over the time now: above 1 is faster than it was."""
    name = name_of(entry)
    if name not in baseline or "error_occurred" in entry:
        return ""
    return f"{milliseconds(baseline[name]) / milliseconds(entry):.2f}"


def name_of(entry: dict) -> str:
    name = re.sub(r"/(min_time|iterations):[0-9.]+", "", entry["name"])
    return name.replace("/real_time", "").replace("/manual_time", "")


def verdict(is_met: bool) -> str:
    return "met" if is_met else "NOT MET"


def target_rows(entries: dict, baseline: dict, command_times: dict) -> list[list[str]]:
    rows = [["workload", "ms", "command ms", "figure", "measured", "target", "", "reference", "x reference",
             "GB/s written", "GB/s copied", "of copying", "bytes/module", "x baseline"]]
    for name, counter, figure, target, reference in TARGETS:
        entry = entries.get(name)
        if entry is None:
            continue
        measured = entry[counter]
        row = [name, f"{milliseconds(entry):,.2f}", command_times.get(name, ""), figure, f"{measured / MILLION:,.1f} M",
               f"{target / MILLION:,.0f} M", verdict(measured >= target),
               f"{reference / MILLION:,.1f} M" if reference else "", f"{measured / reference:.1f}" if reference else ""]
        if "written bytes/s" in entry:
            written, copied = entry["written bytes/s"], entry["copied bytes/s"]
            row += [f"{written / 1e9:.2f}", f"{copied / 1e9:.2f}", f"{written / copied:.2f}",
                    f"{entry['bytes/module']:.1f}"]
        else:
            row += [""] * 4
        rows.append(row + [against(entry, baseline)])
    return rows


def memory_rows(entries: dict) -> list[list[str]]:
    rows = [["workload", "resident / (2 + 8p bytes a module, both strings)", "target", ""]]
    for name, entry in entries.items():
        if name.startswith("derive/") and "resident/string" in entry:
            share = entry["resident/string"]
            rows.append([name, f"{share:.2f}", f"{MEMORY_TARGET}", verdict(share <= MEMORY_TARGET)])
    return rows


def thread_rows(entries: dict) -> list[list[str]]:
    rows = [["workload", "modules", "derivation gains", "a copy gains", "share", "target", "", "median of rounds",
             "of copying by two"]]
    for name, entry in entries.items():
        if "copy gain" in entry:
            share = entry["gain"] / entry["copy gain"]
            rows.append([name, f"{entry['modules']:,.0f}", f"{entry['gain']:.2f}", f"{entry['copy gain']:.2f}",
                         f"{share:.2f}", f"{THREAD_TARGET}", verdict(share >= THREAD_TARGET),
                         f"{entry['median share']:.2f}",
                         f"{entry['written bytes/s'] / entry['copied bytes/s']:.2f}"])
    return rows


def server_rows(entries: dict) -> list[list[str]]:
    rows = [["a step over TCP", "median us", "99 of 100 us", "ping median us", "echo median us", "echo 99 us", "x echo",
             "x echo 99", "target", ""]]
    for name, entry in entries.items():
        if "echo median us" in entry:
            shares = [entry[f"step {which} us"] / entry[f"echo {which} us"] for which in ("median", "p99")]
            rows.append([name, f"{entry['step median us']:.0f}", f"{entry['step p99 us']:.0f}",
                         f"{entry['ping median us']:.0f}", f"{entry['echo median us']:.0f}",
                         f"{entry['echo p99 us']:.0f}", f"{shares[0]:.2f}", f"{shares[1]:.2f}",
                         f"{ROUND_TRIP_TARGET}", verdict(shares[0] <= ROUND_TRIP_TARGET)])
    return rows


def field_rows(entries: dict) -> list[list[str]]:
    rows = [["field", "ms", "GB/s touched", "GB/s of a plain copy", "of copying"]]
    for name, entry in entries.items():
        if name.startswith("field/"):
            touched, copied = entry["bytes/s"], entry["copied bytes/s"]
            rows.append([name, f"{milliseconds(entry):,.2f}", f"{touched / 1e9:.2f}", f"{copied / 1e9:.2f}",
                         f"{touched / copied:.2f}"])
    return rows


def field_model_rows(entries: dict) -> list[list[str]]:
    rows = [["model as modellers write it", "modules", "derivation ms", "reference ms", "x reference", "target", "", "goal", ""]]
    for name, reference in FIELD_REFERENCES.items():
        if name in entries:
            taken = entries[name]["derivation ms"]
            gain = reference / taken
            rows.append([name, f"{entries[name]['modules']:,.0f}", f"{taken:,.1f}", f"{reference:,.0f}", f"{gain:.1f}", f"{FIELD_TARGET:.0f}",
                         verdict(gain >= FIELD_TARGET), f"{FIELD_GOAL:.0f}", verdict(gain >= FIELD_GOAL)])
    return rows


def whole_model_rows(entries: dict) -> list[list[str]]:
    """A run from the axiom to the text, part by part."""
    parts = ("derivation ms", "environment ms", "interpretation ms", "writing ms")
    rows = [["whole model", "modules", "ms", *parts, "ns a module derived"]]
    for name, entry in entries.items():
        if name.startswith("field-models/"):
            rows.append([name, f"{entry['modules']:,.0f}", f"{milliseconds(entry):,.2f}", *(f"{entry[part]:,.1f}" for part in parts),
                         f"{entry['ns/module']:,.1f}"])
    return rows


def environment_rows(espalier: str) -> list[list[str]]:
    """The environment's part of `espalier derive` for models of the gallery, the best of three runs, by one thread and by two."""
    rows = [["model of the gallery", "queries", "environment ms, one thread", "two threads", "before, one thread", "x before, one thread",
             "two threads", "target", ""]]
    for model, before in ENVIRONMENTS_BEFORE.items():
        best = {}
        for threads in (1, 2) * 3:
            run = subprocess.run([espalier, "derive", model, "--quiet", "--statistics", "--threads", str(threads)],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
            statistics_of_run = json.loads(run.stderr)
            taken = statistics_of_run["environmentMilliseconds"]
            best[threads] = min(best.get(threads, taken), taken)
        gain = before / min(best.values())
        rows.append([model, f"{statistics_of_run['queries']:,}", *(f"{best[threads]:,.0f}" for threads in (1, 2)), f"{before:,.0f}",
                     f"{before / best[1]:.1f}", f"{before / best[2]:.1f}", f"{ENVIRONMENT_TARGET:.0f}", verdict(gain >= ENVIRONMENT_TARGET)])
    return rows


def whole_command_rows(espalier: str, models: str) -> list[list[str]]:
    """`espalier run -o FILE` by one thread and by two in turn, seven times, from start to end; no file is there before.

    Beside it, what the machine gives: the time of one process that only computes, twice, over that of two at the same time.
    """
    rows = [["espalier run -o", "modules, about", "one thread ms", "two threads ms", "gain", "target", "", "two processes that only compute"]]
    compute = [sys.executable, "-c", "sum(i * i for i in range(4_000_000))"]
    for model, suffix, steps in WHOLE_COMMANDS:
        taken: dict[int, list[float]] = {1: [], 2: []}
        machine = []
        for _ in range(7):
            for threads, times in taken.items():
                with tempfile.TemporaryDirectory(dir=pathlib.Path(espalier).parent) as folder:
                    start = time.perf_counter()
                    subprocess.run([espalier, "run", f"{models}/{model}.l", "--define", f"N={steps}", "-o", f"{folder}/twigs{suffix}",
                                    "--threads", str(threads), "--quiet"], stdout=subprocess.DEVNULL, check=True)
                    times.append((time.perf_counter() - start) * 1e3)
            start = time.perf_counter()
            subprocess.run(compute, check=True)
            middle = time.perf_counter()
            both = [subprocess.Popen(compute) for _ in range(2)]
            for process in both:
                process.wait()
            machine.append(2 * (middle - start) / (time.perf_counter() - middle))
        gain = statistics.median(one / two for one, two in zip(*taken.values()))
        rows.append([f"{model}{suffix}, N={steps}", f"{10 * 2**steps:,}", *(f"{statistics.median(times):,.0f}" for times in taken.values()),
                     f"{gain:.2f}", f"{WHOLE_COMMAND_TARGET}", verdict(gain >= WHOLE_COMMAND_TARGET), f"{statistics.median(machine):.2f}"])
    return rows


def text_rows(entries: dict) -> list[list[str]]:
    """Only both cores together have a target."""
    rows = [["text into memory", "GB/s", "GB/s copied", "target", ""]]
    for name, entry in entries.items():
        if name.startswith("text/"):
            _, model, _, threads = name.split("/")
            speed, target = entry["GB/s text"], TEXT_TARGETS[model]
            rows.append([name, f"{speed:.2f}", f"{entry['GB/s copied']:.2f}",
                         *((f"{target:.1f}", verdict(speed >= target)) if threads == "2" else ("", ""))])
    return rows


def sweep_rows(entries: dict) -> list[list[str]]:
    rows = [["sweep", "modules", "runs/s, one worker", "x bare loop", "target", "", "x its processor time",
             "100,000 runs by two, extrapolated", "target", ""]]
    for name, entry in entries.items():
        if name.startswith("sweep/"):
            share, minutes = entry["of a bare loop"], entry["minutes for 100000"]
            rows.append([name, f"{entry['modules']:,.0f}", f"{entry['runs/s']:,.0f}", f"{share:.3f}", f"{SWEEP_TARGET}",
                         verdict(share <= SWEEP_TARGET), f"{entry['of its processor time']:.3f}",
                         f"{minutes:.1f} min", f"{SWEEP_MINUTES:.0f} min", verdict(minutes <= SWEEP_MINUTES)])
    return rows


def change_rows(entries: dict) -> list[list[str]]:
    rows = [["one organ in a hundred changed", "ms", "ms of a new beginning", "gain"]]
    for name, entry in entries.items():
        if name.startswith("change/"):
            rows.append([name, f"{milliseconds(entry):,.2f}", f"{entry['anew ms']:,.2f}", f"{entry['gain']:.1f}"])
    return rows


def stream_rows(entries: dict) -> list[list[str]]:
    rows = [["a frame of a big plant", "modules", "frame bytes", "first ms", "making ms", "sending ms",
             "copying as many bytes ms", "copying the string ms"]]
    for name, entry in entries.items():
        if "frame bytes" in entry:
            rows.append([name, f"{entry['modules']:,.0f}", f"{entry['frame bytes']:,.0f}", f"{entry['first ms']:.1f}",
                         f"{entry['making ms']:.2f}", f"{entry['sending ms']:.4f}", f"{entry['copy ms']:.4f}",
                         f"{entry['string copy ms']:.2f}"])
    return rows


def viewer_rows(entries: dict) -> list[list[str]]:
    """Instructions are shown where the system counts those of a thread."""
    rows = [["steps with 50 viewers", "modules", "alone us", "with viewers us", "wall ratio", "target", "",
             "CPU ratio of the stepping thread", "target", "", "CPU ratio of two runs without viewers", "its instruction ratio"]]
    for name, entry in entries.items():
        if name.startswith("viewers/"):
            wall, processor = entry["viewers wall ratio"], entry["viewers cpu ratio"]
            instructions = entry.get("viewers instruction ratio")
            rows.append([name, f"{entry['modules']:,.0f}", f"{entry['alone us']:,.1f}", f"{entry['real_time']:,.1f}",
                         f"{wall:.2f}", f"{VIEWERS_WALL_TARGET}", verdict(wall <= VIEWERS_WALL_TARGET),
                         f"{processor:.2f}", f"{VIEWERS_CPU_TARGET}", verdict(processor <= VIEWERS_CPU_TARGET),
                         f"{entry['alone cpu ratio']:.2f}", f"{instructions:.3f}" if instructions else ""])
    return rows


def store_rows(entries: dict) -> list[list[str]]:
    """Saves of so many simulations at a time. The bare request to the disk stands beside them."""
    rows = [["saves into the data folder", "saves/s", "median ms of a save", "saves a request to the disk",
             "writing and forcing as many bytes ms", "saves/s, x one after the other"]]
    for name, entry in entries.items():
        if name.startswith("store/"):
            forcing, shared = entry["forcing ms"], entry["saves/request"]
            rows.append([name, f"{entry['saves/s']:,.0f}", f"{entry['median ms']:.2f}", f"{shared:.1f}" if shared else "none",
                         f"{forcing:.2f}", f"{entry['saves/s'] * forcing / 1e3:.2f}" if shared and forcing else ""])
    return rows


def cliff_rows(entries: dict, baseline: dict) -> list[list[str]]:
    rows = [["workload", "ms", "modules", "M read/s", "of copying", "bytes/module", "x baseline"]]
    for name, entry in entries.items():
        if name.startswith("derive-cliff/"):
            rows.append([name, f"{milliseconds(entry):,.2f}", f"{entry['modules']:,.0f}",
                         f"{entry['scanned/s'] / MILLION:.1f}",
                         f"{entry['written bytes/s'] / entry['copied bytes/s']:.2f}", f"{entry['bytes/module']:.1f}",
                         against(entry, baseline)])
    return rows


def other_rows(entries: dict, baseline: dict) -> list[list[str]]:
    rows = [["benchmark", "ms"] + [title for _, title, _, _ in OTHER_COLUMNS] + ["x baseline"]]
    shown = {name for name, *_ in TARGETS}
    for name, entry in entries.items():
        if name in shown or name.startswith(("derive-cliff/", "derive-threads/", "server/", "stream/", "viewers/", "store/", "field/", "field-models/", "change/", "text/")):
            continue
        row = [name, f"{milliseconds(entry):,.2f}"]
        for key, _, form, factor in OTHER_COLUMNS:
            row.append(form.format(entry[key] * factor) if key in entry else "")
        rows.append(row + [against(entry, baseline)])
    return rows


def growth_rows(entries: dict) -> list[list[str]]:
    """The exponent e of time ~ queries^e of every process, fitted to its sizes of 1000 queries and more."""
    points: dict = {}
    for name, entry in entries.items():
        match = re.fullmatch(r"(process/[\w-]+)/(\d+)", name)
        if match and not entry.get("error_occurred") and int(match.group(2)) >= 1000:
            points.setdefault(match.group(1), []).append((math.log(int(match.group(2))), math.log(milliseconds(entry))))
    rows = [["process", "time grows as queries^"]]
    for name, fitted in points.items():
        if len(fitted) > 1:
            mean_x = sum(x for x, _ in fitted) / len(fitted)
            mean_y = sum(y for _, y in fitted) / len(fitted)
            rise = sum((x - mean_x) * (y - mean_y) for x, y in fitted) / sum((x - mean_x) ** 2 for x, _ in fitted)
            rows.append([name, f"{rise:.2f}"])
    return rows


def time_commands(espalier: str, models: str, entries: dict) -> dict:
    """`derivationMilliseconds` of the command line for the workloads of the table, the best of three runs."""
    times = {}
    for name in entries:
        if not name.startswith("derive/"):
            continue
        _, model, steps = name.split("/")
        best = None
        for _ in range(3):
            run = subprocess.run([espalier, "derive", f"{models}/{model}.l", "--define", f"N={steps}", "--quiet",
                                  "--statistics"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                 check=True)
            taken = json.loads(run.stderr)["derivationMilliseconds"]
            best = taken if best is None else min(best, taken)
        times[name] = f"{best:,.2f}"
    return times


def start_up_rows(espalier: str, models: str) -> list[list[str]]:
    command = [espalier, "derive", f"{models}/d0l.l", "--define", "N=3", "--quiet"]
    times, empty = [], []
    for _ in range(100):
        for measured, started in ((times, command), (empty, ["/bin/true"])):
            start = time.perf_counter()
            subprocess.run(started, stdout=subprocess.DEVNULL, check=True)
            measured.append((time.perf_counter() - start) * 1e3)
    median, nothing = statistics.median(times), statistics.median(empty)
    return [["command", "median ms", "fastest ms", "a process that does nothing ms", "above it", "target", ""],
            ["espalier derive d0l.l, 3 steps", f"{median:.2f}", f"{min(times):.2f}", f"{nothing:.2f}", f"{median - nothing:.2f}",
             f"{START_UP_TARGET:.0f} ms", verdict(median - nothing <= START_UP_TARGET)]]


def read_entries(file: str) -> dict:
    with open(file, encoding="utf-8") as results:
        return {name_of(entry): entry for entry in json.load(results)["benchmarks"]}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="espalier_benchmark")
    parser.add_argument("--espalier", required=True, help="the command line, whose own figure is shown beside")
    parser.add_argument("--models", required=True, help="folder of the models")
    parser.add_argument("--json", required=True, help="file that receives all figures")
    parser.add_argument("--baseline", help="JSON of an earlier run: adds the column `x baseline`, above 1 is faster now")
    parser.add_argument("--results", help="page that receives the tables")
    parser.add_argument("--update", help="page in which the tables of this run take the place of earlier ones")
    parser.add_argument("names", nargs="*", help="only benchmarks whose name contains one of these")
    options = parser.parse_args()

    baseline = read_entries(options.baseline) if options.baseline else {}
    # seconds of each row that has no time of its own; there are 400
    command = [options.program, f"--benchmark_out={options.json}", "--benchmark_out_format=json", "--benchmark_min_time=0.2"]
    # the table of derivation has a row for the environment's part of a step
    names = options.names + (["open/height/1"] if "derive" in options.names else [])
    if names:
        # its expressions know no escaped hyphen, which re.escape would make
        command.append("--benchmark_filter=" + "|".join(re.escape(name).replace(r"\-", "-") for name in names))
    # all of it takes many minutes: each figure is shown as it comes
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as running:
        for line in running.stdout:
            sys.stderr.write(line)
            sys.stderr.flush()
    if running.returncode != 0:
        return running.returncode
    entries = read_entries(options.json)
    if not entries:
        print("no benchmark has such a name")
        return 1
    failed = {name: entry for name, entry in entries.items() if entry.get("error_occurred")}
    entries = {name: entry for name, entry in entries.items() if name not in failed}

    page = results_page.Page(options.espalier, options.names)
    commands = time_commands(options.espalier, options.models, entries)
    print_table("Targets, one core", target_rows(entries, baseline, commands), page)
    if not options.names or "derive" in options.names:
        print_table("Start-up, the process from start to end", start_up_rows(options.espalier, options.models), page)
    print_table("Memory, one core", memory_rows(entries), page)
    print_table("Models as modellers write them", field_model_rows(entries), page)
    print_table("Whole models, part by part", whole_model_rows(entries), page)
    if not options.names or any("field-models".startswith(name) or name.startswith("field-models") for name in options.names):
        print_table("Environments of models of the gallery", environment_rows(options.espalier), page)
        print_table("Whole commands, two threads over one", whole_command_rows(options.espalier, options.models), page)
    print_table("Text", text_rows(entries), page)
    print_table("Two threads over one", thread_rows(entries), page)
    print_table("A server in another process", server_rows(entries), page)
    print_table("Viewers: what changed, and the whole", stream_rows(entries), page)
    print_table("Viewers beside steps", viewer_rows(entries), page)
    print_table("Saves: durability process, and power", store_rows(entries), page)
    print_table("No cliff: small strings, many productions and parameters, nesting, contexts",
                cliff_rows(entries, baseline), page)
    print_table("Fields, beside plain copies of as many bytes", field_rows(entries), page)
    print_table("Sweeps", sweep_rows(entries), page)
    print_table("Work proportional to what changed", change_rows(entries), page)
    print_table("Everything else", other_rows(entries, baseline), page)
    print_table("Growth with the number of queries", growth_rows(entries), page)
    if options.results:
        page.write(options.results)
    if options.update:
        page.update(options.update)
    for name, entry in failed.items():
        print(f"{name} failed: {entry['error_message']}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
