// espalier conformance: the suite by this program and by others, also by such as hang or print nonsense.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "clients/espalier/conformance/program_run.h"
#include "clients/espalier/conformance/string_comparison.h"
#include "tests/clients/program_run.h"
#include "tests/support/places.h"

namespace espalier::test::conformance_test {
namespace {

class ConformanceCommand : public testing::Test {
 protected:
  /// A suite of one case: two steps of A --> AB.
  void SetUp() override {
    folder_.write("cases.tsv",
                  "case\tkind\tsteps\ttolerance\tquirk\tturtle\tfeature\tchecks\n"
                  "001-one\tdeterministic\t2\t1e-5\tno\tno\trewriting\tA grows.\n");
    std::filesystem::create_directory(folder_.path() + "/001-one");
    folder_.write("001-one/model.l", "Lsystem: 1\nderivation length: 2\nAxiom: A(1)\nA(x) --> A(x)B\nendlsystem\n");
    folder_.write("001-one/expected.txt", "0\tA(1)\n1\tA(1)B\n2\tA(1)BB\n");
  }

  ProgramRun run(const std::string& arguments) const {
    return runProgram("conformance --cases . " + arguments, folder_.path());
  }
  ProgramRun runOther(const std::string& command, const std::string& more = "") const {
    return run("--program '" + command + "' " + more);
  }

  TemporaryFolder folder_;
};

TEST_F(ConformanceCommand, RunsTheSuiteByThisProgram) {
  const ProgramRun result = run("");
  EXPECT_EQ(result.output, "passed 001-one\n1 passed, 0 failed\n");
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.status, 0);
}

TEST_F(ConformanceCommand, FindsTheSuiteThatCameWithTheProgram) {
  const ProgramRun listed = runProgram("conformance --list --kind random", folder_.path());
  EXPECT_TRUE(contains(listed.output, "129-ran-unseeded\trandom\tran() before any srand")) << listed.output;
  EXPECT_FALSE(contains(listed.output, "deterministic"));
  // a case with answers and one with a log
  const ProgramRun result = runProgram("conformance 138-query-timing printf", folder_.path());
  EXPECT_TRUE(contains(result.output, "passed 138-query-timing\n")) << result.output;
  EXPECT_TRUE(contains(result.output, ", 0 failed\n")) << result.output;
}

TEST_F(ConformanceCommand, ComparesAnotherProgram) {
  folder_.write("other.sh", "test -f \"$1\" && printf '0\\tA(1)\\n1\\tA(1.000003)B\\n2\\tA(1)BB\\n'");
  const ProgramRun result = runOther("sh " + folder_.path() + "/other.sh");
  EXPECT_EQ(
      result.output,
      "passed 001-one\n"
      "largest accepted deviation: 0.273 of the tolerance in 001-one, derived string of step 1, module 0: expected "
      "A(1), actual A(1.000003)\n"
      "1 passed, 0 failed\n");
}

TEST_F(ConformanceCommand, NamesTheFirstDifference) {
  const ProgramRun result = runOther("printf \"0\\\\tA(1)\\\\n1\\\\tA(2)B\\\\n2\\\\tA(1)BB\\\\n\" #");
  EXPECT_EQ(result.output,
            "failed 001-one: derived string of step 1: module 0: parameter 1 differs: expected A(1), actual A(2)\n"
            "  expected: A(1)B\n  actual:   A(2)B\n0 passed, 1 failed\n");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(runOther("printf \"0\\\\tA(1)\\\\n\" #").output, "derived string of step 1: missing"));
}

TEST_F(ConformanceCommand, EndsAProgramThatHangs) {
  const ProgramRun result = runOther("sleep 1000 #", "--timeout 0.2");
  EXPECT_EQ(result.output,
            "failed 001-one: the program does not end within 0.2 s; expected 3 lines, one for each step from 0 on: its "
            "number, a TAB, and the string\n0 passed, 1 failed\n");
  // also one that closes its output and goes on, and one with children
  EXPECT_TRUE(contains(runOther("exec >&- 2>&-; sleep 1000 #", "--timeout 0.2").output, "does not end within 0.2 s"));
  EXPECT_TRUE(contains(runOther("sleep 1000 & wait #", "--timeout 0.2").output, "does not end within 0.2 s"));
}

