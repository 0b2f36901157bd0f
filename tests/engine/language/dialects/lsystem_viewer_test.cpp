#include "engine/language/dialects/lsystem_viewer.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::lsystem_viewer_test {
namespace {

TEST(LsystemViewer, BecomesCpfgTextWithTheStepOfEachGeneration) {
  EXPECT_EQ(cpfgText("generations 4\nscale 1/4\nstep 150\nangle 60\naxiom F--F\nprule F -> F+F\n"),
            "Lsystem: 1\nderivation length: 4\nAxiom: F--F\nF --> F+F\nhomomorphism no warnings\nF --> F(150*0.25^Q)\n"
            "f --> f(150*0.25^Q)\nendlsystem\n");
}

TEST(LsystemViewer, AcceptsEveryPunctuation) {
  const std::string plain = cpfgText("generations 2\nangle 60\naxiom F\nprule F -> F+F\n");
  EXPECT_EQ(cpfgText("generations: 2\nangle: 60°\naxiom: F\nprule: F → F+F\n"), plain);
  EXPECT_EQ(cpfgText("generations = 2\nangle = 60\naxiom = F\nprule = F = F+F\n"), plain);
  EXPECT_EQ(cpfgText("# a remark\nGENERATIONS 2\nangle 120/2\naxiom F\nprule F --> F + F\n"), plain);
  const std::string coloured = "generations 2\nangle 60\naxiom F\nprule F --> F+F\ncolor #ff0000\n";
  EXPECT_NE(foreignMessages(coloured).front().find("unknown color '#ff0000'"), std::string::npos);
}

TEST(LsystemViewer, RemarksMayStandBehindACommand) {
  const std::string plain = cpfgText("generations 2\nangle 60\naxiom F\nprule F -> F+F\nprule ; -> F\n");
  ASSERT_FALSE(plain.empty());
  EXPECT_EQ(cpfgText("generations 2 # two\nangle 60 //degrees\naxiom F // start\nprule F -> F+F ; rule\n"
                     "prule ; -> F # a sign\n; all\n"),
            plain);
  // without blanks on both sides they are symbols
  EXPECT_NE(cpfgText("axiom F;F/F//F\nstep 1\n").find("Axiom: F;F/ F/ / F\n"), std::string::npos);
}

TEST(LsystemViewer, HasTheStatedDefaults) {
  const CompileResult result = compileForeign("axiom F\nstep 2\n");
  ASSERT_NE(result.program, nullptr);
  const files::ViewSettings& view = result.program->view;
  EXPECT_EQ(view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
  EXPECT_EQ(view.initialPosition, core::Vec3{});
  EXPECT_EQ(view.colourEntries.at(view.initialColour), (files::PaletteColour{255, 0, 0}));
  EXPECT_EQ(result.program->derivationLength, 0U);
}

TEST(LsystemViewer, SetsColourHeadingAndOrigin) {
  const CompileResult result = compileForeign("axiom F\nstep 2\ncolor DarkBlue\nheading 180\norigin (3, -1/2)\n");
  ASSERT_NE(result.program, nullptr);
  const files::ViewSettings& view = result.program->view;
  EXPECT_EQ(view.colourEntries.at(view.initialColour), (files::PaletteColour{0, 0, 139}));
  EXPECT_EQ(view.initialHeading, (core::Vec3{-1.0, 0.0, 0.0}));
  EXPECT_EQ(view.initialPosition, (core::Vec3{3.0, -0.5, 0.0}));
}

TEST(LsystemViewer, OtherSymbolsOfTheTurtleDrawNothing) {
  EXPECT_NE(cpfgText("axiom FG&\nstep 1\n").find("& --> *\nG --> *\n"), std::string::npos);
}

TEST(LsystemViewer, ErrorsNameItsLinesAndTerms) {
  const auto messages = [](const std::string& lines) { return foreignMessages(lines); };
  EXPECT_EQ(messages("generations 2\nangle 60\nprule F -> FF\n"),
            Messages{"1:1: error: the model has no axiom | write the first string behind the word axiom"});
  EXPECT_EQ(messages("generations -2\naxiom F\n"), Messages{"1:13: error: expected a whole number from 0 to 1000000 "
                                                            "while reading 'generations', found '-2' | it says how "
                                                            "often the axiom is rewritten"});
  EXPECT_EQ(messages("generations 2\naxiom F\ncolor blu\n"),
            Messages{"3:7: error: unknown color 'blu' | Did you mean 'blue'? Available: red, blue, green, lightblue, "
                     "darkgreen, gold, yellow, darkblue, darkred, gray, lightgreen, orange, purple."});
  EXPECT_EQ(
      messages("generations 2\naxiom F[F\n"),
      Messages{"2:8: error: the bracket '[' is never closed in the axiom | a ']' goes back to where the turtle was "
               "at '['"});
  EXPECT_EQ(
      messages("generations 2\naxiom F\nprule F F+F\n"),
      Messages{"3:1: error: expected a rule such as 'F -> F+F' while reading 'prule' | one symbol, '->' (or '→' or "
               "'='), and its successor"});
  EXPECT_EQ(
      messages("generations 2\naxiom F\nprule F -> F\nprule F -> FF\n"),
      Messages{"4:7: error: there is a rule for 'F' already | each symbol has one rule in a deterministic L-system"});
  EXPECT_EQ(messages("generations 2\naxiom F+F\n"),
            Messages{"1:1: error: the model turns with + or - and has no angle | 'angle 60' turns by 60 degrees"});
  EXPECT_EQ(messages("generations 2\naxiom F\nscale 0\n"),
            Messages{"3:7: error: expected a number above 0 while reading 'scale', found '0' | the step length of the "
                     "next generation is multiplied by it"});
  EXPECT_EQ(
      messages("generations 2\naxiom F\nstep long\n"),
      Messages{"3:6: error: expected a number while reading 'step', found 'long' | write it with a point, or as a "
               "fraction such as 1/3"});
  EXPECT_EQ(messages("generations 2\naxiom F\norigin 3\n"),
            Messages{"3:8: error: expected a point while reading 'origin', found '3' | write it as (x, y)"});
  EXPECT_EQ(messages("generations 2\ngenerations 3\naxiom F\n"),
            Messages{"2:1: error: 'generations' is given twice | leave one of the lines"});
  EXPECT_EQ(messages("generations 2\naxiom F:F\n"),
            Messages{"2:8: error: the character ':' cannot be a symbol here | use a letter instead"});
  EXPECT_EQ(messages("generations 2\naxiom\n"),
            Messages{"2:1: error: 'axiom' has no value | write it behind the command"});
}

}  // namespace
}  // namespace espalier::language::lsystem_viewer_test
