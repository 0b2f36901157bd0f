#include "engine/language/preprocess/preprocessor.h"

#include <gtest/gtest.h>

#include "engine/core/work_meter.h"
#include "engine/language/outline/name_uses.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language::preprocessor_test {
namespace {

PreprocessResult run(const std::string& text, PreprocessInput input = {},
                     std::map<std::string, std::string> others = {}) {
  core::MemoryFileProvider files(std::move(others));
  files.add("m.l", text);
  input.file = "m.l";
  return preprocess(input, files);
}

std::string textOf(const std::string& text, PreprocessInput input = {},
                   std::map<std::string, std::string> others = {}) {
  const PreprocessResult result = run(text, std::move(input), std::move(others));
  EXPECT_EQ(briefs(result.diagnostics), Messages{});
  return result.text;
}

Messages problemsOf(const std::string& text, PreprocessInput input = {},
                    std::map<std::string, std::string> others = {}) {
  return briefs(run(text, std::move(input), std::move(others)).diagnostics);
}

TEST(Preprocessor, AFloodOfMistakesIsCountedButNotKept) {
  std::string text;
  for (int i = 0; i < 100'000; ++i) {
    text += "#foo\n";
  }
  const PreprocessResult result = run(text);
  EXPECT_EQ(result.diagnostics.errorCount(), 100'000U);
  EXPECT_EQ(result.diagnostics.entries().size(), core::DiagnosticList::kLimit);
}

// ---- lines and comments

TEST(Preprocessor, PlainTextIsUnchanged) {
  EXPECT_EQ(textOf("A --> B\n\tC\n"), "A --> B\n\tC\n");
}

TEST(Preprocessor, AMissingFinalNewlineIsAdded) {
  EXPECT_EQ(textOf("A"), "A\n");
}

TEST(Preprocessor, CarriageReturnsBeforeNewlinesAreDropped) {
  EXPECT_EQ(textOf("A\r\nB\r\n"), "A\nB\n");
}

TEST(Preprocessor, BackslashNewlineJoinsLines) {
  EXPECT_EQ(textOf("K --> \\\nL\n"), "K --> L\n");
  EXPECT_EQ(textOf("K --> \\\r\nL\n"), "K --> L\n");
  EXPECT_EQ(textOf("A\\B\n"), "A\\B\n");
}

TEST(Preprocessor, ACommentIsOneBlank) {
  EXPECT_EQ(textOf("A/* K */B // N\n"), "A B  \n");
}

TEST(Preprocessor, ACommentOverLinesKeepsItsNewlines) {
  EXPECT_EQ(textOf("A/* 1\n2 */B\n"), "A \nB\n");
}

TEST(Preprocessor, NoDirectiveBeginsBehindACommentOfAnEarlierLine) {
  EXPECT_EQ(textOf("/* 1\n*/#define n 3\nn\n"), " \n#define n 3\nn\n");
}

TEST(Preprocessor, CommentsAndMacrosInsideStringsStay) {
  EXPECT_EQ(textOf("#define n 3\nprintf(\"// n /* %g\\\" n\",n)\n"), "printf(\"// n /* %g\\\" n\",3)\n");
}

TEST(Preprocessor, AQuoteWithoutPartnerBeginsNoString) {
  EXPECT_EQ(textOf("A\" // x\n"), "A\"  \n");
}

TEST(Preprocessor, AnOpenCommentIsAnError) {
  EXPECT_EQ(problemsOf("A /* b\nc\n"), Messages{"1:3: error: expected '*/' while reading a comment, found the end of "
                                                "the file | the rest of the file is part of the comment"});
}

// ---- macros

TEST(Preprocessor, ObjectMacrosReplaceWholeIdentifiersOnly) {
  EXPECT_EQ(textOf("#define K q\nK+K[K]AK K2 2K _K\n"), "q+q[q]AK K2 2K _K\n");
}

TEST(Preprocessor, FunctionMacrosNest) {
  EXPECT_EQ(textOf("#define HALF(v) ((v)/2)\n#define GROW(v,w) HALF((v)+(w))*2\nGROW(n,HALF(m)) HALF\n"),
            "(((n)+(((m)/2)))/2)*2 HALF\n");
}

TEST(Preprocessor, ArgumentsMayHoldParenthesesCommasAndStrings) {
  EXPECT_EQ(textOf("#define F(a,b) <a|b>\nF(g(1,2), \",)\")\n"), "<g(1,2)|\",)\">\n");
}

TEST(Preprocessor, AMacroWithoutParametersIsCalledWithEmptyParentheses) {
  EXPECT_EQ(textOf("#define F() x\nF() F( ) F\n"), "x x F\n");
}

TEST(Preprocessor, TheResultIsScannedAgainButNotForTheMacroItself) {
  EXPECT_EQ(textOf("#define A B\n#define B A+C\n#define C 3\nA B\n"), "A+3 B+3\n");
}

TEST(Preprocessor, ANameThatResultsMayTakeFollowingArguments) {
  EXPECT_EQ(textOf("#define F HALF\n#define HALF(v) v/2\nF(3)\n"), "3/2\n");
}

TEST(Preprocessor, AMacroThatIsBeingReplacedDoesNotTakeFollowingArguments) {
  EXPECT_EQ(textOf("#define H(x) F(1)(2)\n#define F(x) H\nH(0)\n"), "H(2)\n");
}

TEST(Preprocessor, UndefEndsAMacro) {
  EXPECT_EQ(textOf("#define A 1\nA\n#undef A\nA\n"), "1\nA\n");
}

TEST(Preprocessor, CallersMacrosCanBeReplacedAndOverridesCannot) {
  PreprocessInput input;
  input.macros = {{"M", "1"}};
  input.overrides = {{"N", "7"}};
  EXPECT_EQ(textOf("M\n#define M 2\n#define N 3\n#undef N\nM N\n", input), "1\n2 7\n");
}

TEST(Preprocessor, AnotherDefinitionOfAMacroIsAWarning) {
  EXPECT_EQ(
      problemsOf("#define A 1\n#define A 1\n#define A 2\n"),
      Messages{"3:9: warning: the macro 'A' is defined again; from here on this definition counts | first defined at "
               "m.l:2; if this is intended, write #undef before the new definition"});
}

TEST(Preprocessor, AWrongNumberOfArgumentsIsAnError) {
  EXPECT_EQ(problemsOf("#define F(a,b) a\nx F(1)\n"),
            Messages{"2:3: error: expected 2 arguments while reading the macro 'F', found 1"});
}

TEST(Preprocessor, OpenArgumentsAreAnError) {
  const Messages found{
      "2:1: error: expected ')' while reading the arguments of the macro 'F', found the end of the line | "
      "close the call; its arguments may stand on several lines"};
  EXPECT_EQ(problemsOf("#define F(a) a\nF(1\n2\n"), found);
  EXPECT_EQ(problemsOf("#define F(a) a\nF(1\n#define G 2\n)\n"), found);
}

TEST(Preprocessor, ACallMayGoOnOverSeveralLines) {
  EXPECT_EQ(textOf("#define F(a,b) <a,b>\nx F(1,\n\tF(2 /* c */,\n3)) y\nF (4,5) z\n"), "x <1,<2,3>> y\n<4,5> z\n");
  // places are those of the file
  EXPECT_EQ(problemsOf("#define F(a) a\nF(1\n) F(2,3)\n"),
            Messages{"3:3: error: expected 1 arguments while reading the macro 'F', found 2"});
  // a name that is not called, and a quote, join nothing
  EXPECT_EQ(textOf("#define F(a) a\nF\n(1)\n\"F(\" x\ny\n"), "F\n(1)\n\"F(\" x\ny\n");
}

TEST(Preprocessor, AQuoteWithoutAPartnerHidesTheRestOfACall) {
  EXPECT_EQ(problemsOf("#define F(a) a\nF(1 ' )\n"),
            Messages{"2:1: error: expected ')' while reading the arguments of the macro 'F', found the end of the line "
                     "| a ' without a partner hides the ')' behind it: remove it"});
  EXPECT_EQ(textOf("#define F(a) <a>\n#define K 7\nF(x')' K) ' K\n"), "<x')' 7> ' 7\n");
}

TEST(Preprocessor, ADollarSignIsALetterOfNames) {
  EXPECT_EQ(textOf("#define K 7\n#define a$ 8\n#define $ 9\n$K K$ 1$K #K @K a$ a $ K\n"), "$K K$ 1$K #7 @7 8 a 9 7\n");
  EXPECT_EQ(textOf("#define K$ 1\n#ifdef K$\na\n#endif\n#if defined(K) || K\nb\n#endif\n#if K$\nc\n#endif\n"),
            "a\nc\n");
}

TEST(Preprocessor, ADirectiveGoesOnBehindACommentOverSeveralLines) {
  EXPECT_EQ(textOf("#define X 2 /* a\n comment */ +3\n#define Y \\\n 1 /* b\n\n c */ \\\n + 2 // e \\\n f\nX Y\n"),
            "2   +3 1    + 2\n");
  // outside a directive the line ends
  EXPECT_EQ(textOf("A /* a\n b */ B\n"), "A  \n B\n");
}

TEST(Preprocessor, OnlyTheLastBackslashOfALineContinuesIt) {
  EXPECT_EQ(textOf("#define F(x) \\\\\n\t(2 * x)\nF(3) a\\\\\nb \\\n\\ c\n"), "\\\t(2 * 3) a\\b \\ c\n");
}

TEST(Preprocessor, WrongDefinitionsAreErrors) {
  EXPECT_EQ(
      problemsOf("#define\n#define 3\n#define F(a\n#define G(1) x\n#define H(a,a) x\n#undef +\n"),
      (Messages{"1:8: error: expected a name while reading #define, found the end of the line",
                "2:9: error: expected a name while reading #define, found '3'",
                "3:10: error: expected ')' while reading the parameters of the macro 'F', found the end of the line",
                "4:11: error: expected a parameter name while reading the macro 'G', found '1'",
                "5:13: error: the macro 'H' has two parameters named 'a'",
                "6:8: error: expected a name while reading #undef, found '+'"}));
}

TEST(Preprocessor, ACallersNameThatIsNoNameIsAnError) {
  PreprocessInput input;
  input.overrides = {{"a-b", "1"}};
  EXPECT_EQ(
      problemsOf("A\n", input),
      Messages{
          "0:0: error: 'a-b' cannot be defined: it is not a macro name | a name consists of letters, digits, '_' and "
          "'$', and does not start with a digit"});
}

// ---- conditionals

TEST(Preprocessor, ConditionalsChooseLines) {
  EXPECT_EQ(textOf("#define M 2\n#if M == 1\na\n#elif M == 2\nb\n#elif 1\nc\n#else\nd\n#endif\ne\n"), "b\ne\n");
  EXPECT_EQ(textOf("#ifdef M\na\n#else\nb\n#endif\n#ifndef M\nc\n#endif\n"), "b\nc\n");
}

TEST(Preprocessor, ConditionalsNest) {
  EXPECT_EQ(textOf("#if 0\n#if 1\na\n#else\nb\n#endif\n#else\nc\n#endif\n"), "c\n");
}

TEST(Preprocessor, ConditionsKnowDefinedAndTheOperatorsOfC) {
  EXPECT_EQ(textOf("#define A\n#if defined(A) && !defined B && (1 << 3 | 2) == 10 && 7 % 4 == 3\nx\n#endif\n"), "x\n");
  EXPECT_EQ(textOf("#if unknown || 0x10 - 020 || -1 + 1\na\n#else\nb\n#endif\n"), "b\n");
  EXPECT_EQ(textOf("#if 1 ? 0 : 1\na\n#else\nb\n#endif\n"), "b\n");
}

TEST(Preprocessor, DirectivesLeaveNoLineSoThatAProductionContinuesBehindThem) {
  EXPECT_EQ(textOf("A --> B\n#if 1\n\tC\n#endif\n"), "A --> B\n\tC\n");
}

TEST(Preprocessor, WrongConditionsAreErrors) {
  EXPECT_EQ(
      problemsOf("#if 1 +\n#endif\n#if 1.5\n#endif\n#if 1/0\n#endif\n#if (1\n#endif\n#if 1 2\n#endif\n"),
      (Messages{"1:5: error: expected an integer while reading the condition of a directive, found the end of the line",
                "3:5: error: expected an integer while reading the condition of a directive, found '1.5'",
                "5:5: error: division by zero in the condition of a directive",
                "7:5: error: expected ')' while reading the condition of a directive, found the end of the line",
                "9:5: error: expected an operator while reading the condition of a directive, found '2'"}));
}

TEST(Preprocessor, UnbalancedConditionalsAreErrors) {
  EXPECT_EQ(
      problemsOf("#else\n#endif\n#elif 1\n#if 1\n#else\n#else\n"),
      (Messages{"1:1: error: #else without #if", "2:1: error: #endif without #if", "3:1: error: #elif without #if",
                "6:1: error: #else after #else",
                "4:1: error: expected #endif while reading this conditional, found the end of the file | every #if, "
                "#ifdef and #ifndef ends with #endif"}));
}

// ---- directives

TEST(Preprocessor, AConditionalEndsInItsOwnFile) {
  EXPECT_EQ(problemsOf("#if 1\n#include \"o.l\"\n#endif\n", {}, {{"o.l", "A\n#endif\n"}}),
            Messages{"2:1: error: #endif without #if"});
}

TEST(Preprocessor, OnlyColumnOneStartsADirective) {
  EXPECT_EQ(textOf(" #(2)F\n\t#(2)\n"), " #(2)F\n\t#(2)\n");
}

TEST(Preprocessor, LinesForToolsAreIgnored) {
  EXPECT_EQ(textOf("#line 3 \"x\"\n# 4 \"y\"\n#pragma once\n#\n#ident \"x\"\nA\n"), "A\n");
}

TEST(Preprocessor, UnknownDirectivesAreErrors) {
  EXPECT_EQ(
      problemsOf("#(w) --> x\n#defin A\n"),
      (Messages{"1:1: error: expected a directive after '#', found '(' | a '#' in column 1 starts a directive; for the "
                "symbol '#' put something before it, as in '* < #(w) --> *'",
                "2:1: error: expected a directive after '#', found 'defin' | did you mean '#define'?"}));
}

TEST(Preprocessor, ErrorAndWarningDirectivesSpeak) {
  EXPECT_EQ(problemsOf("#error too  old\n#warning odd\n#if 0\n#error no\n#endif\n"),
            (Messages{"1:1: error: #error too  old", "2:1: warning: #warning odd"}));
}

// ---- includes

TEST(Preprocessor, IncludesAreLookedForBesideTheFileThatNamesThem) {
  core::MemoryFileProvider files(
      {{"d/m.l", "#include \"s/a.h\"\nM\n"}, {"d/s/a.h", "#include <b.h>\nA"}, {"d/s/b.h", "B\n"}});
  PreprocessInput input;
  input.file = "d/m.l";
  const PreprocessResult result = preprocess(input, files);
  EXPECT_EQ(briefs(result.diagnostics), Messages{});
  EXPECT_EQ(result.text, "B\nA\nM\n");
  ASSERT_EQ(result.sourceMap.files.size(), 3U);
  EXPECT_EQ(result.sourceMap.files[2].name, "d/s/b.h");
  EXPECT_EQ(result.sourceMap.locate({2, 3}).file, "d/s/a.h");
}

TEST(Preprocessor, RollsWithoutBlanksAreAComment) {
  const std::string rest =
      ": warning: '//' begins a comment, so the rest of this line is not read | put a blank between two roll symbols, "
      "as "
      "in / / /, or write one roll with its angle, as in /(90)";
  EXPECT_EQ(problemsOf("Axiom: A//[A]\nA --> [&FL!A]/////'[&FL!A]\nF --> S/////F\n"),
            (Messages{"1:9" + rest, "2:14" + rest, "3:8" + rest}));
  EXPECT_EQ(problemsOf("A --> F(x)//length [m]\nA --> [B]//two of them\nA --> B //[a]\nA --> B////// a line //////\nx: y//[a]\nA --> / /[B]\n"),
            Messages{});
}

TEST(Preprocessor, AMissingIncludeIsAnError) {
  EXPECT_EQ(problemsOf("#include \"no.h\"\n#include no\n#include\n"),
            (Messages{"1:10: error: cannot read the included file 'no.h' | an included file is looked for beside the "
                      "file that includes it",
                      "2:10: error: expected \"file\" or <file> while reading #include, found 'no' | write the name of "
                      "the file in quotes: #include \"no\"",
                      "3:9: error: expected \"file\" or <file> while reading #include, found the end of the line"}));
}

TEST(Preprocessor, AMissingFileIsAnError) {
  core::MemoryFileProvider files;
  PreprocessInput input;
  input.file = "no.l";
  const PreprocessResult result = preprocess(input, files);
  EXPECT_EQ(briefs(result.diagnostics),
            Messages{"0:0: error: cannot read the file 'no.l' | check the name and that the file may be read"});
  EXPECT_FALSE(result.isComplete);
}

// ---- places

TEST(Preprocessor, PlacesSurviveCommentsContinuationAndMacros) {
  const PreprocessResult result = run("#define R 0.5\nA /*c*/ B \\\nC R D\n");
  ASSERT_EQ(result.text, "A   B C 0.5 D\n");
  const auto placeOf = [&](std::string_view part) {
    const auto begin = static_cast<std::uint32_t>(result.text.find(part));
    const core::SourceLocation place = result.sourceMap.locate({begin, begin + 1});
    return std::to_string(place.line) + ":" + std::to_string(place.column) + place.expansion;
  };
  EXPECT_EQ(placeOf("B"), "2:9");
  EXPECT_EQ(placeOf("C"), "3:1");
  EXPECT_EQ(placeOf("5"), "3:3in the expansion of R (m.l:1:9)");
  EXPECT_EQ(placeOf("D"), "3:5");
}

// ---- limits

TEST(Preprocessor, AnExpansionBombEndsAtALimit) {
  std::string text = "#define A0 xxxxxxxxxx\n";
  for (int i = 1; i < 40; ++i) {
    const std::string below = "A" + std::to_string(i - 1);
    text += "#define A" + std::to_string(i) + " " + below + " " + below + "\n";
  }
  PreprocessInput input;
  input.limits.maximumSourceBytes = 100000;
  const PreprocessResult result = run(text + "A39\n", input);
  EXPECT_EQ(briefs(result.diagnostics),
            Messages{"41:1: error: macros expand to more than the limit sourceBytes (100000 bytes)"});
  EXPECT_FALSE(result.isComplete);
}

TEST(Preprocessor, AFewBytesDoNotExpandToMegabytes) {
  std::string text = "#define A0 xxxxxxxxxx\n";
  for (int i = 1; i < 40; ++i) {
    const std::string below = "A" + std::to_string(i - 1);
    text += "#define A" + std::to_string(i) + " " + below + " " + below + "\n";
  }
  const std::string model = text + "A39\n";
  EXPECT_EQ(briefs(run(model).diagnostics),
            Messages{"41:1: error: macros expand to more than " + std::to_string(1'000'000 + 100 * model.size()) +
                     " bytes, a hundred times the text of the model | use smaller macros, or a loop or an array in "
                     "their place"});
  // a longer text may use them more often
  const std::string comment = "/*" + std::string(100'000, ' ') + "*/\n";
  EXPECT_FALSE(run(text + "A17\n").isComplete);
  EXPECT_TRUE(run(comment + text + "A17\n").isComplete);
}

TEST(Preprocessor, ManySmallExpansionsAreCountedTogether) {
  std::string text = "#define A0 xxxxxxxxxx\n";
  for (int i = 1; i < 14; ++i) {
    const std::string below = "A" + std::to_string(i - 1);
    text += "#define A" + std::to_string(i) + " " + below + " " + below + "\n";
  }
  EXPECT_TRUE(run(text + "A13\n").isComplete);
  for (int i = 0; i < 30; ++i) {
    text += "A13\n";
  }
  EXPECT_FALSE(run(text).isComplete);
}

/// Counts how often work asks whether to go on. Each search for the end of a string asks once.
class CountedWork final : public core::WorkMeter {
 public:
  [[nodiscard]] bool take(std::int64_t) noexcept override { return true; }
  [[nodiscard]] bool isStopped() const noexcept override {
    ++looks_;
    return false;
  }
  [[nodiscard]] std::size_t looks() const { return looks_; }

 private:
  mutable std::size_t looks_ = 0;
};

TEST(Preprocessor, ALineOfQuotesWithoutPartnersIsSearchedOnce) {
  constexpr int kQuotes = 20'000;
  std::string quotes;
  for (int i = 0; i < kQuotes; ++i) {
    quotes += "\"\\";
  }
  // as the text of a model, as the arguments of a call and as the text of a macro
  const std::string text = "#define M(x) x\n#define Q " + quotes + "\n#define G(x) " + quotes + "\n" + quotes + "\nM(" +
                           quotes + ")\nQ\nG(1)\n";
  CountedWork work;
  {
    const core::WorkMeter::Scope scope(&work);
    const PreprocessResult result = run(text);
    EXPECT_NE(result.text.find(quotes), std::string::npos);
    EXPECT_FALSE(macroUses(result.sourceMap).empty());
  }
  EXPECT_LT(work.looks(), 200U);
}

TEST(Preprocessor, AQuoteBehindOneWithoutPartnerOnTheLineBeforeBeginsAString) {
  EXPECT_EQ(textOf("#define A B\n\"\\\" A\n\"A\" A\n"), "\"\\\" B\n\"A\" B\n");
}

TEST(Preprocessor, DeepMacrosEndAtALimit) {
  std::string text = "#define A0 x\n";
  for (int i = 1; i < 10; ++i) {
    text += "#define A" + std::to_string(i) + " A" + std::to_string(i - 1) + "\n";
  }
  PreprocessInput input;
  input.limits.maximumMacroDepth = 5;
  EXPECT_EQ(problemsOf(text + "A9\n", input),
            Messages{"11:1: error: the macro 'A4' is nested deeper than the limit macroDepth (5)"});
}

TEST(Preprocessor, DeepArgumentsEndAtALimit) {
  PreprocessInput input;
  input.limits.maximumMacroDepth = 5;
  EXPECT_EQ(textOf("#define F(x) x\nF(F(F(F(F(1)))))\n", input), "1\n");
  EXPECT_EQ(problemsOf("#define F(x) x\nF(F(F(F(F(F(1))))))\n", input),
            Messages{"2:1: error: the macro 'F' is nested deeper than the limit macroDepth (5)"});
}

TEST(Preprocessor, AFileThatIncludesItselfEndsAtALimit) {
  PreprocessInput input;
  input.limits.maximumIncludeDepth = 3;
  EXPECT_EQ(problemsOf("#include \"m.l\"\n", input),
            Messages{"1:10: error: files are included deeper than the limit includeDepth (3) | 'm.l' includes itself, "
                     "directly or through another file"});
}

TEST(Preprocessor, TooMuchTextEndsAtALimit) {
  PreprocessInput input;
  input.limits.maximumSourceBytes = 20;
  EXPECT_EQ(problemsOf(std::string(30, 'A'), input),
            Messages{"1:1: error: the files of the model are longer than the limit sourceBytes (20 bytes)"});
}

TEST(Preprocessor, MacrosAndTextTogetherEndAtALimit) {
  // neither the file nor what its macros make reaches the limit alone
  PreprocessInput input;
  input.limits.maximumSourceBytes = 1000;
  const std::string text = "#define A " + std::string(300, 'x') + "\n" + std::string(600, 'y') + "\n";
  EXPECT_TRUE(run(text + "A\n", input).isComplete);
  EXPECT_EQ(problemsOf(text + "A A\n", input),
            Messages{"3:3: error: the preprocessed text is longer than the limit sourceBytes (1000 bytes)"});
}

}  // namespace
}  // namespace espalier::language::preprocessor_test
