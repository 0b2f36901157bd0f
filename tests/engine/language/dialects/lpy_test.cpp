#include "engine/language/dialects/lpy.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::lpy_test {
namespace {

// the cpfg text between `Lsystem: 1` and `endlsystem`
std::string bodyOf(const std::string& text) {
  const std::string cpfg = cpfgText(text, {}, "lpy");
  const std::string begin = "Lsystem: 1\nderivation length: 1\n";
  EXPECT_TRUE(cpfg.starts_with(begin)) << cpfg << text;
  return cpfg.substr(std::min(begin.size(), cpfg.size()), cpfg.rfind("endlsystem") - begin.size());
}

// the production of `A(x)` that a block becomes
std::string productionsOf(const std::string& block) {
  const std::string text = bodyOf("Axiom: A(1)\nproduction:\nA(x) :\n" + block);
  const std::string begin = "Axiom: A(1)\n";
  const std::size_t at = text.find(begin);
  return at == std::string::npos ? text : text.substr(at + begin.size());
}

TEST(Lpy, BecomesCpfgText) {
  EXPECT_EQ(cpfgText("N = 5 # steps\nmodule Apex(age), Leaf\nAxiom: Apex(0)\nderivation length: N*2\nproduction:\n"
                     "Apex(t) --> F(1)[+(30)Leaf]Apex(t+1)\nendlsystem\n### saved\n'x' = [\n"),
            "Lsystem: 1\nderivation length: 10\nModule: Apex(...), Leaf(...)\nAxiom: Apex(0)\n"
            "Apex(t) --> F(1)[+(30)Leaf]Apex((t+1))\nendlsystem\n");
}

TEST(Lpy, AModuleMayHaveSeveralNumbersOfParameters) {
  EXPECT_EQ(foreignMessages("module Bud\nAxiom: Bud Bud(1)\nproduction:\nBud --> Bud(2)\nBud(x) --> Bud(x,1)\n"
                            "Bud(x,y) --> *\n"),
            Messages{});
}

TEST(Lpy, ABlockBecomesAProductionForEachWayThroughIt) {
  EXPECT_EQ(productionsOf("  if x < 3:\n    produce F A(x+1)\n  elif x == 3:\n    produce B\n  else:\n    produce *\n"),
            "A(x) : (x<3) --> FA((x+1))\nA(x) : (!(x<3)) && (x==3) --> B\nA(x) : (!(x<3)) && (!(x==3)) --> *\n");
  EXPECT_EQ(productionsOf("  y = x*2\n  y += 1\n  if y > 4: produce A(y)\n"),
            "A(x) : (((x*2)+1)>4) --> A(((x*2)+1))\n");
  EXPECT_EQ(productionsOf("  nproduce F\n  for i in range(3):\n    nproduce [+(i*120)B]\n  produce A(x)\n"),
            "A(x) --> F[+(0)B][+(120)B][+(240)B]A(x)\n");
  EXPECT_EQ(productionsOf("  if x > 1: nproduce F\n  nproduce B\n"), "A(x) : (x>1) --> FB\nA(x) : (!(x>1)) --> B\n");
  // without produce the rule does not apply
  EXPECT_EQ(productionsOf("  if x > 1:\n    pass\n  else:\n    produce B\n"), "A(x) : (!(x>1)) --> B\n");
}

TEST(Lpy, ExpressionsAreThoseOfPython) {
  const auto parameter = [](const std::string& expression) {
    const std::string text = productionsOf("  produce A(" + expression + ")\n");
    return text.substr(text.find("--> A(") + 6, text.size() - text.find("--> A(") - 8);
  };
  EXPECT_EQ(parameter("x**2"), "(x^2)");
  EXPECT_EQ(parameter("-x**2"), "(-(x^2))");
  EXPECT_EQ(parameter("x // 2"), "floor(x/2)");
  EXPECT_EQ(parameter("x % 3"), "mod(x,3)");
  EXPECT_EQ(parameter("-7 % 3"), "2");
  EXPECT_EQ(parameter("7 // 2"), "3");
  EXPECT_EQ(parameter("2 ** 3 ** 2"), "512");
  EXPECT_EQ(parameter("1e-3"), "0.001");
  EXPECT_EQ(parameter("x if x > 1 else 2"), "((x>1) ? x : 2)");
  EXPECT_EQ(parameter("0 < x <= 5"), "((0<x) && (x<=5))");
  EXPECT_EQ(parameter("max(x, 1, 2)"), "max(max(x,1),2)");
  EXPECT_EQ(parameter("sqrt(x)"), "(sqrt(x))");
  EXPECT_EQ(parameter("math.sin(x)"), "(sin(57.295779513082323*x))");
  EXPECT_EQ(parameter("int(2.7)"), "2");
  EXPECT_EQ(parameter("round(2.5)"), "2");
  EXPECT_EQ(parameter("not x and True"), "((!x) && 1)");
}

TEST(Lpy, ContextsConditionsAndConstantsStandInTheHead) {
  EXPECT_EQ(bodyOf("Axiom: A B C\nproduction:\nA < B > C --> D\nignore: +-\n"),
            "ignore: +-\nAxiom: ABC\nA < B > C --> D\n");
  EXPECT_EQ(bodyOf("Axiom: A(1)\nproduction:\nA(x) << B(y) : y > 2 --> C(x)\n"),
            "Axiom: A(1)\nA(x) << B(y) : (y>2) --> C(x)\n");
  EXPECT_EQ(bodyOf("Axiom: A(1)\nproduction:\nA(0) --> B\nA(x if x > 1) --> C\n"),
            "Axiom: A(1)\nA(value1) : (value1==0) --> B\nA(x) : (x>1) --> C\n");
}

TEST(Lpy, NumbersThatTheFunctionsAssignAreVariables) {
  EXPECT_EQ(bodyOf("t = 0\ndt = 0.5\ndef Start():\n  global t\n  t = 1\ndef StartEach():\n  global t\n  t += dt\n"
                   "  if t > 2:\n    t = 2\n  else:\n    pass\ndef EndEach():\n  pass\nAxiom: A(t)\nproduction:\n"
                   "A(x) --> A(x+t)\n"),
            "Start: {t = 0;  t = 1;}\nStartEach: {t = t + 0.5; if ((t>2)) { t = 2; } else { 0; }}\nAxiom: A(t)\n"
            "A(x) --> A((x+t))\n");
}

TEST(Lpy, DecompositionAndInterpretationHaveTheirDepths) {
  EXPECT_EQ(bodyOf("Axiom: A\nproduction:\nA --> B\ndecomposition:\nmaximum depth: 3\nB --> C\ninterpretation:\n"
                   "maximum depth: 2\nC --> F(1,0.1)D\nD --> @O(0.2)\n"),
            "Axiom: A\nA --> B\ndecomposition no warnings\nmaximum depth: 3\nB --> C\nhomomorphism no warnings\n"
            "maximum depth: 2\nC --> #(2*0.1)F(1)D\nD --> @O(2*0.2,0)\n");
}

TEST(Lpy, RadiiAreDiametersInTheDrawingOnly) {
  EXPECT_EQ(bodyOf("Axiom: _(0.1)F(1,0.05)Left(30)@O(2)!(0.2)G\nproduction:\nA --> B\n"),
            "Module: Left(...)\nAxiom: _(0.1)F(1,0.05)Left(30)@O(2)!(0.2)G\nA --> B\nhomomorphism no warnings\n"
            "!(x1) --> #(2*x1)\n@O(x1) --> @O(2*x1,0)\nF(x1,x2) --> #(2*x2)F(x1)\nG --> *\nLeft(x1) --> +(x1)\n"
            "_(x1) --> #(2*x1)\n");
}

TEST(Lpy, SavedNumbersReplaceConstants) {
  EXPECT_NE(cpfgText("Axiom: A(n)\nderivation length: n\nproduction:\nA(x) --> A(x+1)\n\n###### INITIALISATION ######\n"
                     "def __initialiseContext__(context):\n\tscalars = [('n', 'Integer', 7, 1, 20)]\n")
                .find("derivation length: 7\nAxiom: A(7)\n"),
            std::string::npos);
}

TEST(Lpy, RandomDrawsOfABlockAreMadeOnce) {
  EXPECT_EQ(bodyOf("from random import random\nAxiom: A(1)\nproduction:\nA(x) :\n  if random() < 0.5: produce B\n"
                   "  else: produce C\n"),
            "Start: {random1 = 0; }\nAxiom: A(1)\nA(x) : {random1 = ran(1);} (random1<0.5) --> B\n"
            "A(x) : (!(random1<0.5)) --> C\n");
}

TEST(Lpy, WhatNeedsPythonSaysWhichLineAndWhy) {
  const auto first = [](const std::string& text) {
    const Messages messages = foreignMessages(text, {}, "lpy");
    return messages.empty() ? std::string{} : messages.front().substr(0, messages.front().find(" | "));
  };
  const std::string rest = "Axiom: A(1)\nproduction:\n";
  EXPECT_EQ(first("import numpy\n" + rest + "A(x) --> B\n"), "1:1: error: the import of 'numpy' needs Python");
  EXPECT_EQ(first("x = [1, 2]\n" + rest + "A(x) --> B\n"), "1:5: error: a list needs Python");
  EXPECT_EQ(first("def f(x):\n  return x\n" + rest + "A(x) --> B(f(x))\n"),
            "5:12: error: the model's own function 'f' needs Python");
  EXPECT_EQ(first(rest + "A(x) :\n  while x < 3:\n    x += 1\n  produce B\n"), "4:3: error: 'while' needs Python");
  EXPECT_EQ(first(rest + "A(x) :\n  for i in range(x): nproduce B\n"),
            "4:18: error: a loop whose bounds are not constant needs Python");
  EXPECT_EQ(first(rest + "A(x) --> B(x.y)\n"), "3:13: error: a member of an object needs Python");
  EXPECT_EQ(first(rest + "A(x) --> B('a')\n"), "3:12: error: a string needs Python");
  EXPECT_EQ(first(rest + "A(x) --> B(xx)\n"), "3:12: error: unknown name 'xx'");
  EXPECT_EQ(first("class P:\n  pass\n" + rest + "A(x) --> B\n"), "1:1: error: 'class P' needs Python");
  EXPECT_EQ(first("derivation length: 3\nproduction:\nA --> B\n"), "1:1: error: the model has no axiom");
}

TEST(Lpy, AnAxiomMayBeABlock) {
  EXPECT_EQ(bodyOf("n = 2\nAxiom:\n  nproduce A(1)\n  for i in range(n): nproduce [B(i)]\nproduction:\nA(x) --> C\n"),
            "Axiom: A(1)[B(0)][B(1)]\nA(x) --> C\n");
  EXPECT_EQ(bodyOf("Axiom: nproduce A(1)\nproduction:\nA(x) --> C\n"), "Axiom: A(1)\nA(x) --> C\n");
  EXPECT_EQ(bodyOf("Axiom:\n  A(1) B\nproduction:\nA(x) --> C\n"), "Axiom: A(1)B\nA(x) --> C\n");
  const auto first = [](const std::string& block) {
    const std::string message =
        foreignMessages("from random import random\nAxiom:\n" + block + "production:\nA --> B\n", {}, "lpy").front();
    return message.substr(0, message.find(" | "));
  };
  EXPECT_EQ(first("  while 1: nproduce A\n"), "3:3: error: 'while' needs Python");
  EXPECT_EQ(first("  if random() < 0.5: nproduce A\n  else: nproduce B\n"),
            "3:3: error: an axiom that depends on a random number or changes a variable needs Python");
}

TEST(Lpy, WrongIndentationIsAnError) {
  const auto messages = [](const std::string& block) {
    return foreignMessages("Axiom: A(1)\nproduction:\nA(x):\n" + block);
  };
  const std::string column = " | the statements of a block begin in one column";
  EXPECT_EQ(messages("  produce F(x)\n    A(x+1)\n"),
            Messages{"5:5: error: the line is indented deeper than its block" + column});
  EXPECT_EQ(
      messages("  if x > 0:\n  nproduce F\n  produce G\n"),
      Messages{"4:3: error: no line of 'if' is indented deeper than it | its statements stand to the right of it"});
  EXPECT_EQ(messages("    nproduce F\n  produce G\n"),
            Messages{"5:3: error: the line begins between the columns of two blocks" + column});
}

TEST(Lpy, TheLoopsOfABlockHaveOneBound) {
  EXPECT_EQ(foreignMessages("Axiom: A\nproduction:\nA:\n  for i in range(1000):\n    for j in range(1000):\n"
                            "      nproduce F\n"),
            Messages{"5:5: error: the loops of a block repeat more than 100000 times | loops are written out: write a "
                     "rule that counts instead"});
}

TEST(Lpy, AFloorQuotientIsExact) {
  // (-3.5)/0.7 is rounded up to -5, but -5 * 0.7 is above -3.5
  EXPECT_EQ(productionsOf("  produce A((-3.5)//0.7)\n"), "A(x) --> A((-6))\n");
  EXPECT_EQ(productionsOf("  produce A(x//0.7)\n"), "A(x) --> A(floor((x-mod(x,0.7))/0.7+0.5))\n");
  EXPECT_EQ(productionsOf("  produce A(7.5//-2)\n"), "A(x) --> A((-4))\n");
}

TEST(Lpy, MessagesOfTheCompilerNameTheLpyLine) {
  EXPECT_EQ(foreignMessages("Axiom: A\nproduction:\nA --> B\nC --> D\n"),
            Messages{"4:1: warning: 'C' never matches: no axiom or successor makes the module C"});
}

TEST(Lpy, AnAxiomWithoutModulesIsReportedAtItsPlace) {
  EXPECT_EQ(foreignMessages("# my plant\nAxiom: A = 3\nproduction:\nA --> FA\n"),
            Messages{"2:8: error: the axiom has no module | '=' gives a variable its value; a module with a number is "
                     "written as A(3)"});
  EXPECT_EQ(foreignMessages("# my plant\nAxiom: *\nproduction:\nA --> FA\n"),
            Messages{"2:8: error: the axiom has no module | write the first string behind 'Axiom:'"});
}

}  // namespace
}  // namespace espalier::language::lpy_test
