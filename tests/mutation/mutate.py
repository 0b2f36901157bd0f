"""Breaks single lines of the libraries, one after the other, and says which tests notice.

Each mutant of mutants.toml replaces one piece of text. The script builds the library's test program, runs it until the first
failure, and puts the file back. A mutant that no test kills is a survivor: write the test that it lacks. Results are kept in
the build folder under the mutant and the file's content, so a run that was stopped goes on where it was.
"""

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, Dict, List, Optional

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LIST = HERE / "mutants.toml"
SLOWEST_SECONDS = 900  # of one test program; a mutant that never ends is killed, too

Mutant = Dict[str, Any]


def mutants() -> List[Mutant]:
    return list(tomllib.loads(LIST.read_text(encoding="utf-8"))["mutant"])


def problem_of(mutant: Mutant) -> Optional[str]:
    """Why a mutant cannot be made, or nothing."""
    file = ROOT / mutant["file"]
    if not file.exists():
        return f"{mutant['file']} is not there"
    found = file.read_text(encoding="utf-8").count(mutant["text"])
    return None if found == 1 else f"{mutant['file']} has {found} times: {mutant['text']}"


def key_of(mutant: Mutant) -> str:
    parts = [json.dumps(mutant, sort_keys=True).encode(), (ROOT / mutant["file"]).read_bytes()]
    return hashlib.sha256(b"\n".join(parts)).hexdigest()[:16]


def put_back(build: Path) -> None:
    """After a run that was killed: the file that it had changed."""
    kept = build / "mutation" / "original.json"
    if kept.exists():
        original = json.loads(kept.read_text(encoding="utf-8"))
        (ROOT / original["file"]).write_text(original["text"], encoding="utf-8")
        kept.unlink()


def verdict(build: Path, mutant: Mutant, jobs: int) -> str:
    """`killed by TEST`, `survived`, or `does not compile`."""
    program = mutant.get("program", f"test_{mutant['library']}")
    made = subprocess.run(["ninja", "-C", str(build), f"-j{jobs}", program], capture_output=True, text=True, check=False)
    if made.returncode != 0:
        return "does not compile"
    command = [str(build / "bin" / program), "--gtest_fail_fast", "--gtest_brief=1",
               "--gtest_filter=" + mutant.get("filter", "*") + ":-*.Long*"]
    try:
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=SLOWEST_SECONDS,
                             errors="replace")
    except subprocess.TimeoutExpired:
        return "killed by the time limit"
    if run.returncode == 0:
        return "survived"
    failed = re.search(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", run.stdout)
    return f"killed by {failed.group(1)}" if failed else f"killed: the program ended with {run.returncode}"


def try_out(build: Path, mutant: Mutant, jobs: int) -> str:
    file = ROOT / mutant["file"]
    original = file.read_text(encoding="utf-8")
    kept = build / "mutation" / "original.json"
    kept.write_text(json.dumps({"file": mutant["file"], "text": original}), encoding="utf-8")
    try:
        file.write_text(original.replace(mutant["text"], mutant["with"]), encoding="utf-8")
        return verdict(build, mutant, jobs)
    finally:
        put_back(build)


def one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=str(ROOT / "build" / "release"), help="folder of a configured build")
    parser.add_argument("--jobs", type=int, default=2, help="compilers at a time")
    parser.add_argument("libraries", nargs="*", help="only mutants of these libraries")
    options = parser.parse_args()
    build = Path(options.build)
    (build / "mutation").mkdir(exist_ok=True)
    put_back(build)
    chosen = [mutant for mutant in mutants() if not options.libraries or mutant["library"] in options.libraries]
    problems = [problem for problem in map(problem_of, chosen) if problem]
    if problems or not chosen:
        print("\n".join(problems) or "no mutant is of such a library")
        return 2
    memory = build / "mutation" / "results.json"
    results: Dict[str, str] = json.loads(memory.read_text(encoding="utf-8")) if memory.exists() else {}
    for number, mutant in enumerate(chosen, 1):
        key = key_of(mutant)
        # a survivor is tried again: there may be a test for it now
        if results.get(key, "survived") == "survived":
            results[key] = try_out(build, mutant, options.jobs)
            memory.write_text(json.dumps(results, indent=1), encoding="utf-8")
        print(f"{number}/{len(chosen)} {mutant['file']}: {results[key]}", file=sys.stderr, flush=True)
    print("| library | file | text | becomes | result |\n|---|---|---|---|---|")
    for mutant in chosen:
        print(f"| {mutant['library']} | {mutant['file']} | `{one_line(mutant['text'])}` | `{one_line(mutant['with'])}` | "
              f"{results[key_of(mutant)]} |")
    bad = [mutant for mutant in chosen if not results[key_of(mutant)].startswith("killed")]
    print(f"\n{len(chosen) - len(bad)} of {len(chosen)} killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
