#include "engine/language/checks/module_checks.h"

#include <gtest/gtest.h>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::module_checks_test {
namespace {

Messages messagesOf(const std::string& productions, const std::string& axiom = "A", const std::string& before = {}) {
  core::MemoryFileProvider files(
      {{"m.l", before + "Lsystem: 1\nAxiom: " + axiom + "\n" + productions + "\nendlsystem\n"}});
  CompileInput input;
  input.modelFile = "m.l";
  return briefs(compile(input, files).diagnostics);
}

TEST(ModuleChecks, AQueryThatNobodyAnswers) {
  EXPECT_EQ(
      messagesOf("A --> ?e(0)"),
      Messages{"3:8: warning: nobody answers '?e': its parameters keep their values | did you mean '?E'? The case "
               "of the letter counts"});
  EXPECT_EQ(
      messagesOf("A --> ?K(0)"),
      Messages{"3:8: warning: nobody answers '?K': its parameters keep their values | the turtle fills ?P, ?H, ?L, "
               "?U, ?Q and ?F, the environment ?E and the queries that 'Module:' declares"});
  EXPECT_EQ(messagesOf("A --> ?E(0)?P(0,0)?Q(0)"), Messages{});
}

TEST(ModuleChecks, ADeclaredQueryThatIsNeverMade) {
  EXPECT_EQ(
      messagesOf("A --> F", "A", "Module: ?Light(v)\n"),
      Messages{"1:9: warning: the query ?Light is declared, and no axiom or successor makes it | write ?Light(...) "
               "in a successor, with the '?', or remove the declaration"});
  EXPECT_EQ(messagesOf("A --> ?Light(0)", "A", "Module: ?Light(v)\n"), Messages{});
}

TEST(ModuleChecks, AnUndeclaredQueryIsDeclaredWithItsQuestionMark) {
  EXPECT_EQ(
      messagesOf("A --> ?Light(0)"),
      Messages{"3:8: warning: 'Light' is read as 5 modules: L, i, g, h and t(0) | to make it a name, write a line "
               "before the L-system: 'Module: ?Light(v)'"});
}

TEST(ModuleChecks, AModuleWithAnotherNumberOfParametersIsNotRewritten) {
  EXPECT_EQ(messagesOf("A(x) --> A(x,2)A(x)", "A(1)"),
            Messages{"3:10: warning: no production rewrites 'A(x,2)': the productions of A have 1 parameter | a "
                     "production matches only modules with exactly as many parameters"});
  // the finished form of a module
  EXPECT_EQ(messagesOf("A(x) --> A A(x)", "A(1)"), Messages{});
  // drawn, read by a context, or all of another number: no message or another one
  EXPECT_EQ(messagesOf("F(x) --> F F(x)", "F(1)"), Messages{});
  EXPECT_EQ(messagesOf("A(x) --> A(x,2)A(x)\nA(x,y) < B --> C", "A(1)B"), Messages{});
}

TEST(ModuleChecks, ACommandThatTheTurtleDoesNotKnow) {
  EXPECT_EQ(
      messagesOf("A --> F@z(2)A@M(1,2)@Tx(1)@Gs"),
      Messages{"3:8: warning: the turtle has no command '@z': it interprets the symbols after the '@' on their own "
               "| `espalier reference symbols` lists the commands"});
  EXPECT_EQ(
      messagesOf("A --> F@Tz A"),
      Messages{"3:8: warning: the turtle has no command '@Tz': it interprets the symbols after the '@' on their own "
               "| `espalier reference symbols` lists the commands"});
  // a production makes a command of it
  EXPECT_EQ(messagesOf("A --> @z\nz --> O(2)"), Messages{});
  EXPECT_EQ(messagesOf("A --> @\n@ --> F@"), Messages{});
}

TEST(ModuleChecks, ASuccessorThatGoesOnInColumnOne) {
  EXPECT_EQ(
      messagesOf("A --> A\n[+A]A --> F").front(),
      "4:1: warning: '[+A]A' is the predecessor of a production of its own | to continue the successor of the line "
      "above, begin the line with a TAB");
  EXPECT_EQ(messagesOf("A --> A\n[+A]").front(),
            "4:5: error: expected '-->' while reading a production, found the end of the line | a line that begins in "
            "column 1 is a new production; to continue the successor above, begin the line with a TAB");
}

}  // namespace
}  // namespace espalier::language::module_checks_test
