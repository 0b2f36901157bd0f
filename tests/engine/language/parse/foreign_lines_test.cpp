// Messages about the habits that authors bring from other programs, papers and editors.
#include "engine/language/parse/foreign_lines.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::foreign_lines_test {
namespace {

// a model whose line 2 is `item`
Messages item(const std::string& line) {
  return messagesOf("Lsystem: 1\n" + line + "\nAxiom: A\nA --> AB\nB --> B\nendlsystem\n");
}

// a model whose line 3 is `line`
Messages production(const std::string& line) {
  return messagesOf("Lsystem: 1\nAxiom: A(1)\n" + line + "\nA(n) --> A(n + 1)\nendlsystem\n");
}

std::string first(const Messages& messages) {
  return messages.empty() ? std::string() : messages.front();
}

TEST(ForeignLines, AHeadingOfProductionsIsNamed) {
  const std::string begin = "3:1: error: expected a production while reading the productions after the axiom, found ";
  const std::string end = " | the productions follow the axiom without a heading: remove this line";
  EXPECT_EQ(production("production:"), Messages{begin + "'production:'" + end});
  EXPECT_EQ(production("Productions:"), Messages{begin + "'Productions:'" + end});
  EXPECT_EQ(production("rules"), Messages{begin + "'rules'" + end});
  EXPECT_EQ(production("interpretation:"),
            Messages{begin + "'interpretation:' | the productions for the drawing follow the heading 'homomorphism:'"});
  EXPECT_EQ(item("production:"), Messages{"2:1: error: expected an item or 'Axiom:' while reading the items of the "
                                          "L-system 1, found 'production:'" +
                                          end});
}

TEST(ForeignLines, SettingsOfOtherProgramsAreNamed) {
  const std::string begin =
      "2:1: error: expected an item or 'Axiom:' while reading the items of the L-system 1, found ";
  EXPECT_EQ(item("steps: 5"), Messages{begin + "'steps:' | the number of steps is written before the axiom, as "
                                               "'derivation length: 5'"});
  EXPECT_EQ(item("Iterations = 7"), Messages{begin + "'Iterations' | the number of steps is written before the axiom, "
                                                     "as 'derivation length: 7'"});
  EXPECT_EQ(item("angle: 25.7"), Messages{begin + "'angle:' | the angle stands in the view file, as 'angle increment: "
                                                  "25.7', or in each turn, as +(25.7)"});
  EXPECT_EQ(item("angle 30"), Messages{begin + "'angle' | the angle stands in the view file, as 'angle increment: 30', "
                                               "or in each turn, as +(30)"});
  EXPECT_EQ(item("step length: 2"),
            Messages{begin + "'step length:' | the length stands in the module that draws the line, as F(2)"});
  EXPECT_EQ(item("line width: 3"), Messages{begin + "'line width:' | the width stands in the view file, as 'initial "
                                                    "line width: 3', or in a module, as !(3)"});
  // then another axiom is not missed
  EXPECT_EQ(messagesOf("Lsystem: 1\npremise: FA\nA --> AB\nendlsystem\n"),
            Messages{begin + "'premise:' | the first string is written as 'Axiom: FA'"});
  EXPECT_EQ(item("variables: A B"), Messages{begin + "'variables:' | the symbols of a model are not listed: remove "
                                                     "this line"});
  EXPECT_EQ(production("angle: 30"),
            Messages{"3:1: error: expected a production while reading the productions after the axiom, found 'angle:' "
                     "| the angle stands in the view file, as 'angle increment: 30', or in each turn, as +(30)"});
  // each such line is reported
  EXPECT_EQ(item("steps: 5\nangle: 30").size(), 2U);
}

TEST(ForeignLines, ConstantsOfOtherLanguagesAreNamed) {
  const std::string begin =
      "2:1: error: expected an item or 'Axiom:' while reading the items of the L-system 1, found ";
  const std::string end = " | a constant is written as '#define x 3', and a variable as 'Start: { x = 3; }'";
  EXPECT_EQ(item("x = 3"), Messages{begin + "'x'" + end});
  EXPECT_EQ(item("int x = 3;"), Messages{begin + "'int x'" + end});
  EXPECT_EQ(item("const x = 3"), Messages{begin + "'const x'" + end});
  EXPECT_EQ(item("define x 3"), Messages{begin + "'define' | macros start with '#': #define"});
}

TEST(ForeignLines, RemarksOfOtherLanguagesAreNamed) {
  const std::string advice = " | a comment is written as /* ... */ or behind //";
  const std::string begin = "3:1: error: expected a production while reading the productions after the axiom, found ";
  for (const std::string sign : {";", "%", "--", "'"}) {
    EXPECT_EQ(production(sign + " a remark"), Messages{begin + "'" + sign + "'" + advice});
  }
  EXPECT_EQ(production("# a remark"), Messages{"3:1: error: expected a directive after '#', found ' a'" + advice});
  EXPECT_EQ(production("#my plant"), Messages{"3:1: error: expected a directive after '#', found 'my'" + advice});
}

TEST(ForeignLines, CommandsOfLatexAreNamed) {
  const std::string omega = "'\\omega' is how LaTeX writes the letter of the axiom: write 'Axiom: F' with your string";
  EXPECT_EQ(first(item("\\omega: F")),
            "2:1: error: expected an item or 'Axiom:' while reading the items of the L-system "
            "1, found '\\omega' | " +
                omega);
  EXPECT_EQ(first(messagesOf(model("A --> A", "\\omega"))),
            "2:8: warning: '\\omega' is read as 6 modules: '\\' and its letters | " + omega);
  EXPECT_EQ(first(messagesOf(model("A(x) --> A(x*\\alpha)"))),
            "3:14: warning: the character '\\' has no meaning in expressions and is skipped | '\\alpha' is how LaTeX "
            "writes a letter: write the name without '\\'");
  EXPECT_EQ(messagesOf(model("A(x) \\rightarrow A(x)")),
            Messages{"3:6: error: expected '-->' while reading a production, found '\\rightarrow' | '\\rightarrow' is "
                     "how LaTeX writes the arrow: write '-->'"});
  // rolls before modules are no commands
  EXPECT_EQ(messagesOf(model("A --> \\fff\\A", "A")), Messages{});
}

TEST(ForeignLines, LabelsOfProductionsAreNamed) {
  const std::string advice = " | productions have no labels: remove 'p1:'";
  EXPECT_EQ(messagesOf(model("p1: A(n) --> A(n + 1)")),
            Messages{"3:5: error: unknown function 'A' in the condition of p1" + advice});
  EXPECT_EQ(messagesOf(model("p1: A(n) : n > 1 --> A(n + 1)")),
            Messages{"3:10: error: expected '-->' while reading the condition of p1, found ':'" + advice});
  const Messages plain = messagesOf(model("p1: A --> AB", "A"));
  EXPECT_EQ(plain, Messages{"3:5: warning: unknown name 'A' in the condition of p1: its value is 0" + advice});
  EXPECT_EQ(messagesOf(model("interpretation: A --> AB", "A")),
            Messages{"3:17: warning: unknown name 'A' in the condition of interpretation: its value is 0 | the "
                     "productions for the drawing follow the heading 'homomorphism:'"});
  EXPECT_EQ(labelAdvice("Rule 1"), "productions have no labels: remove 'Rule 1:'");
  EXPECT_EQ(labelAdvice("production"), "productions have no labels: remove 'production:'");
  EXPECT_EQ(labelAdvice("rule_12"), "productions have no labels: remove 'rule_12:'");
  EXPECT_EQ(labelAdvice("P"), "");
  EXPECT_EQ(labelAdvice("A1"), "");
  EXPECT_EQ(messagesOf(model("2) A(n) --> A(n + 1)")),
            Messages{"3:2: error: expected '-->' while reading a production, found ')' | productions have no numbers: "
                     "remove '2)'"});
}

TEST(ForeignLines, ExpressionsOfOtherLanguagesAreNamed) {
  const auto only = [](const std::string& text) { return messagesOf(model(text)); };
  EXPECT_EQ(only("A(x) --> A(x**2)"),
            Messages{"3:14: error: expected an expression while reading the successor of A(x), "
                     "found '*' | the power is written with '^', as in x^2"});
  EXPECT_EQ(only("A(x) : if x < 2 --> A(x)"),
            Messages{"3:8: error: expected an expression while reading the condition of A(x), found 'if' | the "
                     "condition stands without the word 'if', as in A(x) : x > 1 --> B"});
  EXPECT_EQ(only("A(x) : else --> A(x)"),
            Messages{"3:8: error: expected an expression while reading the condition of A(x), found 'else' | write the "
                     "production for all other cases below, without a condition: the first that matches applies"});
  EXPECT_EQ(only("A(x) :: x > 1 --> A(x)"),
            Messages{"3:7: error: expected an expression while reading the condition of A(x), found ':' | one ':' "
                     "stands before the condition"});
  EXPECT_EQ(
      only("A(x) : x > 1 : 0.5 --> A(x)"),
      Messages{"3:14: error: expected '-->' while reading the condition of A(x), found ':' | a probability stands "
               "at the end of a production: A --> B : 0.5"});
  EXPECT_EQ(only("A(x) (0.5) --> A(x)"),
            Messages{"3:6: error: expected '-->' while reading a production, found '(' | a probability stands at the "
                     "end of a production: A --> B : 0.5"});
  EXPECT_EQ(only("A(x) --> A(0x1F)"), Messages{"3:13: error: expected ',' or ')' while reading the successor of A(x), "
                                               "found 'x1F' | numbers are decimal: write 31 in place of 0x1F"});
}

TEST(ForeignLines, ArrowsOfOtherNotationsAreNamed) {
  const auto only = [](const std::string& text) { return messagesOf(model(text)); };
  const std::string begin = "3:6: error: expected '-->' while reading a production, found ";
  EXPECT_EQ(only("A(x) = A(x)"), Messages{begin + "'=' | the arrow of a production is '-->'"});
  EXPECT_EQ(only("A(x) := A(x)"), Messages{"3:7: error: expected an expression while reading the condition of A(x), "
                                           "found '=' | the arrow of a production is '-->'"});
  EXPECT_EQ(only("A(x) A(x)"), Messages{"3:10: error: expected '-->' while reading a production, found the end of the "
                                        "line | a production is written as A --> AB"});
  EXPECT_EQ(first(only("A(x) ---> A(x)")),
            "3:6: warning: '--->' is read as the module '-' of the predecessor and the arrow '-->' | the arrow of a "
            "production has two strokes; put a blank behind a module '-'");
  EXPECT_EQ(only("A(x) - --> A(x)\nA(x) --> -A(x)"), Messages{});
}

TEST(ForeignLines, AConditionWithoutItsColonIsNamed) {
  const Messages messages = messagesOf(model("A(n) n > 1 --> A(n)"));
  EXPECT_EQ(messages.back(),
            "3:10: warning: '1' never matches: no axiom or successor makes the module 1 | a condition "
            "stands behind a ':', as in A(x) : x > 1 --> B");
}

TEST(ForeignLines, AMacroWithAnEqualsSignIsReportedOnceAtItsDefinition) {
  EXPECT_EQ(
      messagesOf("#define r = 2\n" + model("A(x) --> A(x*r)F(r)", "A(r)")),
      Messages{"1:11: error: the text of the macro 'r' begins with '=' | write '#define r' and its value, without "
               "'='"});
  // where the sign belongs to the text there is no mistake
  EXPECT_EQ(messagesOf("#define is ==\n#define SET =2\n" + model("A(x) : x is 2 {y SET;} --> A(y)\nA(x) --> A(2)")),
            Messages{});
}

TEST(ForeignLines, AMissingSemicolonIsReportedBehindItsStatement) {
  EXPECT_EQ(messagesOf("Lsystem: 1\nStart: {\n  x = 1\n  y = 2;\n}\nAxiom: A(x)\nA(n) --> A(y)\nendlsystem\n"),
            Messages{"3:8: error: expected ';' while reading Start, found the end of the line | every statement ends "
                     "with ';'"});
}

TEST(ForeignLines, SignsOfPrintAndPrefixesAreNamed) {
  EXPECT_EQ(
      messagesOf(model("A(x) --> A(Math.sin(x))")),
      Messages{"3:17: error: expected ',' or ')' while reading the successor of A(x), found 'sin' | functions are "
               "called by their names alone: sin(...)"});
  EXPECT_EQ(
      messagesOf(model("A(x) --> A(x)", "\u201CA(1)\u201D")),
      Messages{"2:8: error: expected a module while reading the axiom, found the character '\u201C', which is not "
               "7-bit ASCII | modules are written without quotes"});
  EXPECT_EQ(messagesOf(model("A(x) --> A(30\u00B0)")),
            Messages{"3:14: error: expected ',' or ')' while reading the successor of A(x), found the character "
                     "'\u00B0', which is not 7-bit ASCII | angles are always in degrees: remove the sign"});
}

TEST(ForeignLines, FurtherSlipsAreNamed) {
  const auto only = [](const std::string& text) { return messagesOf(model(text)); };
  EXPECT_EQ(
      only("A(x) : x mod 2 == 0 --> A(x)"),
      Messages{"3:10: error: expected '-->' while reading the condition of A(x), found 'mod' | the remainder of a "
               "division is written as x % 2"});
  EXPECT_EQ(only("A(x) : x is 2 --> A(x)"),
            Messages{"3:10: error: expected '-->' while reading the condition of A(x), found 'is' | write '=='"});
  EXPECT_EQ(only("A(x) --&gt; A(x)"), Messages{"3:6: error: expected '-->' while reading a production, found '--' | "
                                               "'&gt;' is how web pages write '>': write '-->'"});
  EXPECT_EQ(only("A(x)) --> A(x)"),
            Messages{"3:5: error: expected '-->' while reading a production, found ')' | no '(' is open here"});
  EXPECT_EQ(only("A(x) --> A(x)\nhomomorphism: A(x) --> F"),
            Messages{"4:15: error: expected the end of the line while reading the homomorphism, found 'A' | the "
                     "productions begin on the next line"});
  EXPECT_EQ(only("A(x) --> A(x)\u200B"),
            Messages{"3:14: error: expected a module, ':' or the end of the line while reading the successor of A(x), "
                     "found the character '\u200B', which is not 7-bit ASCII | this is an invisible character, a blank "
                     "of width 0: delete it"});
  EXPECT_EQ(messagesOf(model("A(x) --> A(x)", "\"A(1)\"")),
            Messages{"2:8: warning: the quotation marks are read as modules of the axiom | modules are written without "
                     "quotes"});
  const std::string begin =
      "2:1: error: expected an item or 'Axiom:' while reading the items of the L-system 1, found ";
  EXPECT_EQ(item("seed = 3"), Messages{begin + "'seed' | write ':' in place of '=', as in seed: 3"});
  EXPECT_EQ(item("derivation length = 5"),
            Messages{begin + "'d' | write ':' in place of '=' behind 'derivation length'"});
  EXPECT_EQ(item("DERIVATION LENGTH: 5"), Messages{begin + "'DERIVATION LENGTH' | did you mean 'derivation length:'?"});
  EXPECT_EQ(item("derivation length: 5;"),
            Messages{"2:21: error: expected the end of the line while reading 'derivation length:', found ';' | no ';' "
                     "stands at the end of the line"});
  EXPECT_EQ(messagesOf("#DEFINE r 2\n" + model("A(x) --> A(x)")),
            Messages{"1:1: error: expected a directive after '#', found 'DEFINE' | did you mean '#define'?"});
}

TEST(ForeignLines, LinesAtTheEdgesOfAnLSystemAreNamed) {
  EXPECT_EQ(messagesOf("Lsystem 1\nAxiom: A\nA --> AB\nendlsystem\n"),
            Messages{"1:1: error: expected 'Lsystem:' while reading the model, found 'L' | write a ':' behind "
                     "'Lsystem'"});
  EXPECT_EQ(
      messagesOf("derivation length: 3\nLsystem: 1\nAxiom: A\nA --> A\nendlsystem\n"),
      Messages{"1:1: error: expected 'Lsystem:' while reading the model, found the keyword 'derivation length:' | "
               "this line belongs below the line 'Lsystem: 1'"});
  EXPECT_EQ(messagesOf("Lsystem: 1\nAxiom: A\nA --> A\nend\n"),
            Messages{"4:1: error: expected a production or 'endlsystem' while reading the productions after the axiom, "
                     "found 'end' | did you mean 'endlsystem'?"});
  EXPECT_EQ(messagesOf("\tLsystem: 1\n\tderivation length: 2\n\tAxiom: A\n\tA --> A\n\tendlsystem\n"),
            Messages{"2:1: error: this line starts with a TAB and so continues the label of the L-system | start every "
                     "line in column 1"});
  EXPECT_EQ(messagesOf("#include \xE2\x80\x9C"
                       "a.h\xE2\x80\x9D\n" +
                       model("A(x) --> A(x)")),
            Messages{"1:10: error: expected \"file\" or <file> while reading #include, found '\xE2\x80\x9C"
                     "a.h\xE2\x80\x9D"
                     "' | write the straight quote of the keyboard, '\"'"});
}

}  // namespace
}  // namespace espalier::language::foreign_lines_test
