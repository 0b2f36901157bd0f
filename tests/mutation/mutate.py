"""Breaks single lines of the libraries, one after the other, and says which tests notice.

Each mutant of mutants.toml replaces one piece of text. As many mutants as possible are compiled at once: both texts stand in the programs,
and ESPALIER_MUTANT=NUMBER chooses which one runs. The others are compiled one by one. Then the tests of the library run for
each mutant until the first failure: those of its file first. A mutant that no test kills is a survivor: write the test that it lacks.
Results are kept in the build folder under the mutant and the file's content, so a run that was stopped goes on where it was.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LIST = HERE / "mutants.toml"
SLOWEST_SECONDS = 900  # of one test program; a mutant that never ends is killed, too
SILENT_SECONDS = 180  # of one test
# the first lines of a file with mutants that are chosen when the program runs
PRELUDE = """#ifndef ESPALIER_MUTANT_SWITCH
#define ESPALIER_MUTANT_SWITCH
#include <cstdlib>
inline int espalierMutant() {
  static const int chosen = std::getenv("ESPALIER_MUTANT") == nullptr ? 0 : std::atoi(std::getenv("ESPALIER_MUTANT"));
  return chosen;
}
#endif
"""

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


def is_statement(before: str) -> bool:
    """Whether a statement can begin after this text."""
    lines = [line for line in before.rstrip(" ").split("\n") if not line.strip().startswith("//")]
    return before.rstrip(" ").endswith("\n") and "\n".join(lines).rstrip().endswith((";", "{", "}", ":"))


def chosen_between(old: str, new: str, number: int, can_begin: bool) -> Optional[str]:
    """Conditions, declarations or, where a statement can begin, statements. Nothing for other texts."""
    chosen = f"espalierMutant() == {number}"
    conditions = [re.fullmatch(r"(if|while) \((?:(.*); )?(.*)\) \{", text, re.DOTALL) for text in (old, new)]
    declared = [re.fullmatch(r"((?:const )?[\w:<>]+ \w+) = (.*);", text, re.DOTALL) for text in (old, new)]
    if conditions[0] and conditions[1] and conditions[0].groups()[:2] == conditions[1].groups()[:2]:
        word, first, condition = conditions[0].groups()
        return f"{word} ({first + '; ' if first else ''}{chosen} ? bool({conditions[1][3]}) : bool({condition})) {{"
    if declared[0] and declared[1] and declared[0][1] == declared[1][1] and not old.startswith("return"):
        return f"{declared[0][1]} = {chosen} ? ({declared[1][2]}) : ({declared[0][2]});"
    is_whole = all(text.count("{") == text.count("}") for text in (old, new))
    if old.endswith(";") and (new.endswith(";") or not new) and can_begin and is_whole:
        return f"if ({chosen}) {{ {new} }} else {{ {old} }}"
    return None


def switched(text: str, other: str, number: int, before: str) -> Optional[str]:
    """Source text that does `other` when mutant `number` is chosen, else `text`. Nothing when both cannot stand in one program. `before`:
    the file up to the text."""
    if (whole := chosen_between(text, other, number, is_statement(before))) is not None:
        return whole
    # without the lines that are the same
    lines, others = text.split("\n"), other.split("\n")
    head: List[str] = []
    tail: List[str] = []
    while lines and others and lines[0] == others[0]:
        head, lines, others = [*head, lines[0]], lines[1:], others[1:]
    while lines and others and lines[-1] == others[-1]:
        tail, lines, others = [lines[-1], *tail], lines[:-1], others[:-1]
    made = chosen_between("\n".join(lines).strip(), "\n".join(others).strip(), number, is_statement(before + "\n".join([*head, ""])))
    return None if made is None else "\n".join([*head, made, *tail])


def texts_with(numbered: Dict[int, Mutant]) -> Dict[str, str]:
    """The files with all of these mutants in them, to be chosen when the program runs."""
    texts: Dict[str, str] = {}
    for name in {mutant["file"] for mutant in numbered.values()}:
        original = (ROOT / name).read_text(encoding="utf-8")
        changes = []
        for number, mutant in numbered.items():
            if mutant["file"] == name:
                begin = original.index(mutant["text"])
                made = switched(mutant["text"], mutant["with"], number, original[:begin])
                assert made is not None
                changes.append((begin, begin + len(mutant["text"]), made))
        text = original
        for begin, end, made in sorted(changes, reverse=True):
            text = text[:begin] + made + text[end:]
        texts[name] = PRELUDE + text
    return texts


def is_switchable(mutant: Mutant) -> bool:
    if mutant["file"].endswith(".h"):
        return False  # all that includes it would be compiled
    original = (ROOT / mutant["file"]).read_text(encoding="utf-8")
    return switched(mutant["text"], mutant["with"], 1, original[:original.index(mutant["text"])]) is not None


def put_back(build: Path) -> None:
    """The files that a run has changed, also one that was killed."""
    kept = build / "mutation" / "originals.json"
    if kept.exists():
        for name, text in json.loads(kept.read_text(encoding="utf-8")).items():
            (ROOT / name).write_text(text, encoding="utf-8")
        kept.unlink()


@contextmanager
def changed(build: Path, texts: Dict[str, str]) -> Iterator[None]:
    """Files of the sources that are other than they were, until the end of the block."""
    originals = {name: (ROOT / name).read_text(encoding="utf-8") for name in texts}
    (build / "mutation" / "originals.json").write_text(json.dumps(originals), encoding="utf-8")
    try:
        for name, text in texts.items():
            (ROOT / name).write_text(text, encoding="utf-8")
        yield
    finally:
        put_back(build)


def program_of(mutant: Mutant) -> str:
    return str(mutant.get("program", f"test_{mutant['library']}"))


def suites_of(mutant: Mutant) -> List[str]:
    """The suites of the tests that mirror its file."""
    file = Path(mutant["file"])
    tests = ROOT / "tests" / file.parent / f"{file.stem}_test.cpp"
    return sorted(set(re.findall(r"^TEST(?:_F|_P)?\((\w+),", tests.read_text(encoding="utf-8"), re.MULTILINE))) if tests.exists() else []


def run_tests(build: Path, program: str, tests: str, number: int) -> Tuple[Optional[int], str]:
    """Exit status and output; no status when a test said nothing for long."""
    command = [str(build / "bin" / program), "--gtest_fail_fast", f"--gtest_filter={tests}:-*.Long*:Long*:*/Long*"]
    with tempfile.TemporaryFile("w+b") as output:
        process = subprocess.Popen(command, cwd=ROOT, stdout=output, stderr=subprocess.STDOUT,
                                   env={**os.environ, "ESPALIER_MUTANT": str(number)})
        begun = heard = time.monotonic()
        size = 0
        status: Optional[int] = None
        while status is None:
            try:
                status = process.wait(0.2)
            except subprocess.TimeoutExpired:
                now, written = time.monotonic(), os.fstat(output.fileno()).st_size
                heard, size = (now, written) if written != size else (heard, size)
                if now - heard > SILENT_SECONDS or now - begun > SLOWEST_SECONDS:
                    process.kill()
                    process.wait()
                    break
        output.seek(0)
        return status, output.read().decode(errors="replace")


def verdict(build: Path, mutant: Mutant, number: int) -> str:
    """`killed by TEST`, or `survived`. `number`: of the mutant in the program; 0: it is the only one, and always there."""
    program = program_of(mutant)
    nearest = ":".join(f"{suite}.*:*/{suite}.*" for suite in suites_of(mutant))
    for tests in filter(None, (nearest, mutant.get("filter", "*"))):
        status, output = run_tests(build, program, tests, number)
        begun = re.findall(r"\[ RUN      \] (\S+)", output)
        if status is None:
            return f"killed by {begun[-1]}: it does not end" if begun else "killed: the program does not end"
        if status != 0:
            failed = re.findall(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", output)
            test = failed[0] if failed else begun[-1] if begun else ""
            # a test that fails without the mutant, too, proves nothing
            if number != 0 and test and run_tests(build, program, test, 0)[0] != 0:
                return f"not known: {test} fails without it, too"
            return f"killed by {test}" + ("" if failed else f" (the program ended with {status})")
    return "survived"


def built(build: Path, programs: Sequence[str], jobs: int, prefix: Sequence[str]) -> str:
    """Nothing, or what the compiler said."""
    made = subprocess.run([*prefix, "ninja", "-C", str(build), f"-j{jobs}", "-k0", *programs], capture_output=True, text=True, check=False)
    return "" if made.returncode == 0 else made.stdout + made.stderr


class Pass:
    def __init__(self, options: argparse.Namespace) -> None:
        self.build, self.jobs, self.prefix = Path(options.build), options.jobs, options.build_with.split()
        self._memory = self.build / "mutation" / "results.json"
        self.results: Dict[str, str] = json.loads(self._memory.read_text(encoding="utf-8")) if self._memory.exists() else {}

    def is_open(self, mutant: Mutant) -> bool:
        # a survivor is tried again: there may be a test for it now
        return not self.results.get(key_of(mutant), "survived").startswith("killed")

    def note(self, key: str, mutant: Mutant, result: str) -> None:
        self.results[key] = result
        self._memory.write_text(json.dumps(self.results, indent=1), encoding="utf-8")
        print(f"{time.strftime('%H:%M:%S')} {mutant['file']}: {result}: {one_line(mutant['with'])}", file=sys.stderr, flush=True)

    def try_all(self, chosen: Sequence[Mutant]) -> None:
        waiting = list(filter(self.is_open, chosen))
        together = list(filter(is_switchable, waiting))
        while together:
            numbered = dict(enumerate(together, 1))
            keys = {number: key_of(mutant) for number, mutant in numbered.items()}
            with changed(self.build, texts_with(numbered)):
                said = built(self.build, sorted(set(map(program_of, together))), self.jobs, self.prefix)
                if not said:
                    for number, mutant in numbered.items():
                        self.note(keys[number], mutant, verdict(self.build, mutant, number))
                    break
            # those of the files that the compiler names are compiled one by one
            named = [mutant for mutant in together if re.search(re.escape(mutant["file"]) + r":\d+:\d+: error", said)]
            if not named:
                raise SystemExit(said)
            together = [mutant for mutant in together if mutant not in named]
        for mutant in waiting:
            if mutant not in together:
                self.try_alone(mutant)

    def try_alone(self, mutant: Mutant) -> None:
        key, file = key_of(mutant), mutant["file"]
        text = (ROOT / file).read_text(encoding="utf-8").replace(mutant["text"], mutant["with"])
        with changed(self.build, {file: text}):
            said = built(self.build, [program_of(mutant)], self.jobs, self.prefix)
            self.note(key, mutant, "does not compile" if said else verdict(self.build, mutant, 0))


def one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=str(ROOT / "build" / "release"), help="folder of a configured build")
    parser.add_argument("--jobs", type=int, default=2, help="compilers at a time")
    parser.add_argument("--build-with", default="", metavar="COMMAND", help="before ninja, for example nice")
    parser.add_argument("libraries", nargs="*", help="only mutants of these libraries")
    options = parser.parse_args()
    build = Path(options.build)
    (build / "mutation").mkdir(exist_ok=True)
    put_back(build)
    known = mutants()
    libraries = list(dict.fromkeys(mutant["library"] for mutant in known))
    chosen = [mutant for mutant in known if mutant["library"] in (options.libraries or libraries)]
    problems = [problem for problem in map(problem_of, chosen) if problem]
    if problems or not chosen:
        print("\n".join(problems) or "no mutant is of such a library")
        return 2
    done = Pass(options)
    done.try_all(chosen)
    print("| library | file | text | becomes | result |\n|---|---|---|---|---|")
    for mutant in chosen:
        print(f"| {mutant['library']} | {mutant['file']} | `{one_line(mutant['text'])}` | `{one_line(mutant['with'])}` | "
              f"{done.results[key_of(mutant)]} |")
    bad = [mutant for mutant in chosen if not done.results[key_of(mutant)].startswith("killed")]
    print(f"\n{len(chosen) - len(bad)} of {len(chosen)} killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
