#include "engine/language/checks/reach_checks.h"

#include <gtest/gtest.h>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::reach_checks_test {
namespace {

const std::string kArities = " | a production matches only modules with exactly as many parameters";
const std::string kBegins = " | productions begin with the modules of the axiom";

Messages messagesOf(const std::string& productions, const std::string& axiom = "A") {
  core::MemoryFileProvider files({{"m.l", "Lsystem: 1\nAxiom: " + axiom + "\n" + productions + "\nendlsystem\n"}});
  CompileInput input;
  input.modelFile = "m.l";
  return briefs(compile(input, files).diagnostics);
}

TEST(ReachChecks, AModuleThatNothingMakes) {
  EXPECT_EQ(messagesOf("A --> F\nB --> A"),
            Messages{"4:1: warning: 'B' never matches: no axiom or successor makes the module B"});
  EXPECT_EQ(messagesOf("A(x,y) --> F", "A(1)"),
            Messages{"3:1: warning: 'A(x,y)' never matches: A is only made with 1 parameter" + kArities});
  EXPECT_EQ(messagesOf("A --> F\nC < F > D --> G", "AD"),
            Messages{"4:1: warning: 'C' never matches: no axiom or successor makes the module C"});
}

TEST(ReachChecks, AModuleThatOnlyItsOwnProductionMakes) {
  EXPECT_EQ(messagesOf("A --> F A", "A(1)"),
            Messages{"3:1: warning: 'A' never matches: A is only made with 1 parameter, except by productions that "
                     "never apply" +
                     kArities});
  EXPECT_EQ(messagesOf("A(x) --> F A(x+1)"),
            Messages{"3:1: warning: 'A(x)' never matches: A is only made with no parameters, except by productions "
                     "that never apply" +
                     kArities});
}

TEST(ReachChecks, OneMessageForModulesThatMakeEachOther) {
  EXPECT_EQ(messagesOf("A --> F\nB --> C\nC --> D\nD --> B"),
            Messages{"4:1: warning: 'B' never matches: only productions that never apply make the module B" + kBegins});
  // what follows from a module that nothing makes, also in front of it
  EXPECT_EQ(messagesOf("A --> F\nD --> F\nC --> D\nB --> C"),
            Messages{"6:1: warning: 'B' never matches: no axiom or successor makes the module B"});
  // a context that no string has
  EXPECT_EQ(messagesOf("A --> F\nG < F --> B\nB --> F"),
            Messages{"4:1: warning: 'G' never matches: no axiom or successor makes the module G"});
}

TEST(ReachChecks, AModuleThatOnlyTheHomomorphismMakes) {
  EXPECT_EQ(messagesOf("A --> F A\nX --> F\nhomomorphism\nA --> X"),
            Messages{"4:1: warning: 'X' never matches: only the homomorphism makes the module X | the homomorphism "
                     "changes what is drawn, not the string that productions see"});
  EXPECT_EQ(messagesOf("A --> F A\nhomomorphism\nA --> X\nX --> F"), Messages{});
}

TEST(ReachChecks, ModulesOfAllAxiomsSubSystemsDecompositionsAndContextsAreReached) {
  EXPECT_EQ(messagesOf("A --> B C\nB < C > D --> E\nE --> F\ndecomposition\nC --> C D\nhomomorphism\nE --> G"),
            Messages{});
  EXPECT_EQ(messagesOf("A --> ?(2)B$\nendlsystem\nLsystem: 2\nAxiom: B\nB --> F"), Messages{});
  // the engine makes the second parameter
  EXPECT_EQ(messagesOf("A --> %(1)F A\n%(p,i) --> G"), Messages{});
}

TEST(ReachChecks, AQueryThatTheAxiomDoesNotMake) {
  EXPECT_EQ(messagesOf("A > ?E(x) : x > 0 --> FA?E(0)\nA > ?E(x) : x == 0 --> F"),
            Messages{"3:5: warning: '?E(x)' never matches: the axiom makes no ?E | write '?E(0)' into the axiom behind "
                     "the module that asks, as in A(1)?E(0)"});
}

TEST(ReachChecks, AProductionThatChangesNothingIsAPlaceholder) {
  EXPECT_EQ(messagesOf("e --> e"), Messages{});
  EXPECT_EQ(messagesOf("e --> e e"),
            Messages{"3:1: warning: 'e' never matches: only productions that never apply make the module e" + kBegins});
}

}  // namespace
}  // namespace espalier::language::reach_checks_test
