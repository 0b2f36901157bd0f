#include "engine/language/dialects/lparser.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::lparser_test {
namespace {

const char* const kOld = "# a fern\n# of two lines\n5\n25.5 # angle\n12\nF[+(90)A]%\nA=F<c(3)A\n@\nignored = all\n";
const char* const kNew =
    "recursion 5\nangle 25.5\nthickness 12\nmin_thickness 1\nshape 4\nswitch_yz 0\naxiom F[+(90)A]%\nrule A = "
    "F<c(3)A\n";

TEST(Lparser, BothFormsAreOneModel) {
  const std::string text = cpfgText(kOld);
  EXPECT_EQ(text,
            "Lsystem: 1\nderivation length: 5\nAxiom: F[+(90)A]a\nA --> Fbc(3)A\nhomomorphism no warnings\nb --> \\ \n"
            "a --> /(180)\nc(x) --> ;(x+1)\nendlsystem\n");
  EXPECT_EQ(cpfgText(kNew), text);
  EXPECT_EQ(recognised(kOld), "lparser");
  EXPECT_EQ(recognised(kNew), "lparser");
  EXPECT_EQ(foreignMessages(kOld), Messages{});
  EXPECT_EQ(foreignMessages(kNew), Messages{});
}

TEST(Lparser, TheAngleTheWidthAndTheColoursAreSet) {
  const CompileResult result = compileForeign(kOld);
  ASSERT_NE(result.program, nullptr);
  EXPECT_EQ(result.program->view.angleIncrementDegrees, 25.5);
  EXPECT_EQ(result.program->view.initialLineWidth, 0.12);
  EXPECT_EQ(result.program->view.colourEntries.at(2), (files::PaletteColour{220, 40, 40}));
}

TEST(Lparser, EachSymbolOfTheTurtleHasItsDrawing) {
  const auto drawingOf = [](const std::string& symbols) {
    const std::string text = cpfgText("recursion 1\nthickness 5\naxiom X" + symbols + "\nrule X = X\n");
    const std::string mark = "homomorphism no warnings\n";
    const std::size_t begin = text.find(mark);
    return begin == std::string::npos
               ? text
               : text.substr(begin + mark.size(), text.rfind("endlsystem") - begin - mark.size());
  };
  EXPECT_EQ(drawingOf("<>"), "a --> \\ \nb --> /\n");
  EXPECT_EQ(drawingOf("<(30)>(20)"), "a(x) --> \\(x)\nb(x) --> /(x)\n");
  EXPECT_EQ(drawingOf("|"), "| --> |\n");
  EXPECT_EQ(drawingOf("$"), "a --> @v\n");
  EXPECT_EQ(drawingOf("~(10)"), "a(x) --> +(ran(2*x)-x)&(ran(2*x)-x)/(ran(2*x)-x)\n");
  EXPECT_EQ(drawingOf("tt(0.3)"), "t --> @B(0.2)\nt(x) --> @B(x)\n");
  EXPECT_EQ(drawingOf("Zz"), "Z --> F(0.5)\nz --> f(0.5)\n");
  EXPECT_EQ(drawingOf("\"'(2)"), "a --> @Di(1.1)\n'(x) --> @Di(x)\n");
  EXPECT_EQ(drawingOf(";:(2)"), "; --> @A(1.1)\na(x) --> @A(x)\n");
  EXPECT_EQ(drawingOf("?!(0.5)"), "a --> @W(1.4)\n!(x) --> @W(x)\n");
  EXPECT_EQ(drawingOf("c"), "c --> ;\n");
  // names of rules that cpfg's turtle would obey
  EXPECT_EQ(drawingOf("G_,"), "G --> *\n");
}

TEST(Lparser, ErrorsNameItsLinesAndTerms) {
  EXPECT_EQ(foreignMessages("recursion 2\nthickness 3\naxiom F\nrulle A = F\n").front(),
            "4:1: error: unknown word 'rulle' | Did you mean 'rule'? Available: recursion, angle, thickness, "
            "min_thickness, shape, switch_yz, axiom, rule.");
  EXPECT_EQ(
      foreignMessages("recursion 2.5\nthickness 3\naxiom F\n"),
      Messages{"1:11: error: expected a whole number from 0 to 1000000 while reading recursion, found '2.5' | the "
               "lines of an .ls file are: recursion depth, angle, thickness, axiom, rules X=..., @"});
  EXPECT_EQ(foreignMessages("recursion 2\nthickness 3\naxiom F+(x)\n"),
            Messages{"3:8: error: expected one number in parentheses, as in '+(90)' | a symbol has at most one number, "
                     "and no expression"});
  EXPECT_EQ(foreignMessages("recursion 2\nthickness 3\naxiom F\nrule AB=F\n"),
            Messages{"4:6: error: expected a rule such as 'A=F[+A]', found 'AB=F' | a rule is one character, '=' and "
                     "its string"});
  EXPECT_EQ(
      foreignMessages("recursion 2\nthickness 3\naxiom A\nrule A=F\nrule A=FF\n"),
      Messages{"5:6: error: there is a rule for 'A' already | each symbol has one rule in a deterministic L-system"});
  EXPECT_EQ(foreignMessages("recursion 2\nthickness 3\nrule A=F\n").front(),
            "1:1: error: the model has no axiom | write the first string behind the word axiom");
  EXPECT_EQ(
      foreignMessages("3\n90\n10\nF[A\nA=F\n@\n"),
      Messages{"4:2: error: the bracket '[' is never closed in the axiom | a ']' goes back to where the turtle was "
               "at '['"});
}

}  // namespace
}  // namespace espalier::language::lparser_test
