"""Counts the instructions of fixed work and compares them with recorded counts.

Runs the program espalier_instructions under callgrind (valgrind), which counts only inside its functions `measured…`, and
whole commands from start to end, with environment, interpretation and writing. Only instructions of our own program files are added up, not those
of the C library, whose functions are chosen by the processor. Time does not matter here, so a busy machine changes nothing.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

MORE_ALLOWED = 0.05  # a count may be this much above the recorded one
LESS_REPORTED = 0.10  # one this much below asks for the record to be renewed; it does not fail
MEASURED = "espalier::benchmarking::measured(espalier::simulation::Simulation&, espalier::benchmarking::Measured)"
# whole commands, by one thread; {models}: of the benchmarks, {gallery}: the gallery
COMMANDS = {
    "start-up/derive": ("derive", "{models}/d0l.l", "--define", "N=3"),
    "whole/trees-by-account": ("derive", "{gallery}/trees-by-account", "--steps", "100"),
    "whole/self-organizing-tree": ("run", "{gallery}/self-organizing-tree", "--steps", "8", "-o", "plant.csv"),
    "whole/roots-in-soil": ("run", "{gallery}/roots-in-soil", "--steps", "3", "-o", "plant.csv"),
    "whole/crowded-bush.obj": ("run", "{gallery}/crowded-bush", "-o", "plant.obj"),
    "whole/accounts.glb": ("run", "{models}/accounts.l", "--define", "N=9", "--define", "K=9", "-o", "plant.glb"),
    "whole/twigs.glb": ("run", "{models}/twigs.l", "--define", "N=9", "-o", "plant.glb"),
    "whole/twigs.png": ("run", "{models}/twigs.l", "--define", "N=7", "-o", "plant.png"),
}
RENEW = "./dev bench --record-instructions"


def own_instructions(profile: str, program: str) -> int:
    """The sum of the self costs of the functions of one object file in a profile in callgrind's format."""
    names: dict[str, str] = {}
    is_own = False
    is_call = False
    total = 0
    with open(profile, encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("ob="):
                number, name = re.fullmatch(r"ob=\((\d+)\)(?: (.*))?\n", line).groups()
                if name is not None:
                    names[number] = name
                is_own = os.path.realpath(names[number]) == program
            elif line.startswith("cob="):
                number, name = re.fullmatch(r"cob=\((\d+)\)(?: (.*))?\n", line).groups()
                if name is not None:
                    names[number] = name
            elif line.startswith("calls="):
                # the next line is what the callee cost
                is_call = True
            elif line[0] in "+-*0123456789":
                if is_own and not is_call:
                    total += int(line.split()[1])
                is_call = False
    return total


def callgrind(folder: str, command: list[str], *options: str) -> str:
    """Runs a command under callgrind in a folder and returns what it printed."""
    run = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=profile", *options, *command], cwd=folder,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode != 0:
        sys.exit(f"callgrind could not run {command[0]}:\n{run.stderr}")
    return run.stdout


def count_all(program: str, espalier: str, models: str, gallery: str) -> tuple[str, dict[str, int]]:
    """The compiler, and the counts by workload."""
    counts: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        printed = callgrind(folder, [program], f"--toggle-collect={MEASURED}", f"--dump-after={MEASURED}")
        compiler, *workloads = printed.splitlines()
        for number, workload in enumerate(workloads, start=1):
            counts[workload] = own_instructions(os.path.join(folder, f"profile.{number}"), program)
    for name, arguments in COMMANDS.items():
        command = [argument.format(models=models, gallery=gallery) for argument in arguments]
        with tempfile.TemporaryDirectory() as folder:
            callgrind(folder, [espalier, *command, "--threads", "1", "--quiet"])
            counts[name] = own_instructions(os.path.join(folder, "profile"), espalier)
    return compiler, counts


def vector_path() -> str:
    """Which of the engine's vector paths this machine runs under valgrind, which knows no wider ones than AVX2."""
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        flags = next((line.split() for line in lines if line.startswith("flags")), [])
    return "avx2" if "avx2" in flags else "portable"


def compare(counts: dict[str, int], recorded: dict[str, int]) -> tuple[int, int]:
    """Prints what differs by more than is allowed; returns how many workloads passed and failed."""
    failed = 0
    can_be_renewed = []
    for workload, count in counts.items():
        before = recorded.get(workload)
        if before is None:
            print(f"{workload}: {count:,} instructions, but no count is recorded. Record it: {RENEW}")
            failed += 1
        elif count > before * (1 + MORE_ALLOWED):
            print(f"{workload}: {count:,} instructions, {count / before - 1:+.1%} of the {before:,} recorded; allowed is "
                  f"{MORE_ALLOWED:+.0%}. If the change is worth it, renew the record: {RENEW}")
            failed += 1
        elif count < before * (1 - LESS_REPORTED):
            can_be_renewed.append(f"{workload} {count / before - 1:+.1%}")
    for workload in recorded.keys() - counts.keys():
        print(f"{workload}: a count is recorded, but there is no such work any more. Renew the record: {RENEW}")
        failed += 1
    if can_be_renewed:
        print(f"fewer instructions than recorded: {', '.join(can_be_renewed)}. Keep the gain: {RENEW}")
    return len(counts) + len(recorded.keys() - counts.keys()) - failed, failed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="espalier_instructions")
    parser.add_argument("--espalier", required=True, help="the command line")
    parser.add_argument("--models", required=True, help="folder of the benchmarks' models")
    parser.add_argument("--gallery", required=True, help="folder of the gallery")
    parser.add_argument("--recorded", required=True, help="JSON file with the recorded counts")
    parser.add_argument("--record", action="store_true", help="write the counts instead of comparing")
    parser.add_argument("--figures", help="file that receives how many workloads passed and failed")
    options = parser.parse_args()

    compiler, counts = count_all(*map(os.path.realpath, (options.program, options.espalier, options.models, options.gallery)))
    key = f"{compiler}, {vector_path()}"
    recorded: dict[str, dict[str, int]] = {}
    if os.path.exists(options.recorded):
        with open(options.recorded, encoding="utf-8") as file:
            recorded = json.load(file)

    if options.record:
        before = recorded.get(key, {})
        for workload, count in counts.items():
            change = f"  {count / before[workload] - 1:+.1%}" if workload in before else ""
            print(f"{workload:36}{count:>14,}{change}")
        recorded[key] = counts
        with open(options.recorded, "w", encoding="utf-8") as file:
            json.dump(recorded, file, indent=2)
            file.write("\n")
        return 0

    if key not in recorded:
        # another compiler makes other instructions
        print(f"no instruction counts are recorded for {key}; nothing to compare with. To record them: {RENEW} BUILD")
        passed, failed = 0, 0
    else:
        passed, failed = compare(counts, recorded[key])
    if options.figures:
        with open(options.figures, "w", encoding="utf-8") as file:
            file.write(f"{passed} {failed}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