TEST_F(ConformanceCommand, NamesNonsense) {
  EXPECT_TRUE(contains(runOther("echo hello #").output,
                       "line 1 of its output is 'hello': expected '0', a TAB, and the string of step 0"));
  EXPECT_TRUE(contains(runOther("true").output, "the program prints nothing; expected 3 lines"));
  EXPECT_TRUE(contains(runOther("./not-there").output, "the program ends with status 127, expected 0: "));
  EXPECT_TRUE(
      contains(runOther("echo broken >&2; exit 3 #").output, "the program ends with status 3, expected 0: broken\n"));
  EXPECT_TRUE(
      contains(runOther("printf \"0\\\\tA(x)\\\\n\" #").output, "actual string: 'x' in module 0 is not a number"));
  EXPECT_TRUE(contains(runOther("kill -SEGV $$ #").output, "the program ends with status 139"));
  EXPECT_TRUE(contains(runOther("yes #").output, "the program prints more than 64 MB"));
  // control characters do not reach the terminal
  EXPECT_TRUE(contains(runOther("printf \"\\033[2Jhi\" #").output, "line 1 of its output is '?[2Jhi': expected '0'"));
}

TEST_F(ConformanceCommand, AnEmptyCommandTestsNothing) {
  for (const std::string option : {"--program ''", "--program ' '", "--program true --answered ''"}) {
    const ProgramRun result = run(option);
    EXPECT_EQ(result.status, 2) << option;
    EXPECT_TRUE(contains(result.errors, "the command is empty: give the program to test")) << result.errors;
  }
}

TEST_F(ConformanceCommand, FilesOfTheCommandAreThoseOfTheUsersFolder) {
  folder_.write("good.sh", "printf '0\\tA(1)\\n1\\tA(1)B\\n2\\tA(1)BB\\n'");
  EXPECT_EQ(runOther("sh ./good.sh").output, "passed 001-one\n1 passed, 0 failed\n");
  EXPECT_EQ(runOther(" sh  ./good.sh {model}").status, 0);
  // a name that the user's folder does not have is one of the case
  EXPECT_EQ(runOther("cat ./expected.txt #").status, 0);
}

TEST_F(ConformanceCommand, SaysWhatIsWrongWithTheSuite) {
  EXPECT_EQ(run("nothing").errors,
            "error: no case has 'nothing' in its name: espalier conformance --list prints all cases\n");
  EXPECT_EQ(runProgram("conformance --cases no-folder", folder_.path()).status, 1);
  const ProgramRun none = run("one --kind random");
  EXPECT_EQ(none.status, 1);
  EXPECT_TRUE(contains(none.errors, "no case of this kind has one of these names")) << none.output;
  folder_.write("cases.tsv", "001-one\tdeterministic\n");
  EXPECT_TRUE(contains(run("").errors, "cases.tsv: expected lines of case, kind, steps, tolerance, quirk and turtle"));
}

TEST_F(ConformanceCommand, ComparesAnswersAndLogWhenAsked) {
  folder_.write("cases.tsv", "001-one\tdeterministic\t2\t1e-5\tno\tyes\tf\tc\n");
  folder_.write("001-one/expected-turtle.txt", "0\tA(2)\n1\tA(2)B\n");
  folder_.write("001-one/expected-log.txt", "hello\n");
  folder_.write("derived.sh", "cat expected.txt; echo \"$LOG\" >&2");
  const std::string derived = "sh ../derived.sh";
  EXPECT_TRUE(contains(runOther(derived).errors, "of 1 cases the strings with answers are not compared"));
  EXPECT_EQ(runOther(derived, "--answered 'cat expected-turtle.txt #'").status, 0);
  EXPECT_EQ(runOther(derived, "--answered 'cat expected.txt #'").status, 1);
  EXPECT_EQ(runOther("LOG=hello " + derived, "--log").status, 0);
  EXPECT_TRUE(contains(runOther("LOG=goodbye " + derived, "--log").output, "log: expected\nhello\nactual\ngoodbye\n"));
}

TEST_F(ConformanceCommand, LinesOfAnotherProgramMayEndWithACarriageReturn) {
  folder_.write("other.sh", "printf '0\\tA(1)\\r\\n1\\tA(1)B\\r\\n2\\tA(1)BB\\r\\n'");
  EXPECT_EQ(runOther("sh ./other.sh").output, "passed 001-one\n1 passed, 0 failed\n");
}

TEST(StringComparison, ARelativeToleranceIsAShareOfTheLargerNumber) {
  const auto differ = [](const char* expected, const char* actual) {
    conformance::Deviation largest;
    return conformance::firstDifference(expected, actual, {.relative = 0.5, .absolute = 0.0}, largest).has_value();
  };
  EXPECT_FALSE(differ("A(1)", "A(1.9)"));
  EXPECT_FALSE(differ("A(1.9)", "A(1)"));
  EXPECT_FALSE(differ("A(-1)", "A(-1.9)"));
  EXPECT_TRUE(differ("A(1)", "A(2.1)"));
  EXPECT_TRUE(differ("A(2.1)", "A(1)"));
}

TEST(ConformanceProgram, WordsOfTheShellAreQuoted) {
  EXPECT_EQ(conformance::quoted("a b'c"), "'a b'\\''c'");
}

}  // namespace
}  // namespace espalier::test::conformance_test
