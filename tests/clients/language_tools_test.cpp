// explain, format and disassemble from the shell.

#include <gtest/gtest.h>

#include "tests/clients/program_run.h"

namespace espalier::test::language_tools_test {
namespace {

constexpr const char* kTree =
    "Lsystem: 1\nderivation length: 3\nAxiom: A(1)\nA(l):l<3-->F(l)A(l*2)\nA(l)-->B\nendlsystem\n";

class LanguageTools : public testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) const { return runProgram(arguments, folder_.path()); }

  TemporaryFolder folder_;
};

TEST_F(LanguageTools, ExplainSaysWhichProductionFired) {
  folder_.write("tree.l", kTree);
  const ProgramRun result = run("explain tree.l --step 3 --module 2");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.output,
            "Step 3 reads the string of step 2, 3 modules, with the replies of the environment.\n"
            "Module 2: A(4)\n"
            "Around it: F(1)F(2) >>A(4)<< \n"
            "\n"
            "What happened: tree.l:5:1 fired.\n"
            "  A(l)-->B\n"
            "It made: B\n"
            "\n"
            "Productions that begin with 'A', in the order of the file:\n"
            "  tree.l:4:1: A(l):l<3-->F(l)A(l*2)\n"
            "    failed: the condition 'l<3' is 0 with l = 4\n"
            "  tree.l:5:1: A(l)-->B\n"
            "    applied with l = 4\n");
}

TEST_F(LanguageTools, ExplainSeesTheAnswersOfTheEnvironment) {
  folder_.write("up.l", kHeight);
  // before step 3 the query stands at height 2
  const ProgramRun result = run("explain up.l --step 3 --module 2 --environment height");
  EXPECT_TRUE(contains(result.output, "right context: wants E(h), saw E(2) (module 4)"))
      << result.output << result.errors;
  EXPECT_TRUE(contains(result.output, "It made: nothing\n")) << result.output;
}

TEST_F(LanguageTools, ExplainNamesWrongModulesAndSteps) {
  folder_.write("tree.l", kTree);
  const ProgramRun module = run("explain tree.l --step 1 --module 4");
  EXPECT_EQ(module.status, 1);
  EXPECT_EQ(module.output, "");
  EXPECT_EQ(module.errors, "error: there is no module 4 in the string of step 0: it has 1 module, numbered 0 to 0\n");
  const ProgramRun step = run("explain tree.l --step 4 --module 0");
  EXPECT_EQ(step.status, 1);
  EXPECT_EQ(step.errors, "error: step 4 does not exist: the model ends with step 3 (--steps N derives more)\n");
  EXPECT_EQ(run("explain tree.l --step 0 --module 0").status, 2);
  EXPECT_EQ(run("explain tree.l --module 0").status, 2);
}

TEST_F(LanguageTools, ExplainDrawsForThePlantThatWasAskedFor) {
  folder_.write("bush.l", "Lsystem: 1\nseed: 5\nAxiom: A\nA --> A : 1\nA --> B : 1\nendlsystem\n");
  const ProgramRun first = run("explain bush.l --step 1 --module 0");
  const ProgramRun second = run("explain bush.l --step 1 --module 0 --plant 1");
  EXPECT_TRUE(contains(first.output, "choice: the draw ")) << first.output << first.errors;
  EXPECT_NE(first.output, second.output);
  EXPECT_EQ(first.output, run("explain bush.l --step 1 --module 0 --plant 0").output);
}

TEST_F(LanguageTools, FormatWritesToStandardOutputOrInPlace) {
  folder_.write("tree.l", kTree);
  const std::string formatted =
      "Lsystem: 1\nderivation length: 3\nAxiom: A(1)\nA(l) : l < 3 --> F(l)A(l*2)\nA(l) --> B\nendlsystem\n";
  EXPECT_EQ(run("format tree.l").output, formatted);
  EXPECT_EQ(folder_.read("tree.l"), kTree);
  const ProgramRun check = run("format tree.l --check");
  EXPECT_EQ(check.status, 1);
  EXPECT_EQ(check.output, "tree.l: would be changed\n");
  EXPECT_EQ(folder_.read("tree.l"), kTree);
  EXPECT_EQ(run("format tree.l --in-place").status, 0);
  EXPECT_EQ(folder_.read("tree.l"), formatted);
  const ProgramRun again = run("format tree.l --check");
  EXPECT_EQ(again.status, 0);
  EXPECT_EQ(again.output, "tree.l: is formatted\n");
  EXPECT_EQ(run("format tree.l --check --in-place").status, 2);
}

TEST_F(LanguageTools, FormatLeavesAModelWithErrorsAlone) {
  folder_.write("bad.l", "Lsystem:1\nAxiom:F\nF->F\nendlsystem\n");
  const ProgramRun result = run("format bad.l --in-place");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "bad.l:3:2: error: ")) << result.errors;
  EXPECT_TRUE(contains(result.errors, "'bad.l' was not formatted: correct the errors first")) << result.errors;
  EXPECT_EQ(folder_.read("bad.l"), "Lsystem:1\nAxiom:F\nF->F\nendlsystem\n");
}

