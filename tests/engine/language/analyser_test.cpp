#include "engine/language/analyser.h"

#include <gtest/gtest.h>

#include "engine/language/format/disassembler.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language::analyser_test {
namespace {

using core::Compatibility;

std::string header(const std::string& items, const std::string& rest) {
  return "Lsystem: 1\n" + items + "\nAxiom: A(1)\n" + rest + "\nendlsystem\n";
}

std::shared_ptr<const Program> programOf(const std::string& text, Compatibility mode = Compatibility::Espalier) {
  const CompileResult result = compileText(text, mode);
  EXPECT_TRUE(result.program != nullptr) << (result.diagnostics.entries().empty()
                                                 ? ""
                                                 : brief(result.diagnostics.entries()[0]));
  return result.program;
}

std::string codeOf(const std::string& text, Compatibility mode = Compatibility::Espalier) {
  return disassemble(*programOf(text, mode));
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

// ---- scoping

TEST(Analyser, NamesAssignedInItemBlocksAreSharedByAllProductions) {
  const std::string code =
      codeOf(header("Start: {n = 1;}\nEndEach: {m = 2;}", "A(x) : {n = n + 1; m = 0;} * --> A(n)"));
  EXPECT_TRUE(contains(code, "StoreVariable 0 n"));
  EXPECT_TRUE(contains(code, "StoreVariable 1 m"));
}

TEST(Analyser, NamesAssignedInAProductionAreItsOwnStatics) {
  const auto program = programOf(header("", "A(x) : {n = n + 1;} * --> A(n)\nB : {n = n + 1;} * --> A(n)"));
  EXPECT_EQ(program->staticNames, (std::vector<std::string>{"n", "n"}));
  EXPECT_EQ(program->staticCount, 2U);
  EXPECT_TRUE(program->systems[0].variables.empty());
}

TEST(Analyser, FormalParametersShadowVariables) {
  const std::string code = codeOf(header("Start: {n = 1;}", "A(n) : {n = n + 1;} * --> A(n)"));
  EXPECT_TRUE(contains(code, "StoreSlot 0"));
  EXPECT_TRUE(contains(code, "parameter 0 = slot 0"));
}

TEST(Analyser, TheFirstOfEqualFormalNamesWins) {
  const std::string code = codeOf(header("", "L(x) < A(x) > R(x) --> A(x)"));
  EXPECT_TRUE(contains(code, "parameter 0 = slot 0"));
  EXPECT_EQ(programOf(header("", "L(x) < A(x) > R(x) --> A(x)"))->systems[0].productions.productions[0].slotCount, 3);
}

TEST(Analyser, LeadingUnderscoresDoNotMatter) {
  EXPECT_TRUE(contains(codeOf(header("", "A(_y) --> A(y)")), "parameter 0 = slot 0"));
}

TEST(Analyser, TheReferenceDefinesStepAndLengthOnlyWithADerivationLength) {
  const std::string text = header("derivation length: 3", "A(x) --> A(Q+Z)");
  EXPECT_TRUE(contains(codeOf(text, Compatibility::Cpfg), "LoadStep"));
  EXPECT_TRUE(contains(codeOf(text, Compatibility::Cpfg), "LoadLength"));
  const std::string without = header("", "A(x) --> A(Q)");
  EXPECT_TRUE(contains(codeOf(without), "LoadStep"));
  EXPECT_EQ(
      messagesOf(without, Compatibility::Cpfg),
      Messages{"4:12: warning: unknown name 'Q' in the successor of A(x): its value is 0 | names visible here: x"});
}

TEST(Analyser, AssigningStepOrLengthHidesThem) {
  EXPECT_EQ(
      messagesOf(header("Start: {Q = 1;}", "A(x) : {Z = 2;} * --> A(Z)")),
      (Messages{
          "2:9: warning: 'Q' is assigned and is now an ordinary variable | without the assignment it is the number of "
          "the current step",
          "4:9: warning: 'Z' is assigned and is now a variable of this production | elsewhere it is the derivation "
          "length"}));
}

TEST(Analyser, PiIsAConstantInEspaliersOwnModeOnly) {
  EXPECT_EQ(messagesOf(header("", "A(x) --> A(pi)")), Messages{});
  EXPECT_EQ(
      messagesOf(header("", "A(x) --> A(pi)"), Compatibility::Cpfg),
      Messages{"4:12: warning: unknown name 'pi' in the successor of A(x): its value is 0 | names visible here: x"});
  EXPECT_EQ(messagesOf(header("", "A(pi) --> A(pi)")), Messages{});
}

// ---- names and calls

TEST(Analyser, UnknownNamesAreZeroWithAWarning) {
  const std::string text =
      header("Start: {width = 1;}", "A(length) --> A(lenght)BC\nB --> A(widht*widht)\nC --> A(zzz)");
  EXPECT_EQ(
      messagesOf(text),
      (Messages{
          "4:17: warning: unknown name 'lenght' in the successor of A(length): its value is 0 | did you mean 'length'? "
          "Names visible here: length, width, Q, Z",
          "5:9: warning: unknown name 'widht' in the successor of B: its value is 0 | did you mean 'width'? Names "
          "visible here: width, Q, Z",
          "6:9: warning: unknown name 'zzz' in the successor of C: its value is 0 | names visible here: width, Q, Z"}));
  EXPECT_EQ(
      messagesOf(text, Compatibility::Cpfg)[0],
      "4:17: warning: unknown name 'lenght' in the successor of A(length): its value is 0 | did you mean 'length'? "
      "Names visible here: length, width");
  EXPECT_TRUE(contains(codeOf(text), "LoadStatic 0 lenght"));
}

TEST(Analyser, ABlockMayReadAVariableThatOnlyProductionsAssign) {
  const std::string text = header("EndEach: {printf(\"%g\", n);}", "A(x) : {n = n + 1;} * --> A(x)");
  EXPECT_EQ(messagesOf(text), Messages{});
  EXPECT_TRUE(contains(codeOf(text), "StoreVariable 0 n"));
}

TEST(Analyser, UnknownFunctionsAreErrors) {
  EXPECT_EQ(messagesOf(header("Start: {x = 1;}", "A(n) --> A(sine(n))\nB --> A(x(3))")),
            (Messages{"4:12: error: unknown function 'sine' in the successor of A(n) | did you mean 'sin'?",
                      "5:9: error: unknown function 'x' in the successor of B | 'x' is a variable; write the "
                      "multiplication as 'x * "
                      "(...)'"}));
  const Messages messages = messagesOf(header("", "A(n) --> A(abcdefgh(n))"));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(
      contains(messages[0], "unknown function 'abcdefgh' in the successor of A(n) | functions: sin, cos, tan,"));
}

TEST(Analyser, ArgumentCountsAreChecked) {
  EXPECT_EQ(messagesOf(header("", "A(n) --> A(sin(n,1),atan(1,2,3),clamp(1))")),
            (Messages{"4:12: error: expected 1 argument of 'sin', found 2",
                      "4:21: error: expected 1 to 2 arguments of 'atan', found 3",
                      "4:33: error: expected 3 arguments of 'clamp', found 1"}));
  EXPECT_EQ(messagesOf(header("", "A(n) --> A(sin(0,5))")),
            Messages{"4:12: error: expected 1 argument of 'sin', found 2 | write 0.5 with a point"});
}

TEST(Analyser, ArraysAreCheckedLikeFunctions) {
  EXPECT_EQ(messagesOf(header(
                "Define: { array weight[2][3]; }",
                "A(n) --> A(weight[n])\nB(n) --> A(weight)\nC(n) --> A(wieght[0][1])\nD(n) : {weight = 1;} * --> B")),
            (Messages{"4:12: error: expected 2 subscripts of the array 'weight', found 1 | write weight[0][0]",
                      "5:12: error: the array 'weight' needs a subscript in the successor of B(n) | write weight[0][0]",
                      "6:12: error: unknown array 'wieght' in the successor of C(n) | did you mean 'weight'?",
                      "7:9: error: the array 'weight' needs a subscript in a block of D(n) | write weight[0][0]"}));
  EXPECT_EQ(
      messagesOf(header("", "A(n) --> A(w[0])")),
      Messages{
          "4:12: error: unknown array 'w' in the successor of A(n) | arrays are defined before the axiom: 'define: { "
          "array w[5]; }'"});
}

TEST(Analyser, DefinitionsAreChecked) {
  EXPECT_EQ(
      messagesOf(header("Define: { array a[2] = {1,2,3}, b[2], b[3]; external b; }", "A(n) --> A(b[0])")),
      (Messages{"2:17: error: the array 'a' has 2 elements, found 3 values",
                "2:39: error: the array 'b' is defined twice", "2:54: error: the variable 'b' is defined twice"}));
  core::Limits limits;
  limits.maximumArrayElements = 10;
  EXPECT_EQ(messagesOf(header("Define: { array a[4][4]; }", "A(n) --> A(n)"), Compatibility::Espalier, limits),
            Messages{"2:17: error: the arrays have more elements than the limit arrayElements (10)"});
  // the uses of a wrong array are no further mistakes
  EXPECT_EQ(messagesOf(header("Define: { array a[11], b[1] = {1,2}; }", "A(n) --> A(a[n]+b[n])"),
                       Compatibility::Espalier, limits),
            (Messages{"2:17: error: the arrays have more elements than the limit arrayElements (10)",
                      "2:24: error: the array 'b' has 1 elements, found 2 values"}));
  // all arrays of an L-system together
  EXPECT_EQ(messagesOf(header("Define: { array a[6], b[4]; }", "A(n) --> A(n)"), Compatibility::Espalier, limits),
            Messages{});
  EXPECT_EQ(messagesOf(header("Define: { array a[6], b[5]; }", "A(n) --> A(n)"), Compatibility::Espalier, limits),
            Messages{"2:23: error: the arrays have more elements than the limit arrayElements (10)"});
}

// ---- printf and files

TEST(Analyser, FormatsAreChecked) {
  EXPECT_EQ(
      messagesOf(header("Start: {printf(\"%g %d\\n\", 1); printf(\"%s\", 1); printf(1); printf(\"100%%\"); }",
                        "A(n) --> A(n)")),
      (Messages{
          "2:16: warning: the format of 'printf' has 2 conversions for 1 value",
          "2:38: error: the conversion '%s' of 'printf' does not fit a number | use %g, %f, %e or %d; '%%' prints a "
          "percent sign",
          "2:55: error: expected a format in quotes as argument 1 of 'printf'"}));
  EXPECT_EQ(messagesOf(header("Start: {printf(\"%g %d\\n\", 1);}", "A(n) --> A(n)")),
            Messages{"2:16: warning: the format of 'printf' has 2 conversions for 1 value"});
}

TEST(Analyser, FileFunctionsAreChecked) {
  EXPECT_EQ(
      messagesOf(header(
          "Start: {f = fopen(\"a\", 1); fclose(f+1); fprintf(f, \"%g\", 1); fscanf(f, \"%g\", x); fscanf(f, \"%g\"); "
          "y = &f; z = \"text\";}",
          "A(n) --> A(n)")),
      (Messages{
          "2:24: error: expected a mode such as \"r\" or \"w\" in quotes as argument 2 of 'fopen'",
          "2:35: error: expected a variable as the first argument of 'fclose' | the variable holds the result of "
          "fopen: f = fopen(\"name\", \"r\");",
          "2:78: error: expected a variable with '&' as argument 3 of 'fscanf' | write fscanf(f, \"%g\", &x)",
          "2:82: error: expected 3 to 1000 arguments of 'fscanf', found 2",
          "2:103: error: '&' has a meaning only among the arguments of fscanf",
          "2:111: error: a string has no value in Start | strings are formats and file names: printf(\"x = %g\\n\", "
          "x)"}));
}

TEST(Analyser, FilesAreOpenedInAKnownModeAndInsideTheFolder) {
  EXPECT_EQ(messagesOf(header("Start: {f = fopen(\"a.txt\", \"x\");}", "A(n) --> A(n)")),
            Messages{"2:28: error: 'fopen' has no mode \"x\" | \"r\" reads, \"w\" writes a new file, \"a\" adds to "
                     "its end; \"r+\", \"w+\" and \"a+\" read and write"});
  for (const char* name : {"/etc/passwd", "../passwd", "a/../../passwd", "C:passwd", "..\\\\passwd"}) {
    const Messages messages =
        messagesOf(header("Start: {f = fopen(\"" + std::string(name) + "\", \"r\");}", "A(n) --> A(n)"));
    ASSERT_EQ(messages.size(), 1U) << name;
    EXPECT_NE(messages[0].find("is not inside the model's folder: fopen fails and returns 0"), std::string::npos)
        << messages[0];
  }
  EXPECT_EQ(messagesOf(header("Start: {f = fopen(\"data/./a..b.txt\", \"rb+\");}", "A(n) --> A(n)")), Messages{});
}

TEST(Analyser, ManyVariablesAreNoTrouble) {
  std::string block;
  for (int i = 0; i < 100'000; ++i) {
    block += "v" + std::to_string(i) + "=1;";
  }
  const auto program = programOf(header("Start: {" + block + "}", "A(n) --> A(v99999)"));
  EXPECT_EQ(program->systems[0].variables.size(), 100'000U);
}

TEST(Analyser, TheFirstLSystemHasNoCallerWhoseVariablesItCouldShare) {
  EXPECT_EQ(messagesOf(header("define: {external n;}", "A(x) --> A(n)")),
            Messages{"2:19: warning: no L-system calls the first one: its external variable 'n' is an ordinary "
                     "variable with the value 0"});
}

TEST(Analyser, TargetsOfFscanfAreAssigned) {
  const auto program = programOf(header("Start: {f = 0; fscanf(f, \"%g\", &x);}", "A(n) --> A(x)"));
  EXPECT_EQ(program->systems[0].variables, (std::vector<std::string>{"f", "x"}));
}

// ---- items

TEST(Analyser, ItemsMustBeConstant) {
  EXPECT_EQ(
      messagesOf(header("derivation length: n+3\nseed: ran(5)",
                        "A(n) --> A(n)\ndecomposition\nmaximum depth: 1/0\nA(n) --> B")),
      (Messages{"2:20: warning: unknown name 'n' in 'derivation length:': its value is 0 | variables have no value yet "
                "when a "
                "model is read; use #define",
                "3:7: error: 'ran' cannot be used in 'seed:', which must be constant",
                "7:16: error: the value of 'maximum depth:' is not a number: it divides by zero or is not finite"}));
}

TEST(Analyser, ItemsAreEvaluatedWithFunctions) {
  const auto program = programOf(header("derivation length: floor(sqrt(20))*2\nseed: -3", "A(n) --> A(n)"));
  EXPECT_EQ(program->derivationLength, 8U);
  EXPECT_EQ(program->systems[0].seed, -3);
}

TEST(Analyser, ItemsOutOfRangeCountAsTheNearestValue) {
  EXPECT_EQ(messagesOf(header("derivation length: -1", "A(n) --> A(n)")),
            Messages{"2:20: warning: the value of 'derivation length:' is out of range | the program uses the least "
                     "possible value"});
}

TEST(Analyser, OnlyTheFirstDerivationLengthCounts) {
  EXPECT_EQ(
      messagesOf(model("A(n) --> A(n)?(2)B$") + "Lsystem: 2\nderivation length: 3\nAxiom: B\nB --> B\nendlsystem\n"),
      Messages{"6:1: warning: the derivation length of a sub-L-system has no effect | only that of the first L-system "
               "counts"});
}

// ---- stochastic and unreachable productions

TEST(Analyser, ProbabilitiesMakeAnLSystemStochasticInEspaliersOwnMode) {
  const std::string text = header("", "A(n) --> A(n) : 1\nA(n) --> B : 2");
  EXPECT_TRUE(programOf(text)->systems[0].isStochastic);
  EXPECT_FALSE(programOf(text, Compatibility::Cpfg)->systems[0].isStochastic);
  EXPECT_TRUE(programOf(header("seed: 0", "A(n) --> A(n)"), Compatibility::CpfgBatch)->systems[0].isStochastic);
  EXPECT_EQ(
      messagesOf(text, Compatibility::Cpfg),
      (Messages{
          "4:17: warning: probabilities are ignored: the L-system has no 'seed:', so the first production that matches "
          "is "
          "applied | put 'seed: 1' before the axiom",
          "5:1: warning: this production is never applied: an earlier production matches wherever this one would | the "
          "earlier production is: A(n) --> A(n); move it behind this one"}));
}

TEST(Analyser, ProductionsBehindAnUnconditionalOneAreReported) {
  EXPECT_EQ(messagesOf(header("", "A(n) : n > 1 --> BA\nA(n) --> C\nA(n)B > C --> D\nA --> E")),
            Messages{"6:1: warning: this production is never applied: an earlier production matches wherever this one "
                     "would | the earlier production is: "
                     "A(n) --> C; move it behind this one"});
}

TEST(Analyser, ProbabilitiesOfADecompositionHaveNoEffect) {
  EXPECT_EQ(messagesOf(header("", "A(n) --> A(n)\ndecomposition\nA(n) --> B : 2")),
            Messages{"6:14: warning: a probability has no effect in the decomposition | the first production that "
                     "matches is applied "
                     "there"});
}

TEST(Analyser, ABracketInALeftContextIsReported) {
  EXPECT_EQ(
      messagesOf(header("", "[ < A(n) --> B")),
      Messages{
          "4:1: warning: a bracket in a left context never matches | the left context steps over brackets by itself"});
}

TEST(Analyser, WarningsAreDroppedBesideSyntaxErrors) {
  EXPECT_EQ(
      messagesOf(header("", "A(n) --> A(m)\nA(n) --> B(")),
      Messages{"5:12: error: expected an expression while reading the successor of A(n), found the end of the line"});
}

}  // namespace
}  // namespace espalier::language::analyser_test
