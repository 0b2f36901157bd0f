#include "engine/language/dialects/fractint.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::fractint_test {
namespace {

std::string entry(const std::string& lines) {
  return "Koch { ; a remark with { and }\n" + lines + "}\n";
}

TEST(Fractint, BecomesCpfgTextInCapitals) {
  EXPECT_EQ(cpfgText(entry("  angle 6\n  axiom f--f ; remark\n  f=f+f\n")),
            "Lsystem: 1\nderivation length: 2\nAxiom: F--F\nF --> F+F\nendlsystem\n");
}

TEST(Fractint, StartsAlongXAndTurnsByAPartOfTheCircle) {
  const CompileResult result = compileForeign(entry("angle 6\naxiom f\n"));
  ASSERT_NE(result.program, nullptr);
  EXPECT_EQ(result.program->view.angleIncrementDegrees, 60.0);
  EXPECT_EQ(result.program->view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
}

TEST(Fractint, RulesOfOneCharacterAreJoined) {
  EXPECT_NE(cpfgText(entry("angle 6\naxiom f\nf=f+\nf=f\n")).find("\nF --> F+F\n"), std::string::npos);
  EXPECT_NE(cpfgText(entry("angle 6\naxiom f\nf=\n")).find("\nF --> *\n"), std::string::npos);
}

TEST(Fractint, NumbersBecomeParameters) {
  const std::string text = cpfgText(entry("angle 6\naxiom @.5f@i2f@q9f@iq4f\\30d/15m/45\n"));
  EXPECT_NE(text.find("Axiom: @(0.5)F@(0.5)F@(3)F@(0.5)F\\(30)D/(15)M/(45)\n"), std::string::npos) << text;
  EXPECT_NE(text.find("@(x) --> @Di(x)\n"), std::string::npos);
  const std::string degrees = cpfgText(entry("angle 6\naxiom \\30d/15m\n"));
  EXPECT_NE(degrees.find("D --> F\nM --> f\n\\(x) --> +(x)\n/(x) --> -(x)\n"), std::string::npos) << degrees;
}

TEST(Fractint, ColoursAreThoseOfTheScreen) {
  const CompileResult result = compileForeign(entry("angle 6\naxiom C4F<2F>FG\n"));
  ASSERT_NE(result.program, nullptr);
  EXPECT_NE(result.program->sources.front().text.find("Axiom: C(4)F;(2)F,FG\n"), std::string::npos);
  EXPECT_NE(result.program->sources.front().text.find("C(x) --> ;(x)\n"), std::string::npos);
  EXPECT_NE(result.program->sources.front().text.find("G --> f\n"), std::string::npos);
  EXPECT_EQ(result.program->view.initialColour, 15);
  EXPECT_EQ(result.program->view.colourEntries.at(4), (files::PaletteColour{168, 0, 0}));
  EXPECT_NE(result.program->sources.front().text.find("; --> @C(1)\n;(x) --> @C(x)\n, --> @C(-1)\n,(x) --> @C(-x)\n"),
            std::string::npos);
  EXPECT_EQ(result.program->view.colourEntries.at(0), (files::PaletteColour{0, 0, 0}));
}

TEST(Fractint, TurnsRoundByWholePartsAndExchangesLeftAndRight) {
  EXPECT_NE(cpfgText(entry("angle 8\naxiom f|f!f\n")).find("| --> +(180)\n! --> /(180)\n"), std::string::npos);
  // an odd number of parts: towards '-', whatever '!' has exchanged
  EXPECT_NE(cpfgText(entry("angle 5\naxiom f|f\n")).find("| --> -(144)\n"), std::string::npos);
  EXPECT_NE(cpfgText(entry("angle 5\naxiom f!|f\n")).find("| --> @Z(-144)\n"), std::string::npos);
}

TEST(Fractint, ErrorsNameItsLinesAndTerms) {
  const auto messages = [](const std::string& lines) { return foreignMessages(entry(lines)); };
  EXPECT_EQ(messages("angle 6\nf=ff\n"),
            Messages{"1:1: error: the entry 'Koch' has no Axiom | write the first string behind the word Axiom"});
  EXPECT_EQ(messages("axiom f\n"),
            Messages{"1:1: error: the entry 'Koch' has no Angle | 'Angle 6' makes + and - turn by 360/6 degrees"});
  EXPECT_EQ(
      messages("angle -6\naxiom f\n"),
      Messages{
          "2:7: error: expected a whole number from 3 to 1000000 while reading Angle, found '-6' | + and - turn by 360 "
          "degrees divided by it"});
  EXPECT_EQ(
      messages("angle 6\naxiom f[+f\n"),
      Messages{"3:8: error: the bracket '[' is never closed in the Axiom | a ']' goes back to where the turtle was "
               "at '['"});
  EXPECT_EQ(messages("angle 6\naxiom f\nff=f\n"),
            Messages{"4:1: error: expected one character before '=', found 'ff' | a rule is one character, '=' and its "
                     "string"});
  EXPECT_EQ(messages("angle 6\naxiom f\n@=f\n"),
            Messages{"4:1: error: the character '@' cannot be rewritten | give the rule a letter"});
  EXPECT_EQ(
      messages("angle 6\naxiom f@i0f\n"),
      Messages{"3:8: error: the number behind '@' is not finite | I is the inverse of the number behind it: write "
               "one that is not 0"});
  EXPECT_EQ(messages("angel 6\nangle 6\naxiom f\n"),
            Messages{"2:1: error: expected Angle, Axiom or a rule X=..., found 'angel 6' | did you mean 'angle'?"});
  EXPECT_EQ(messages("angle 6\naxiom\n"),
            Messages{"3:1: error: the Axiom is empty | write the first string behind it"});
  EXPECT_EQ(foreignMessages("Koch { ; open\nangle 6\naxiom f\n"),
            Messages{"1:1: error: the entry 'Koch' has no '}' | an entry is NAME { Angle N, Axiom STRING and rules "
                     "X=STRING, one a line }"});
}

TEST(Fractint, AnyCharacterIsASymbol) {
  // signs that cpfg cannot use become small letters, in the order of their appearance
  EXPECT_EQ(cpfgText(entry("angle 4\naxiom f(4)\",\n\"=f\nf=f*\xC3\xA4\n")),
            "Lsystem: 1\nderivation length: 2\nAxiom: Fa4bcd\nc --> F\nF --> Feh\nendlsystem\n");
  EXPECT_EQ(foreignMessages(entry("angle 4\naxiom f\\f/f@f+d\n")), Messages{});
  EXPECT_NE(cpfgText(entry("angle 4\naxiom f\\f/d@f\n")).find("Axiom: F\\(0)F/(0)D@(1)F\n"), std::string::npos);
}

TEST(Fractint, ABlockWithoutANameIsARemark) {
  const std::string text = "{ a remark\nangle 3\n}\nTree\n{\nangle 4\naxiom f\n}\ncomment { x }\n";
  EXPECT_EQ(foreignMessages(text), Messages{});
  EXPECT_NE(cpfgText(text, "Tree").find("Axiom: F\n"), std::string::npos);
}

TEST(Fractint, APolygonBehindAnArrowIsNoEntry) {
  EXPECT_FALSE(recognisesFractint("axiom: F\nF -> F{+F.\nangle: 60\n"));
  EXPECT_FALSE(recognisesFractint("axiom = F\nF → {F\nangle = 60\n"));
}

TEST(Fractint, ThePaletteIsTheScreensDefault) {
  const CompileResult result = compileForeign(entry("angle 6\naxiom <f\n"));
  ASSERT_NE(result.program, nullptr);
  const auto colour = [&](int index) { return result.program->view.colourEntries.at(index); };
  EXPECT_EQ(colour(17), (files::PaletteColour{20, 20, 20}));
  EXPECT_EQ(colour(32), (files::PaletteColour{0, 0, 252}));   // aae
  EXPECT_EQ(colour(33), (files::PaletteColour{64, 0, 252}));  // bae
  EXPECT_EQ(colour(55), (files::PaletteColour{0, 64, 252}));  // abe
  EXPECT_EQ(colour(56), (files::PaletteColour{124, 124, 252}));
  EXPECT_EQ(colour(247), (files::PaletteColour{44, 48, 64}));  // abe of the last run
  EXPECT_EQ(colour(255), (files::PaletteColour{0, 0, 0}));
}

TEST(Fractint, AMegabyteOfWrongCharactersIsReportedQuickly) {
  // each of the errors is at the end of a long line; a quadratic reader would need minutes
  std::string line = "f=";
  for (int i = 0; i < 200'000; ++i) {
    line += "]F]f]";
  }
  const CompileResult result = compileForeign(entry("angle 6\naxiom f\n" + line + "\n"));
  EXPECT_EQ(result.diagnostics.errorCount(), core::DiagnosticList::kLimit);
  EXPECT_LE(core::formatDiagnostic(result.diagnostics.entries().front()).size(), 800U);
}

TEST(Fractint, DegreesTurnTheHeadingOfDAndMOnly) {
  // F and G do not see them, D and M do not see + - |
  const std::string parts = cpfgText(entry("angle 6\naxiom f\\30/20+g\n"));
  EXPECT_NE(parts.find("\\(x) --> *\n/(x) --> *\n"), std::string::npos) << parts;
  EXPECT_EQ(parts.find("+ --> *"), std::string::npos);
  const std::string degrees = cpfgText(entry("angle 6\naxiom d\\30+|-m\n"));
  EXPECT_NE(degrees.find("\\(x) --> +(x)\n+ --> *\n- --> *\n"), std::string::npos) << degrees;
  EXPECT_NE(degrees.find("| --> *\n"), std::string::npos) << degrees;
  EXPECT_EQ(foreignMessages(entry("angle 6\naxiom f\\30/20+g\n")), Messages{});
  EXPECT_EQ(foreignMessages(entry("angle 6\naxiom d\\30+|-m\n")), Messages{});
}

TEST(Fractint, FAndGTurnApartFromDAndM) {
  const std::string text = cpfgText(entry("angle 6\naxiom f+\\30d/15m|!g\n"));
  // the other heading is the turtle's other orientation
  EXPECT_NE(text.find("G --> f\nD --> @XF@X\nM --> @Xf@X\n\\(x) --> @X+(x)@X\n/(x) --> @X-(x)@X\n| --> +(180)\n"
                      "! --> /(180)@X/(180)@X\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("+ --> "), std::string::npos);
  EXPECT_EQ(foreignMessages(entry("angle 6\naxiom f+\\30d\n")), Messages{});
}

}  // namespace
}  // namespace espalier::language::fractint_test