TEST_F(LanguageTools, DisassembleShowsEachProductionWithItsLine) {
  folder_.write("tree.l", "#define R 2\nLsystem: 1\nAxiom: A(1)\nA(l) --> F(l)A(l*R)\nendlsystem\n");
  const ProgramRun result = run("disassemble tree.l");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.output,
            "L-system 1\naxiom\n  module A\n    parameter 0 = 1\n"
            "production 0: A(l) --> F(l)A(l*2)\n"
            "  # tree.l:4:1: A(l) --> F(l)A(l*R)\n"
            "  module F\n    parameter 0 = slot 0\n  module A\n    parameter 0\n"
            "     0  LoadSlot 0\n     1  Constant 2\n     2  Multiply\n");
}

TEST_F(LanguageTools, DisassembleSaysWhichWayAProductionTakesAndWhy) {
  folder_.write("tree.l",
                "Lsystem: 1\nStart: {n=0;}\nAxiom: A(1)B(1)CD\nA(l) : {u=l*n;} u<3 --> A(u)\nB(l) < C > D --> DC\n"
                "B(l) : {n=n+1;} 1 --> B(l)\nD --> DD\nendlsystem\n");
  const ProgramRun result = run("disassemble tree.l --plan");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(contains(result.output, "production 0: A(l) : {u=l*n;} u<3 --> A(u)\n  in batches\n")) << result.output;
  EXPECT_TRUE(
      contains(result.output, "production 1: B(l) < C > D --> DC\n  in batches; the nearest neighbours are found"))
      << result.output;
  EXPECT_TRUE(
      contains(result.output, "  one module at a time, by a table: a block assigns a variable of the L-system\n"))
      << result.output;
  EXPECT_TRUE(contains(result.output, "production 3: D --> DD\n  a fixed block of modules is copied\n"))
      << result.output;
}

TEST_F(LanguageTools, HelpTeachesByExample) {
  EXPECT_TRUE(contains(run("explain --help").output, "espalier explain tree.l --step 3 --module 12"));
  EXPECT_TRUE(contains(run("format --help").output, "espalier format tree.l --in-place"));
  EXPECT_TRUE(contains(run("disassemble --help").output, "espalier disassemble tree.l"));
}

TEST_F(LanguageTools, InferPrintsAModelThatMakesTheSteps) {
  folder_.write("tree.l", "Lsystem: 1\nderivation length: 4\nAxiom: X\nX-->F[+X]F[-X]/(90)X\nF-->FF\nendlsystem\n");
  const ProgramRun steps = run("derive tree.l --every");
  folder_.write("steps.txt", steps.output);
  const ProgramRun result = run("infer steps.txt");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.output,
            "/* the only bracketed D0L-system that makes these 5 strings */\nLsystem: 1\nderivation length: 4\n"
            "Axiom: X\nX --> F[+X]F[-X]/(90)X\nF --> FF\nendlsystem\n");
  EXPECT_EQ(result.errors, "the only bracketed D0L-system that makes these 5 strings\n");
  folder_.write("again.l", result.output);
  EXPECT_EQ(run("derive again.l --every").output, steps.output);
}

TEST_F(LanguageTools, InferSaysHowSeveralDifferAndWhenNoneExists) {
  folder_.write("two.txt", "ab\nabc\n");
  const ProgramRun two = run("infer two.txt --no-erasing");
  EXPECT_EQ(two.status, 0);
  EXPECT_TRUE(contains(two.errors,
                       "one of 2 D0L-systems that make these 2 strings. They differ in\n"
                       "  a: a, or ab\n  b: bc, or c\n"))
      << two.errors;
  folder_.write("none.txt", "a\nab\naba\nabb\n");
  const ProgramRun none = run("infer none.txt");
  EXPECT_EQ(none.status, 1);
  EXPECT_EQ(none.output, "");
  EXPECT_TRUE(contains(none.errors, "the string of step 3 does not follow from those before it")) << none.errors;
  folder_.write("broken.txt", "F\nF(2\n");
  const ProgramRun broken = run("infer broken.txt");
  EXPECT_EQ(broken.status, 1);
  EXPECT_TRUE(contains(broken.errors, "broken.txt:2:2: error: a '(' without its module")) << broken.errors;
}

TEST_F(LanguageTools, InferPrintsProductionsWhereTheLanguageHasNotTheSymbols) {
  folder_.write("greek.txt", "ω\nωτ\nωττ\n");
  EXPECT_EQ(run("infer greek.txt").output, "ω → ωτ\n");
}

}  // namespace
}  // namespace espalier::test::language_tools_test
