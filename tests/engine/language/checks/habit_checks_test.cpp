#include "engine/language/checks/habit_checks.h"

#include <gtest/gtest.h>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::habit_checks_test {
namespace {

Messages messagesOf(const std::string& productions, const std::string& axiom = "A", const std::string& before = {}) {
  core::MemoryFileProvider files(
      {{"m.l", "Lsystem: 1\n" + before + "Axiom: " + axiom + "\n" + productions + "\nendlsystem\n"}});
  CompileInput input;
  input.modelFile = "m.l";
  return briefs(compile(input, files).diagnostics);
}

TEST(HabitChecks, ACommentOfAnotherLanguage) {
  const std::string hint = " | a comment is written as /* ... */ or behind //";
  EXPECT_EQ(
      messagesOf("A --> AB # the bud grows\nB --> F"),
      Messages{"3:10: warning: '# the bud grows' is read as modules: the turtle command '#' and each letter behind "
               "it" +
               hint});
  EXPECT_EQ(
      messagesOf("A --> F", "A ;start"),
      Messages{"2:10: warning: ';start' is read as modules: the turtle command ';' and each letter behind it" + hint});
  // commands before modules: letters that mean something, and capitals that only people read
  EXPECT_EQ(messagesOf("A --> F ;FXD\nB --> ! # FLK", "AB"), Messages{});
  EXPECT_EQ(messagesOf("A --> B # F ;ff\nB --> A # ABA\nC --> A ;BAC ; AB #(2)Abc", "AC"), Messages{});
}

TEST(HabitChecks, ASemicolonAtTheEndOfEveryLine) {
  EXPECT_EQ(messagesOf("A --> AB;\nB --> F;", "A;"),
            Messages{"2:9: warning: this ';' and that of each production are modules, which change the colour | remove "
                     "these ';'. If a ';' shall end each production, write 'Syntax: free' before the first L-system"});
  EXPECT_EQ(messagesOf("A --> AB;\nB --> F", "A;"), Messages{});
  EXPECT_EQ(messagesOf("A --> AB;\nB --> F;"), Messages{});
  // one that a production reads, and an axiom alone
  EXPECT_EQ(messagesOf("A --> AB;\n; --> ;;", "A;"), Messages{});
  EXPECT_EQ(messagesOf("homomorphism\nA --> F", "A;"), Messages{});
}

TEST(HabitChecks, ASurfaceWithALongName) {
  const std::string undefined =
      ": warning: the surface '~l' is not defined and is not drawn | write 'surface: l FILE.s' into the view file, "
      "which "
      "has the model's name and the suffix .v";
  EXPECT_EQ(
      messagesOf("A --> F[~leaf(2)]"),
      (Messages{"3:9: warning: '~leaf(2)' is read as the surface '~l' and a module for each letter behind it | the "
                "name of a surface has one letter, as in ~l(2)",
                "3:10" + undefined}));
  EXPECT_EQ(messagesOf("A --> F[~lFf]~l(2)fab"), Messages{"3:10" + undefined});
}

// each of these took time by the square of its length
TEST(HabitChecks, LongOnesAreQuotedInPart) {
  const std::string digits(300'000, '1');
  EXPECT_EQ(messagesOf("A --> F" + digits),
            Messages{"3:7: warning: 'F" + digits.substr(0, 79) +
                     "…' is read as 'F' and a module for each digit | a value stands in parentheses: F(" +
                     digits.substr(0, 79) + "…)"});
  std::string chain = "0";
  for (int i = 0; i < 10'000; ++i) {
    chain += "<n";
  }
  for (const std::string& message : messagesOf("A(n) : " + chain + " --> A(n)", "A(1)" + std::string(300'000, 'F'))) {
    EXPECT_LT(message.size(), 500U);
  }
}

TEST(HabitChecks, DigitsThatAreModulesAndVertices) {
  EXPECT_EQ(messagesOf("A --> F1(2)A"), Messages{});
  EXPECT_EQ(messagesOf("A --> {F1.F}"),
            Messages{"3:8: warning: 'F1' is read as 'F' and a module for each digit | a value stands in parentheses: "
                     "F(1)"});
}

TEST(HabitChecks, ANumberWithoutParentheses) {
  EXPECT_EQ(
      messagesOf("A --> F1.5[+45A][-45A]F1.5"),
      (Messages{"3:7: warning: 'F1.5' is read as 'F' and a module for each digit | a value stands in parentheses: "
                "F(1.5)",
                "3:12: warning: '+45' is read as '+' and a module for each digit | a value stands in parentheses: "
                "+(45)",
                "3:18: warning: '-45' is read as '-' and a module for each digit | a value stands in parentheses: "
                "-(45)"}));
  // digits that are modules
  EXPECT_EQ(messagesOf("A --> F1F0A\n1 < 0 --> 1\n1 --> 0"), Messages{});
  EXPECT_EQ(messagesOf("A --> F 1 B2(3)"), Messages{});
}

TEST(HabitChecks, AChoiceInASuccessor) {
  const std::string rest =
      " is read as modules: a successor cannot choose | write a production for each case, as A(n) : n < 3 --> F and "
      "below it A(n) --> B: the first that matches applies";
  EXPECT_EQ(messagesOf("A(n) : n < 3 --> F A(n+1) else B", "A(1)"), Messages{"3:27: warning: 'else'" + rest});
  EXPECT_EQ(messagesOf("A(n) --> if (n < 3) F A(n+1) else B", "A(1)"), Messages{"3:10: warning: 'if (n < 3)'" + rest});
  EXPECT_EQ(messagesOf("A(n) --> if(n)else(n)A(n)", "A(1)"), Messages{});
}

TEST(HabitChecks, AComparisonOfAComparison) {
  EXPECT_EQ(messagesOf("A(n) : 0 < n+1 <= 2*n --> F", "A(1)"),
            Messages{"3:8: warning: '0 < n+1 <= 2*n' compares the result of '0 < n+1', which is 0 or 1, with '2*n' | "
                     "write 0 < n+1 && n+1 <= 2*n"});
  EXPECT_EQ(messagesOf("A(n) : (0 < n) < 2 --> F(n < 2 == 1)F(0 < n < 2)", "A(1)"), Messages{});
}

TEST(HabitChecks, ADecimalComma) {
  EXPECT_EQ(messagesOf("A --> F(2*1,5)+(30, 5)@M(1,2,3)"),
            Messages{"3:7: warning: the turtle reads one parameter of 'F', and 'F(2*1,5)' has 2 | write 1.5 with a "
                     "point"});
  EXPECT_EQ(messagesOf("A --> F(1,5)\nF(x,y) --> F(y,x)"), Messages{});
  EXPECT_EQ(messagesOf("A --> F(1,5)F(2.5)F(1,2,3)"), Messages{});
  // where productions read another number of parameters
  EXPECT_EQ(messagesOf("A(n) --> A(n)A(n+0,5)", "A(1)"),
            Messages{"3:14: warning: no production rewrites 'A(n+0,5)': the productions of A have 1 parameter | write "
                     "0.5 with a point"});
  EXPECT_EQ(messagesOf("A(n) --> A(n)A(1,2,3)", "A(1)"),
            Messages{"3:14: warning: no production rewrites 'A(1,2,3)': the productions of A have 1 parameter | a "
                     "production matches only modules with exactly as many parameters"});
  EXPECT_EQ(messagesOf("A(n) --> A(n)A(max(1,2),n)", "A(1)"),
            Messages{"3:14: warning: no production rewrites 'A(max(1,2),n)': the productions of A have 1 parameter | a "
                     "production matches only modules with exactly as many parameters"});
}

TEST(HabitChecks, AProbabilityInThePlaceOfTheCondition) {
  const std::string hint =
      " | a number behind the predecessor is a condition; a probability stands at the end, as in A --> AB : 0.5";
  EXPECT_EQ(messagesOf("A : 0.5 --> FA"), Messages{"3:5: warning: the condition '0.5' always holds" + hint});
  EXPECT_EQ(messagesOf("A : 70 --> FA\nA : 30 --> +A", "A", "seed: 1\n"),
            (Messages{"4:5: warning: the condition '70' always holds" + hint,
                      "5:5: warning: the condition '30' always holds" + hint}));
  EXPECT_EQ(messagesOf("A : 1 --> FA"), Messages{});
}

}  // namespace
}  // namespace espalier::language::habit_checks_test
