#include "engine/language/parse/parser.h"

#include <gtest/gtest.h>

#include "engine/language/format/disassembler.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language::parser_test {
namespace {

const Program& compiled(const CompileResult& result) {
  EXPECT_FALSE(result.diagnostics.hasErrors()) << testing::PrintToString(briefs(result.diagnostics));
  static const Program kEmpty{};
  return result.program != nullptr ? *result.program : kEmpty;
}

// the value that an expression without names is folded to
double valueOf(const std::string& expression, core::Compatibility mode = core::Compatibility::Espalier) {
  const CompileResult result = compileText(model("B --> B", "A(" + expression + ")"), mode);
  EXPECT_TRUE(result.program != nullptr) << expression;
  EXPECT_EQ(result.program->systems[0].axiomExpressions[0].kind, Expression::Kind::Constant) << expression;
  return result.program->systems[0].axiomExpressions[0].constant;
}

// ---- expressions

TEST(Parser, PowerIsLeftAssociativeAndBelowUnaryMinus) {
  EXPECT_EQ(valueOf("2^3^2"), 64.0);
  EXPECT_EQ(valueOf("-2^2"), 4.0);
  EXPECT_EQ(valueOf("2^-1"), 0.5);
}

TEST(Parser, PrecedenceFollowsTheTable) {
  EXPECT_EQ(valueOf("1+2*3-4/2"), 5.0);
  EXPECT_EQ(valueOf("10-3-2"), 5.0);
  EXPECT_EQ(valueOf("7%4*2"), 6.0);
  EXPECT_EQ(valueOf("1<2==1"), 1.0);
  EXPECT_EQ(valueOf("1+1<>2||0"), 0.0);
  EXPECT_EQ(valueOf("!0+1"), 2.0);
  EXPECT_EQ(valueOf("0&&0||1"), 1.0);
  EXPECT_EQ(valueOf("- -3"), 3.0);
}

TEST(Parser, TheConditionalIsRightAssociative) {
  EXPECT_EQ(valueOf("0?1:0?2:3"), 3.0);
  EXPECT_EQ(valueOf("1?0?1:2:3"), 2.0);
}

// ---- structure

TEST(Parser, ReadsAllPartsOfAProduction) {
  const CompileResult result = compileText(
      "Lsystem: 1\nSeed: 3\nAxiom: A(1,2)B(1)C[D]\nB(y) < A(a,b) > C[D=]E(z) : a > 1 --> A(a,y) : 0.5\n"
      "* < CD > * : * --> *\nendlsystem\n");
  const Program& program = compiled(result);
  ASSERT_EQ(program.systems.size(), 1U);
  const std::vector<Production>& productions = program.systems[0].productions.productions;
  ASSERT_EQ(productions.size(), 2U);
  EXPECT_EQ(productions[0].leftContext.size(), 1U);
  ASSERT_EQ(productions[0].rightContext.size(), 6U);
  EXPECT_EQ(productions[0].rightContext[1].kind, ContextElement::Kind::OpenBranch);
  EXPECT_EQ(productions[0].rightContext[3].kind, ContextElement::Kind::SkipToBranchEnd);
  EXPECT_EQ(productions[0].rightContext[4].kind, ContextElement::Kind::CloseBranch);
  EXPECT_TRUE(productions[0].condition.has_value());
  EXPECT_TRUE(productions[0].probability.has_value());
  EXPECT_EQ(productions[0].slotCount, 4);
  EXPECT_EQ(productions[0].text, "B(y) < A(a,b) > C[D=]E(z) : a > 1 --> A(a,y)");
  EXPECT_TRUE(productions[1].leftContext.empty());
  EXPECT_EQ(productions[1].predecessor.size(), 2U);
  EXPECT_FALSE(productions[1].condition.has_value());
  EXPECT_TRUE(productions[1].successor.empty());
}

TEST(Parser, LeftContextsAreStoredNearestFirst) {
  const CompileResult result = compileText(model("XY < A(n) --> A(n)"));
  const Production& production = compiled(result).systems[0].productions.productions[0];
  ASSERT_EQ(production.leftContext.size(), 2U);
  EXPECT_EQ(result.program->nameOf(production.leftContext[0].module.type), "Y");
}

TEST(Parser, NewContextsSurroundTheOthers) {
  const CompileResult result = compileText(model("P << L < A(n) > R >> S --> *"));
  const Production& production = compiled(result).systems[0].productions.productions[0];
  EXPECT_EQ(production.newLeftContext.size(), 1U);
  EXPECT_EQ(production.leftContext.size(), 1U);
  EXPECT_EQ(production.rightContext.size(), 1U);
  EXPECT_EQ(production.newRightContext.size(), 1U);
}

TEST(Parser, ReadsAllItems) {
  const CompileResult result = compileText(
      "lsystem: main\nRing Lsystem\nseed: 7\nderivation length: 2*3\nignore: +-\nDefine: { array w[2][3] = {1,2}, "
      "v[4]; external e, "
      "f; }\nStart:\n{ a = 1; }\nStart Each: { a = 2; }\nEndEach: {\na = 3;\n}\nEnd: {a = 4;}\nAxiom: "
      "A(w[0][1],v[0],e,f)\nA --> "
      "B\ndecomposition no warnings\nmaximum depth: 4\nB --> C\nHomomorphism:\nseed: 5\nC -o> D\nEndlsystem\nLsystem: "
      "2\nAxiom: "
      "X\nX --> Y\nendlsystem\n");
  const Program& program = compiled(result);
  ASSERT_EQ(program.systems.size(), 2U);
  const LSystem& system = program.systems[0];
  EXPECT_EQ(system.name, "main");
  EXPECT_EQ(system.label, 0);
  EXPECT_EQ(program.systems[1].label, 2);
  EXPECT_TRUE(system.isRing);
  EXPECT_EQ(system.seed, 7);
  EXPECT_TRUE(system.isStochastic);
  EXPECT_EQ(program.derivationLength, 6U);
  ASSERT_EQ(system.arrays.size(), 2U);
  EXPECT_EQ(system.arrays[0].dimensions, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(system.arrays[0].initial, (std::vector<double>{1, 2, 0, 0, 0, 0}));
  EXPECT_EQ(system.arrays[1].firstElement, 6U);
  EXPECT_EQ(system.arrayElementCount, 10U);
  EXPECT_EQ(system.variables, (std::vector<std::string>{"e", "f", "a"}));
  EXPECT_EQ(system.externals, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_FALSE(system.start.empty() || system.startEach.empty() || system.endEach.empty() || system.end.empty());
  EXPECT_EQ(system.decomposition.maximumDepth, 4U);
  EXPECT_FALSE(system.decomposition.warnsAtDepth);
  EXPECT_TRUE(system.homomorphism.warnsAtDepth);
  EXPECT_EQ(system.homomorphism.maximumDepth, 1U);
  EXPECT_EQ(system.homomorphismSeed, 5.0);
}

TEST(Parser, ACommentOverLinesEndsTheProduction) {
  const std::string hint = " | a comment over several lines ends a production or item: write it on one line, or above";
  EXPECT_EQ(
      messagesOf(model("A(n) --> B /* one\ntwo */ [C]")),
      Messages{"4:8: error: expected a production while reading the productions after the axiom, found '['" + hint});
  EXPECT_EQ(
      messagesOf(model("A(n) : n > 0 /* one\ntwo\nthree */\n  --> B\nC > /* one\n*/ D --> E\nF -->")),
      (Messages{"3:20: error: expected '-->' while reading the condition of A(n), found the end of the line" + hint,
                "7:11: error: expected a context after '>' while reading a production, found the end of the "
                "line" +
                    hint,
                "9:6: error: expected a module or '*' while reading the successor of F, found the end of the "
                "line | '*' is the empty successor"}));
  EXPECT_EQ(messagesOf("Lsystem: 1\nseed: /* one\ntwo */ 5\nAxiom: A\nA --> A\nendlsystem\n"),
            Messages{"2:13: error: expected an expression while reading 'seed:', found the end of the line" + hint});
  EXPECT_EQ(
      messagesOf("Syntax: free\n" + model("A(n) --> B /* one\ntwo */[C]")),
      Messages{"5:7: error: expected a production while reading the productions after the axiom, found '['" + hint});
  // the comment may hold the rest of the file
  EXPECT_EQ(messagesOf("Lsystem: 1\nAxiom: A\nA --> B( /* one\ntwo\n\nthree\n")[0].substr(0, 20),
            "3:10: error: expecte");
  // where nothing is wrong the comment is none of the parser's business
  EXPECT_EQ(messagesOf(model("A(n) --> A(n) /* one\ntwo */\nB /* one */ --> B")), Messages{});
}

// ---- additions

TEST(Parser, DeclaredModulesHaveNamesAndArities) {
  const CompileResult result = compileText(
      "Module: Apex(age, vigor), Node, ?Light(flux)\nLsystem: 1\nAxiom: Apex(1,2)NodeN?Light(0)\nApex(a,v) --> "
      "Node\nendlsystem\n");
  const Program& program = compiled(result);
  EXPECT_EQ(program.systems[0].axiom.size(), 5U);
  EXPECT_NE(program.findType("Apex", 2), core::kNoModuleType);
  EXPECT_TRUE(program.hasQueries);
  const Symbol& light = program.symbols[program.symbolOf[program.findType("Light", 1)]];
  EXPECT_TRUE(light.isQuery);
  EXPECT_EQ(light.parameterNames, std::vector<std::string>{"flux"});
}

TEST(Parser, AWrongCountOfADeclaredModuleIsAnError) {
  EXPECT_EQ(
      messagesOf("Module: Apex(age, vigor)\nLsystem: 1\nAxiom: Apex(1)\nApex --> Apex(1,2)\nendlsystem\n"),
      (Messages{
          "3:8: error: expected 2 parameters of the module 'Apex' while reading the axiom, found 1 | it is declared as "
          "Apex(age, vigor)",
          "4:1: error: expected 2 parameters of the module 'Apex' while reading a production, found 0 | it is declared "
          "as Apex(age, vigor)"}));
}

TEST(Parser, WrongDeclarationsAreErrors) {
  EXPECT_EQ(
      messagesOf("Module: A(x), A(x)\nModule: 3\nModule: B()\nModule: C(1)\nSyntax: loose\n" + model("B --> B")),
      (Messages{
          "1:15: error: the module 'A' is declared twice",
          "2:9: error: expected the name of a module while reading 'Module:', found the number 3 | write 'Module: "
          "Apex(age, vigor), Leaf(size)'",
          "3:11: error: expected a parameter name while reading 'Module:', found ')' | a module without parameters has "
          "no parentheses",
          "4:11: error: expected a parameter name while reading 'Module:', found the number 1",
          "5:9: error: expected 'free' or 'tab' while reading 'Syntax:', found 'loose'"}));
}

TEST(Parser, FreeSyntaxNeedsNoTabs) {
  const CompileResult result = compileText(
      "Syntax: free\nLsystem: 1\nAxiom: A\n  B\nA -->\n  F[\n+A\n  ](2,\n3)\n\n  C; B --> *; F --> F\nendlsystem\n");
  const Program& program = compiled(result);
  EXPECT_EQ(program.systems[0].axiom.size(), 2U);
  ASSERT_EQ(program.systems[0].productions.productions.size(), 3U);
  EXPECT_EQ(program.systems[0].productions.productions[0].text, "A --> F[ +A ](2, 3) C");
}

// ---- mistakes: every one is found, with its place

TEST(Parser, MistakesInExpressions) {
  EXPECT_EQ(messagesOf(model(
                "A(n) --> B(n+)\nA(n) --> B(1e5)\nA(n) --> B(n,,n)\nA(n) --> B((n)\nA(n) --> B(n n)\nA(n) --> "
                "B(sin())\nA(n) --> B(w[1,2])\nA(n) --> B()\nA(n) : n ? 1 --> B\nA(n) --> B(if)\nA(n) --> B(n $ 2)")),
            (Messages{"3:14: error: expected an expression while reading the successor of A(n), found ')'",
                      "4:12: error: expected an expression while reading the successor of A(n), found '1e5' | an "
                      "exponent needs a decimal "
                      "point before it: write 1.0e5",
                      "5:14: error: expected an expression while reading the successor of A(n), found ','",
                      "6:15: error: expected ',' or ')' while reading the successor of A(n), found the end of the line "
                      "| a ')' for 'B((n)' is "
                      "missing",
                      "7:14: error: expected ',' or ')' while reading the successor of A(n), found 'n' | a ')' for "
                      "'B(n' is missing, "
                      "or an operator or a comma before this",
                      "8:16: error: expected an argument of 'sin' while reading the successor of A(n), found ')' | "
                      "every function needs an argument, sometimes only a dummy: sin(0)",
                      "9:15: error: expected ']' while reading the successor of A(n), found ',' | every dimension has "
                      "its own brackets: "
                      "w[i][j]",
                      "10:12: error: expected an expression while reading the successor of A(n), found ')' | a module "
                      "without parameters "
                      "has no parentheses",
                      "11:14: error: expected ':' while reading the condition of A(n), found '-->'",
                      "12:12: error: expected an expression while reading the successor of A(n), found 'if'",
                      "13:16: error: expected ',' or ')' while reading the successor of A(n), found the number 2 | '$' "
                      "before it is "
                      "skipped: remove it"}));
}

TEST(Parser, MistakesInHeads) {
  EXPECT_EQ(
      messagesOf(
          model("A(2) --> B\nA(n --> B\n* --> B\nA < > B --> C\n< A --> B\nA > B < C --> D\nA * < B --> C\nA > = --> "
                "C\nA(n) B\nA() --> B\nA(n) -> B(n)\n > A --> B\nA(n) => B")),
      (Messages{
          "3:3: error: expected a parameter name while reading a production, found the number 2 | "
          "parameters of predecessors and contexts are names; compare values in the condition, as in A(x) : x == 1",
          "4:5: error: expected ',' or ')' while reading a production, found '-->' | parameters of predecessors and "
          "contexts are names, separated by commas: A(x, y)",
          "5:1: error: expected a predecessor while reading a production, found '*' | there is no wildcard "
          "predecessor; '*' stands "
          "for a whole context, condition or successor",
          "6:5: error: expected a predecessor while reading a production, found '>'",
          "7:1: error: expected a context before '<' while reading a production, found '<'",
          "8:7: error: expected '-->' while reading a production, found '<' | the order is: newLeft << "
          "left < predecessor > right "
          ">> newRight",
          "9:3: error: '*' stands for a whole left context, not for one module | there is no wildcard for "
          "a single module",
          "10:5: error: '=' must be followed by another module in a right context | '=' goes to the end of "
          "the branch: write '=]'",
          "11:7: error: expected '-->' while reading a production, found the end of the line | a production is "
          "written as A --> AB",
          "12:3: error: expected a parameter name while reading a production, found ')' | a module without "
          "parameters has no "
          "parentheses",
          "13:6: error: expected '-->' while reading a production, found '->' | the arrow of a production "
          "has two strokes",
          "14:2: error: expected a predecessor while reading a production, found '>'",
          "15:6: error: expected '-->' while reading a production, found '=>' | the arrow of a production "
          "has two strokes"}));
}

TEST(Parser, MistakesInBodies) {
  EXPECT_EQ(
      messagesOf(model(
          "A(n) : --> B\nA(n) : {} * --> B\nA(n) : { n = 1 } * --> B\nA(n) : {n=1;} --> B\nA(n) --> \nA(n) --> B * "
          "C\nA(n) --> * B\nA(n) --> B < C\nA(n) --> B : \nA(n) --> Bwarnings\nA(n) : n B --> C\nA(n) --> ä")),
      (Messages{
          "3:8: error: expected a condition while reading the condition of A(n), found '-->' | write '*' for the "
          "condition that is "
          "always true",
          "4:9: error: expected a statement while reading a block of A(n), found '}' | an empty block is not allowed; "
          "remove it",
          "5:16: error: expected ';' while reading a block of A(n), found '}' | every statement ends with ';'",
          "6:15: error: expected a condition while reading the condition of A(n), found '-->' | write '*' for the "
          "condition that is "
          "always true",
          "7:10: error: expected a module or '*' while reading the successor of A(n), found the end of the line | '*' "
          "is the empty "
          "successor",
          "8:12: error: expected a module, ':' or the end of the line while reading the successor of A(n), found '*' | "
          "'*' alone is "
          "the empty successor",
          "9:12: error: expected the end of the line while reading the successor of A(n), found 'B'",
          "10:12: error: expected a module, ':' or the end of the line while reading the successor of A(n), found '<' "
          "| "
          "a condition stands before the arrow, as in A(x) : x > 1 --> B",
          "11:14: error: expected an expression while reading the probability of A(n), found the end of the line",
          "12:11: error: expected a module, ':' or the end of the line while reading the successor of A(n), found the "
          "keyword "
          "'warnings' | these letters are a keyword everywhere; put blanks between them to write symbols",
          "13:10: error: expected '-->' while reading the condition of A(n), found 'B'",
          "14:10: error: expected a module or '*' while reading the successor of A(n), found the character 'ä', which "
          "is not 7-bit "
          "ASCII | models are written in 7-bit ASCII; other characters may stand in comments and strings only"}));
}

TEST(Parser, MistakesInBlocks) {
  EXPECT_EQ(
      messagesOf("Lsystem: 1\nStart: { a = ; b = 2 c = 3; if a { b = 1; } 3 = a; while (a > 0) b = 1; else { a = 1; }\n"
                 "do { a = 1; } until (a); if (a) { b = 1; } else if (b) { a = 1; } d = 1; }\nAxiom: A\nA --> "
                 "B\nendlsystem\n"),
      (Messages{
          "2:14: error: expected an expression while reading Start, found ';'",
          "2:22: error: expected ';' while reading Start, found 'c'",
          "2:32: error: expected '(' after 'if' while reading Start, found 'a' | put the condition in parentheses: if "
          "(n > 1) "
          "{ ... }",
          "2:47: error: expected ';' while reading Start, found '=' | only a variable or an array element can stand "
          "before '='",
          "2:66: error: expected '{' while reading Start, found 'b' | braces are needed also around one statement: "
          "while (...) { ... }",
          "2:73: error: expected an expression while reading Start, found 'else'",
          "3:15: error: expected 'while' while reading Start, found 'until' | a loop that starts with 'do' ends with "
          "'while (condition);'",
          "3:49: error: expected '{' while reading Start, found 'if' | braces are needed also around one statement: "
          "else { if (...) { ... } }"}));
}

TEST(Parser, StatementsWithoutBracesAreOneMistake) {
  const auto start = [](const std::string& statements) {
    return messagesOf("Lsystem: 1\nStart: { x = 1; " + statements + " }\nAxiom: A\nA --> A\nendlsystem\n");
  };
  const std::string head = "error: expected '{' while reading Start, found ";
  const std::string hint = " | braces are needed also around one statement: ";
  const std::string both = hint + "if (...) { ... } else { ... }";
  EXPECT_EQ(start("if (x) x = 1; else x = 2; x = 3;"), Messages{"2:24: " + head + "'x'" + both});
  EXPECT_EQ(start("if (x) { x = 1; } else x = 2;"), Messages{"2:40: " + head + "'x'" + hint + "else { ... }"});
  EXPECT_EQ(start("if (x) if (x) x = 1; else if (x) { x = 2; } else x = 3;"),
            Messages{"2:24: " + head + "'if'" + both});
  EXPECT_EQ(start("while (x) x = 0;"), Messages{"2:27: " + head + "'x'" + hint + "while (...) { ... }"});
  EXPECT_EQ(start("do x = 0; while (x);"), Messages{"2:20: " + head + "'x'" + hint + "do { ... } while (...);"});
  // each of two statements has its message, and so has a mistake in one
  EXPECT_EQ(start("if (x) x = 1; if (x) x = ;"),
            (Messages{"2:24: " + head + "'x'" + both, "2:38: " + head + "'x'" + both,
                      "2:42: error: expected an expression while reading Start, found ';'"}));
  EXPECT_EQ(start("if (x) { if (x) x = 1; else x = 2; } else x = 3;"),
            (Messages{"2:33: " + head + "'x'" + both, "2:59: " + head + "'x'" + hint + "else { ... }"}));
}

TEST(Parser, InitialValuesWithInnerBracesAreOneMistake) {
  EXPECT_EQ(messagesOf("Lsystem: 1\nDefine: { array a[2][2] = {{1,2},{3,{4}}}, b[2] = {5,6}; array c[1]; }\nAxiom: "
                       "A(a[0][1]+b[1]+c[0])\nA(x) --> A(x)\nendlsystem\n"),
            Messages{"2:28: error: expected an expression while reading 'define:', found '{' | all values stand in one "
                     "list, row after row: array a[2][2] = {1, 2, 3, 4};"});
  // another mistake among the values does not hide the array
  EXPECT_EQ(messagesOf("Lsystem: 1\nDefine: { array a[2] = {1,}; }\nAxiom: A(a[0])\nA(x) --> A(x)\nendlsystem\n"),
            Messages{"2:27: error: expected an expression while reading 'define:', found '}'"});
}

TEST(Parser, AnUnexpectedCommaBetweenDigitsIsADecimalComma) {
  EXPECT_EQ(messagesOf("Lsystem: 1\nseed: 12,50\nAxiom: A(1)\nA(x) : x > 0,5 --> A((0,25))\nendlsystem\n"),
            (Messages{"2:9: error: expected the end of the line while reading 'seed:', found ',' | write 12.50 with a "
                      "point",
                      "4:13: error: expected '-->' while reading the condition of A(x), found ',' | write 0.5 with a "
                      "point"}));
  EXPECT_EQ(messagesOf(model("A(x) --> A((x,5))")),
            Messages{"3:14: error: expected ')' while reading the successor of A(x), found ','"});
}

TEST(Parser, AnOpenBlockEndsAtTheNextKeyword) {
  EXPECT_EQ(
      messagesOf("Lsystem: 1\nStart: { a = 1;\nAxiom: A\nA --> B(\nendlsystem\n"),
      (Messages{"3:1: error: expected '}' while reading Start, found the keyword 'Axiom:' | the block is not closed",
                "4:9: error: expected an expression while reading the successor of A, found the end of the line"}));
}

TEST(Parser, AnIndentedProductionMayHaveItsArrowOnTheNextLine) {
  EXPECT_EQ(messagesOf(model("  A(n) : n < 3\n\t--> A(n + 1)\n  A(n) : {n = 4;\n} n < 3\n\t--> A(n)")), Messages{});
}

TEST(Parser, MistakesOfLinesWithBlanksForTabs) {
  const std::string hint =
      " | a continuation line must start with a TAB, not with blanks (or write 'Syntax: free' before "
      "the first "
      "L-system)";
  EXPECT_EQ(
      messagesOf(model("A(n) -->\n    F(1)\n    [+A(n)]\nB --> C\n    [+B]\nC --> D")),
      (Messages{
          "3:9: error: expected a module or '*' while reading the successor of A(n), found the end of the line" + hint,
          "7:5: error: expected a production while reading the productions after the axiom, found '['" + hint}));
}

TEST(Parser, MistakesInItems) {
  EXPECT_EQ(
      messagesOf(
          "Lsystem: 1\nderivation Length: 3\nseed:\nRing Lsystem x\nignore: +\xC3\xA4\ndefine: { int x; }\ndefine: { "
          "array "
          "w; }\ndefine: { array w[2; }\ndefine: { external 3; }\nStart: a = 1;\nmaximum depth: 3\nAxiom: A\nA --> "
          "B\nignore: +\nendlsystem\n"),
      (Messages{"2:1: error: expected an item or 'Axiom:' while reading the items of the L-system 1, found 'derivation "
                "Length' | did you mean 'derivation "
                "length:'?",
                "3:6: error: expected an expression while reading 'seed:', found the end of the line",
                "4:14: error: expected the end of the line while reading 'Ring Lsystem', found 'x'",
                "5:10: error: expected a symbol while reading 'ignore:', found the character '\xC3\xA4', which is not "
                "7-bit ASCII | models "
                "are written in 7-bit ASCII; other characters may stand in comments and strings only",
                "6:11: error: expected 'array' or 'external' while reading 'define:', found 'int' | plain variables "
                "need no definition; "
                "assign them in Start",
                "7:18: error: expected '[' while reading 'define:', found ';' | an array has a size: 'array w[5];'",
                "8:20: error: expected ']' while reading 'define:', found ';'",
                "9:20: error: expected the name of a variable while reading 'define:', found the number 3",
                "10:8: error: expected '{' while reading Start, found 'a'",
                "11:1: error: expected an item or 'Axiom:' while reading the items of the L-system 1, found the "
                "keyword 'maximum depth:' | "
                "this keyword belongs to a decomposition or homomorphism",
                "14:1: error: expected a production while reading the productions after the axiom, found the keyword "
                "'ignore:' | this "
                "keyword must stand before the axiom"}));
}

TEST(Parser, MistakesInTheFrame) {
  EXPECT_EQ(messagesOf(""),
            Messages{"1:1: error: expected 'Lsystem:' while reading the model, found the end of the file | a model "
                     "starts with 'Lsystem: 1' and ends with 'endlsystem'"});
  EXPECT_EQ(
      messagesOf("Axiom: A\nA --> B\n"),
      Messages{
          "1:1: error: expected 'Lsystem:' while reading the model, found the keyword 'Axiom:' | every L-system starts "
          "with 'Lsystem:' and a label, and ends with 'endlsystem'. In the notation of textbooks write 'axiom: F' and "
          "'F -> F+F'"});
  EXPECT_EQ(
      messagesOf("Lsystem:\nAxiom:\nendlsystem\n"),
      (Messages{
          "1:9: error: expected a label while reading the label of an L-system, found the end of the line | write "
          "'Lsystem: 1'",
          "2:7: error: expected a module while reading the axiom, found the end of the line"}));
  EXPECT_EQ(
      messagesOf("Lsystem: 1\nAxiom: A\nA --> B\n"),
      Messages{
          "4:1: error: expected 'endlsystem' while reading the L-system 1, found the end of the file | every L-system "
          "ends with a line 'endlsystem'"});
  EXPECT_EQ(messagesOf("Lsystem: 1\nA --> B\nendlsystem\n"),
            (Messages{"2:1: error: expected 'Axiom:' while reading the items of the L-system 1, found 'A' | every "
                      "L-system has an axiom "
                      "before its productions, the string it starts from: 'Axiom: A(1)'"}));
}

TEST(Parser, MistakesOfSections) {
  EXPECT_EQ(messagesOf("Lsystem: 1\nAxiom: A\nAxiom: B\nA --> B\nhomomorphism\nA --> B\ndecomposition x\nA --> "
                       "B\nhomomorphism\nC --> D\nendlsystem\n"),
            (Messages{"3:1: error: expected a production while reading the productions after the axiom, found the "
                      "keyword 'Axiom:' | "
                      "an L-system has one axiom",
                      "7:1: error: the decomposition must stand before the homomorphism",
                      "7:15: error: expected the end of the line while reading the decomposition, found 'x' | the "
                      "productions begin on the next line",
                      "9:1: error: the homomorphism appears twice in one L-system | put its productions together"}));
  EXPECT_EQ(
      messagesOf("Lsystem: 1\nStart: {a = 1;}\nStart: {a = 1;}\nAxiom: A\nA --> B\ndecomposition\nhomomorphism\nA --> "
                 "B\nendlsystem\n"),
      (Messages{"3:8: error: Start appears twice in one L-system | put the statements together"}));
  // an empty section counts, too
  EXPECT_EQ(messagesOf("Lsystem: 1\nAxiom: A\nA --> B\ndecomposition\ndecomposition\nendlsystem\n"),
            (Messages{"5:1: error: the decomposition appears twice in one L-system | put its productions together"}));
}

TEST(Parser, ProductionListsMayBeEmpty) {
  for (const char* text : {"Lsystem: 1\nAxiom: A\n\nendlsystem\n", "Lsystem: 1\nAxiom: A\nendlsystem\n",
                           "Lsystem: 1\nAxiom: A\nhomomorphism\nendlsystem\n",
                           "Lsystem: 1\nAxiom: A\n/* none */\ndecomposition: no warnings\n   \nhomomorphism\n// "
                           "none\nendlsystem\n",
                           "Lsystem: 1\nAxiom: A\ndecomposition\nmaximum depth: 2\nhomomorphism\nmaximum depth: "
                           "3\nseed: 5\nendlsystem",
                           "Lsystem: 1\nAxiom: ?(2)A$\n#define X 1\nendlsystem\nLsystem: 2\nAxiom: "
                           "B\n\ndecomposition\n\nhomomorphism\n\nendlsystem\n",
                           "Syntax: free\nLsystem: 1\nAxiom: A;\nhomomorphism;\nendlsystem\n"}) {
    for (const core::Compatibility mode :
         {core::Compatibility::Espalier, core::Compatibility::Cpfg, core::Compatibility::CpfgBatch}) {
      const CompileResult result = compileText(text, mode);
      EXPECT_NE(result.program, nullptr) << text;
      EXPECT_TRUE(result.diagnostics.entries().empty()) << text << messagesOf(text).front();
    }
  }
}

TEST(Parser, ExpressionsSkipCharactersThatBeginNoToken) {
  const Messages found = messagesOf(
      "Lsystem: 1\nderivation length: \\2\nAxiom: A(~1)\nA($x) : x @ < #3 && | x . > 0 {y = `_ \\x'; y = y;} --> "
      "\\~|A(_x + 1) : 0.5 #\nendlsystem\n");
  EXPECT_EQ(
      found,
      (Messages{"2:20: warning: the character '\\' has no meaning in expressions and is skipped | remove it",
                "3:10: warning: the character '~' has no meaning in expressions and is skipped | remove it",
                "4:3: warning: the character '$' has no meaning in expressions and is skipped | remove it",
                "4:11: warning: the character '@' has no meaning in expressions and is skipped | remove it",
                "4:15: warning: the character '#' has no meaning in expressions and is skipped | remove it",
                "4:21: warning: the character '|' has no meaning in expressions and is skipped | write '||' for 'or'",
                "4:25: warning: the character '.' has no meaning in expressions and is skipped | remove it",
                "4:36: warning: the characters '`_' have no meaning in expressions and are skipped | remove them",
                "4:39: warning: the character '\\' has no meaning in expressions and is skipped | remove it",
                "4:41: warning: the character ''' has no meaning in expressions and is skipped | remove it",
                "4:61: warning: the character '_' has no meaning in expressions and is skipped | a name begins with a "
                "letter",
                "4:75: warning: the character '#' has no meaning in expressions and is skipped | remove it",
                "4:58: warning: the surface '~|' is not defined and is not drawn | write 'surface: | FILE.s' into the "
                "view file, which has the model's name and the suffix .v"}));
}

TEST(Parser, TokensInTheWrongPlaceStayErrors) {
  for (const char* expression : {"x & 1", "x \" 1", "x } 1", "1e5", "x ? 1", "x = 1"}) {
    EXPECT_EQ(compileText("Lsystem: 1\nAxiom: A(1)\nA(x) --> A(" + std::string(expression) + ")\nendlsystem\n").program,
              nullptr)
        << expression;
  }
}

TEST(Parser, AtMostFiftyErrorsAreKept) {
  std::string productions;
  for (int i = 0; i < 80; ++i) {
    productions += "A(n) --> B(\n";
  }
  const CompileResult result = compileText(model(productions));
  EXPECT_EQ(result.diagnostics.entries().size(), 50U);
  EXPECT_EQ(result.diagnostics.errorCount(), 80U);
}

// ---- limits

TEST(Parser, NestingEndsAtALimit) {
  core::Limits limits;
  limits.maximumExpressionDepth = 5;
  const std::string message =
      "error: the expression is nested deeper than the limit expressionDepth (5) | assign parts of it "
      "to variables first";
  EXPECT_EQ(messagesOf(model("A(n) --> B((((((n))))))"), core::Compatibility::Espalier, limits),
            Messages{"3:17: " + message});
  EXPECT_EQ(messagesOf(model("A(n) --> B(------n)"), core::Compatibility::Espalier, limits),
            Messages{"3:17: " + message});
  EXPECT_EQ(messagesOf(model("A(n) --> B(n^(n*(n+(n==(n&&n)))))"), core::Compatibility::Espalier, limits),
            Messages{"3:12: " + message});
  EXPECT_EQ(messagesOf(model("A(n) : {if(n){if(n){if(n){if(n){if(n){n=1;}}}}}} * --> B"), core::Compatibility::Espalier,
                       limits)[0],
            "3:39: error: blocks are nested deeper than the limit expressionDepth (5)");
}

// the sum of `count` equal terms
std::string sumOf(const std::string& term, int count) {
  std::string sum = term;
  for (int i = 1; i < count; ++i) {
    sum += "+" + term;
  }
  return sum;
}

TEST(Parser, AChainOfOperatorsIsNotNested) {
  const int count = 20'000;
  const CompileResult sum = compileText(model("A(n) : " + sumOf("n", count) + " --> A(" + sumOf("n", count) + ")"));
  ASSERT_NE(sum.program, nullptr);
  EXPECT_EQ(sum.program->maximumStack, 2U);
  const CompileResult constant = compileText(model("A(n) --> A(" + sumOf("1", count) + ")"));
  ASSERT_NE(constant.program, nullptr);
  EXPECT_EQ(constant.program->systems[0].productions.productions[0].expressions[0].constant, count);
  EXPECT_NE(compileText("Lsystem: 1\nseed: " + sumOf("2*3", count) + "\nStart: {x = " + sumOf("(1-Q)", count) +
                        ";}\nAxiom: A\nA --> A\nendlsystem\n")
                .program,
            nullptr);
  core::Limits limits;
  limits.maximumExpressionDepth = 5;
  EXPECT_EQ(
      messagesOf(model("A(n) --> B(" + sumOf("n", 251) + ")\nB(n) --> A(n)"), core::Compatibility::Espalier, limits),
      Messages{});
  EXPECT_EQ(messagesOf(model("A(n) --> B(" + sumOf("n", 252) + ")"), core::Compatibility::Espalier, limits),
            Messages{"3:12: error: the expression has more than 250 operators in a row, 50 for each level of the limit "
                     "expressionDepth (5) | assign parts of it to variables first"});
}

TEST(Parser, AModelDeclaresAsManyModulesAsHaveNumbers) {
  const auto declaring = [](std::size_t count) {
    std::string text = "Module: N0";
    for (std::size_t i = 1; i < count; ++i) {
      text += ",N" + std::to_string(i);
    }
    return text + "\n" + model("A --> N" + std::to_string(count - 1) + "N1N", "AN10");
  };
  const CompileResult result = compileText(declaring(kMostDeclaredNames));
  ASSERT_NE(result.program, nullptr);
  const auto& axiom = result.program->systems[0].axiom;
  ASSERT_EQ(axiom.size(), 2U);
  EXPECT_EQ(result.program->nameOf(axiom[1].type), "N10");
  const auto& successor = result.program->systems[0].productions.productions[0].successor;
  ASSERT_EQ(successor.size(), 3U);
  EXPECT_EQ(result.program->nameOf(successor[0].type), "N" + std::to_string(kMostDeclaredNames - 1));
  EXPECT_EQ(result.program->nameOf(successor[2].type), "N");
  const Messages messages = messagesOf(declaring(kMostDeclaredNames + 1));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0].ends_with("error: the model declares more than 65407 modules")) << messages[0];
}

TEST(Parser, AModuleWithTooManyParametersEndsAtALimit) {
  core::Limits limits;
  limits.maximumArity = 2;
  EXPECT_EQ(messagesOf(model("A(n) --> B(n,n,n)"), core::Compatibility::Espalier, limits),
            Messages{"3:10: error: the module 'B' has 3 parameters, more than the limit arity (2)"});
}

TEST(Parser, WarningsOfASectionStandOnItsLine) {
  EXPECT_EQ(
      messagesOf(model("A(n) --> A(n)\ndecomposition\nno warnings\nB --> C")),
      Messages{"5:1: error: expected a production while reading the decomposition, found the keyword 'no warnings' "
               "| it stands behind 'decomposition' or 'homomorphism', on the same line"});
}

}  // namespace
}  // namespace espalier::language::parser_test
