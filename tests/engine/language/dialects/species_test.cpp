#include "engine/language/dialects/species.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::species_test {
namespace {

std::string species(const std::string& lines) {
  return "Espécie 6\nVariáveis: F\nConstantes: +, -, [, ]\nAxioma: F\nRegras: F -> F[+F]F,\n  F -> F[-F]F\n" + lines;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Species, OneRuleIsDrawnForTheWholeStringInEachGeneration) {
  EXPECT_EQ(cpfgText(species("")),
            "Lsystem: 1\nderivation length: 4\nStart: { step = 1; angle = 25; generations = 4; }\n"
            "StartEach: { ruleF = floor(ran(2)); }\nAxiom: F\nF : ruleF == 0 --> F[+F]F\nF : ruleF == 1 --> F[-F]F\n"
            "homomorphism no warnings\nF --> F(step)\n+ --> -(angle)\n- --> +(angle)\nendlsystem\n");
}

TEST(Species, OrOneForEachModule) {
  const std::string text = cpfgText(species("Sorteio: módulo\n"));
  EXPECT_TRUE(contains(text, "\nF --> F[+F]F : 1\nF --> F[-F]F : 1\n")) << text;
  EXPECT_FALSE(contains(text, "StartEach"));
}

TEST(Species, RangesAreDrawnForEachTree) {
  const std::string text = cpfgText(species("Passo: 4..8\nÂngulo: 20..30\nGerações: 4..6\n"));
  EXPECT_TRUE(contains(text, "derivation length: 6\n"));
  EXPECT_TRUE(contains(text, "Start: { step = 4 + ran(4); angle = 20 + ran(10); generations = 4 + floor(ran(3)); }\n"));
  EXPECT_TRUE(contains(text, "EndEach: { if (Q >= generations) { stop(2); } }\n"));
}

TEST(Species, ATurnAboutTheAxisMayComeWithEachBranch) {
  // by a macro that --define overrides
  EXPECT_TRUE(contains(cpfgText(species("Giro: 30\n")), "\n#define GIRO 30\n"));
  EXPECT_TRUE(contains(cpfgText(species("Giro: 30\n")), "[ --> [/(GIRO)\n"));
  EXPECT_FALSE(contains(cpfgText(species("Giro: 0\n")), "[ -->"));
}

TEST(Species, LabelsMayLackAccentsAndHaveAnyCase) {
  const std::string plain = cpfgText(species("Ângulo: 20.5..30.5\nSorteio: módulo\n"));
  EXPECT_EQ(cpfgText("ESPECIE 6\nvariaveis: F\nCONSTANTES: +, -, [, ]\naxioma: F\nRegras: F -> F[+F]F,\n  F -> F[-F]F\n"
                     "angulo: 20,5..30,5\nsorteio: modulo\n"),
            plain);
  // an accent of its own
  EXPECT_EQ(cpfgText(species("A\u0302ngulo: 20.5..30.5\nSorteio: mo\u0301dulo\n")), plain);
}

TEST(Species, TheSecondOfEqualNamesHasANumber) {
  const std::string text = "Espécie A\nAxioma: F\nRegras: F -> FF\nEspécie A\nAxioma: G\nRegras: G -> GG\n";
  ASSERT_EQ(speciesEntries(text).size(), 2U);
  EXPECT_EQ(speciesEntries(text)[1].name, "A-2");
  EXPECT_TRUE(contains(cpfgText(text, "A"), "\nF --> FF\nhomomorphism"));
  EXPECT_TRUE(contains(cpfgText(text, "A-2"), "Axiom: G\nG --> GG\n"));
}

TEST(Species, LabelsMayBeEnglish) {
  EXPECT_EQ(cpfgText("Species 6\nVariables: F\nConstants: +, -, [, ]\nAxiom: F\nRules: F -> F[+F]F, F -> F[-F]F\n"),
            cpfgText(species("")));
}

TEST(Species, ALineMayHoldSeveralLabels) {
  const std::string line = "Espécie 6 Variáveis: F Constantes: +, -, [, ] Axioma: F Regras: F -> F[+F]F, F -> F[-F]F\n";
  EXPECT_EQ(cpfgText(line), cpfgText(species("")));
  // several species, a line or some lines for each
  const std::string table = "Espécie 1: Axioma: F\tRegras: F -> FF Passo: 2\n" + line + "Giro: 30\n";
  ASSERT_EQ(speciesEntries(table).size(), 2U);
  EXPECT_EQ(speciesEntries(table)[0].name, "1");
  EXPECT_EQ(speciesEntries(table)[1].name, "6");
  EXPECT_EQ(cpfgText(table, "6"), cpfgText(species("Giro: 30\n")));
  EXPECT_TRUE(contains(cpfgText(table, "1"), "step = 2;"));
  // a remark is left out as a whole
  EXPECT_EQ(cpfgText(species("# Passo: 2 Giro: 30\n")), cpfgText(species("")));
}

TEST(Species, RulesThatCannotBeReachedAreReadAsTheAxioms) {
  const std::string text = "Espécie 4\nVariáveis: F, X\nAxioma: X\nRegras: F -> F[+X][-X]FX, F -> FF\n";
  EXPECT_TRUE(contains(cpfgText(text), "\nX --> F[+X][-X]FX\nF --> FF\n"));
  EXPECT_EQ(foreignMessages(text),
            Messages{"3:9: warning: no rule rewrites the axiom X: the rules that contain it are read "
                     "as its own | write 'X -> ...' for them"});
  EXPECT_EQ(
      foreignMessages("Espécie 4\nAxioma: X\nRegras: F -> FF\n"),
      Messages{"3:9: warning: 'F' never matches: only productions that never apply make the module F | productions "
               "begin with the modules of the axiom"});
}

TEST(Species, ErrorsNameItsLinesAndTerms) {
  EXPECT_EQ(foreignMessages("Espécie 1\nRegras: F -> FF\n"),
            Messages{"1:1: error: the species has no axiom | write 'Axioma: F'"});
  EXPECT_EQ(foreignMessages("Espécie 1\nAxioma: F\nRegras:\n"),
            Messages{"1:1: error: the species has no rules | write 'Regras: F -> F[+F]F'"});
  EXPECT_EQ(foreignMessages(species("Gerações: -4\n")),
            Messages{"7:13: error: expected a range from 0 to 1000, found '-4' | write it as 4 or 4..6"});
  EXPECT_EQ(foreignMessages(species("Gerações: 1.5\n")),
            Messages{"7:13: error: a number of generations is a whole number | write it as 4 or 4..6"});
  EXPECT_EQ(
      foreignMessages(species("Sorteio: dado\n")),
      Messages{
          "7:10: error: expected how rules are drawn, found 'dado' | 'geração' (generation): one rule for the whole "
          "string; 'módulo' (module): one for each module"});
  EXPECT_EQ(foreignMessages(species(", FF\n")),
            Messages{"7:3: error: expected a rule such as 'F -> F[+F]F', found 'FF' | one variable, '->' and its "
                     "successor; rules are separated by commas"});
  EXPECT_EQ(
      foreignMessages("Espécie 1\nAxioma: F\nRegras: F -> F[F\n"),
      Messages{"3:15: error: the bracket '[' is never closed in the rule | a ']' goes back to where the turtle was at "
               "'['"});
  EXPECT_EQ(
      foreignMessages("Espécie 1\nAxioma: F\nRegras: F -> F*F\n"),
      Messages{"3:15: error: the character '*' is not a symbol of a species | symbols are letters, digits, + - [ ]"});
  EXPECT_EQ(foreignMessages(species("Espécie 7\nPaso: 4\nAxioma: F\nRegras: F -> F\n"), "7").front().substr(0, 59),
            "8:1: error: expected a label of a species, found 'Paso' | D");
  EXPECT_EQ(foreignMessages("Espécie 1\nVariáveis: F, Y\nAxioma: F\nRegras: F -> FF\n"),
            Messages{"1:1: warning: the variable Y is not used | leave it out"});
}

}  // namespace
}  // namespace espalier::language::species_test
