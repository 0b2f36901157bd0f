#include "engine/language/compiler.h"

#include <gtest/gtest.h>

#include "engine/language/format/disassembler.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language::compiler_test {
namespace {

using core::Compatibility;

std::shared_ptr<const Program> programOf(const std::string& text, Compatibility mode = Compatibility::Espalier) {
  const CompileResult result = compileText(text, mode);
  EXPECT_TRUE(result.program != nullptr) << (result.diagnostics.entries().empty()
                                                 ? ""
                                                 : brief(result.diagnostics.entries()[0]));
  return result.program;
}

const Production& onlyProduction(const std::shared_ptr<const Program>& program) {
  return program->systems[0].productions.productions[0];
}

// the instructions of a production's condition, one a line, without their indices
std::string conditionCode(const std::string& condition, Compatibility mode) {
  const auto program = programOf(model("A(n) : " + condition + " --> B"), mode);
  const std::string text = disassemble(*program);
  const std::size_t begin = text.find('\n', text.find("  condition")) + 1;
  std::string result;
  for (std::size_t i = begin; i < text.find("  module B"); i = text.find('\n', i) + 1) {
    result += text.substr(i + 8, text.find('\n', i) + 1 - i - 8);
  }
  return result;
}

// ---- code

TEST(Compiler, GoldenDisassembly) {
  EXPECT_EQ(disassemble(*programOf(
                "Lsystem: 1\nderivation length: 3\nDefine: { array w[2]; }\nStart: {k = 0; printf(\"k %g\\n\", k);}\n"
                "Axiom: A(1)B\nA(l) : {i = 0; while (i < 2) {w[i] = l; i = i + 1;} } l > Q --> F(l)[+(2*15)A(l / 2)]\n"
                "B --> B : 1\nendlsystem\n")),
            "L-system 1\n"
            "  start\n"
            "     0  Constant 0\n"
            "     1  StoreVariable 0 k\n"
            "     2  LoadVariable 0 k\n"
            "     3  Print \"k %g\\n\" 1\n"
            "     4  Pop\n"
            "axiom\n"
            "  module A\n"
            "    parameter 0 = 1\n"
            "  module B\n"
            "production 0: A(l) : {i = 0; while (i < 2) {w[i] = l; i = i + 1;} } l > Q --> F(l)[+(2*15)A(l / 2)]\n"
            "  block before\n"
            "     5  Constant 0\n"
            "     6  StoreStatic 0 i\n"
            "     7  LoadStatic 0 i\n"
            "     8  Constant 2\n"
            "     9  Less\n"
            "    10  JumpIfZero 19\n"
            "    11  LoadStatic 0 i\n"
            "    12  LoadSlot 0\n"
            "    13  StoreElement w 1\n"
            "    14  LoadStatic 0 i\n"
            "    15  Constant 1\n"
            "    16  Add\n"
            "    17  StoreStatic 0 i\n"
            "    18  Jump 7\n"
            "  condition\n"
            "    19  LoadSlot 0\n"
            "    20  LoadStep\n"
            "    21  Greater\n"
            "  module F\n"
            "    parameter 0 = slot 0\n"
            "  module [\n"
            "  module +\n"
            "    parameter 0 = 30\n"
            "  module A\n"
            "    parameter 0\n"
            "    22  LoadSlot 0\n"
            "    23  Constant 2\n"
            "    24  Divide\n"
            "  module ]\n"
            "production 1: B --> B\n"
            "  module B\n"
            "  probability = 1\n");
}

TEST(Compiler, LogicalOperatorsSkipInEspaliersModeWhenItMatters) {
  EXPECT_EQ(conditionCode("n && ran(1)", Compatibility::Espalier),
            "LoadSlot 0\nJumpIfZero 6\nConstant 1\nCall ran 1\nToBoolean\nJump 7\nConstant 0\n");
  EXPECT_EQ(conditionCode("n || ran(1)", Compatibility::Espalier),
            "LoadSlot 0\nJumpIfNonZero 6\nConstant 1\nCall ran 1\nToBoolean\nJump 7\nConstant 1\n");
  EXPECT_EQ(conditionCode("n > 1 && n < 3", Compatibility::Espalier),
            "LoadSlot 0\nConstant 1\nGreater\nLoadSlot 0\nConstant 3\nLess\nLogicalAnd\n");
  EXPECT_EQ(conditionCode("n && 1/n", Compatibility::Espalier),
            "LoadSlot 0\nJumpIfZero 7\nConstant 1\nLoadSlot 0\nDivide\nToBoolean\nJump 8\nConstant 0\n");
}

TEST(Compiler, LogicalOperatorsSkipInTheReferenceOnlyAfterACompoundSide) {
  EXPECT_EQ(conditionCode("n && ran(1)", Compatibility::Cpfg), "LoadSlot 0\nConstant 1\nCall ran 1\nLogicalAnd\n");
  EXPECT_EQ(conditionCode("(n) || ran(1)", Compatibility::Cpfg), "LoadSlot 0\nConstant 1\nCall ran 1\nLogicalOr\n");
  EXPECT_EQ(conditionCode("!n && ran(1)", Compatibility::Cpfg),
            "LoadSlot 0\nNot\nJumpIfZero 7\nConstant 1\nCall ran 1\nToBoolean\nJump 8\nConstant 0\n");
  EXPECT_EQ(conditionCode("n*1 || 0", Compatibility::Cpfg),
            "LoadSlot 0\nConstant 1\nMultiply\nJumpIfOrSkips 6\nConstant 0\nLogicalOr\n");
}

TEST(Compiler, ConditionalsSkipOneSide) {
  EXPECT_EQ(conditionCode("n ? 1 : 2", Compatibility::Espalier), "LoadSlot 0\nConstant 1\nConstant 2\nSelect\n");
  EXPECT_EQ(conditionCode("n ? ran(1) : 2", Compatibility::Espalier),
            "LoadSlot 0\nJumpIfZero 5\nConstant 1\nCall ran 1\nJump 6\nConstant 2\n");
  EXPECT_EQ(conditionCode("n ? ran(1) : 2", Compatibility::Cpfg),
            "LoadSlot 0\nConstant 1\nCall ran 1\nConstant 2\nSelect\n");
  // a bare first value does not keep the reference from evaluating the second
  EXPECT_EQ(
      conditionCode("!n ? 2 : ran(1)", Compatibility::Cpfg),
      "LoadSlot 0\nNot\nJumpIfZero 8\nConstant 2\nConstant 1\nCall ran 1\nPop\nJump 10\nConstant 1\nCall ran 1\n");
}

TEST(Compiler, OnlyPureConstantsAreFolded) {
  const auto kindOf = [](const std::string& expression) {
    return onlyProduction(programOf(model("A(n) --> B(" + expression + ")"))).expressions[0].kind;
  };
  EXPECT_EQ(kindOf("sin(30) * 2 ^ 3"), Expression::Kind::Constant);
  EXPECT_EQ(kindOf("1 / 0"), Expression::Kind::Code);
  EXPECT_EQ(kindOf("1 % 0"), Expression::Kind::Code);
  EXPECT_EQ(kindOf("log(0)"), Expression::Kind::Code);
  EXPECT_EQ(kindOf("ran(1)"), Expression::Kind::Code);
  EXPECT_EQ(kindOf("n"), Expression::Kind::Slot);
  EXPECT_EQ(kindOf("n + 0"), Expression::Kind::Code);
}

TEST(Compiler, FoldingOrFollowsTheMode) {
  const auto valueOf = [](Compatibility mode) {
    return onlyProduction(programOf(model("A(n) --> B((2*3) || 0)"), mode)).expressions[0].constant;
  };
  EXPECT_EQ(valueOf(Compatibility::Espalier), 1.0);
  EXPECT_EQ(valueOf(Compatibility::Cpfg), 6.0);
}

TEST(Compiler, AFileThatIsWrittenAndReadIsBoth) {
  core::MemoryFileProvider files;
  files.add("m.l",
            "Lsystem: 1\nStart: {f = fopen(\"log\", \"w\"); f = fopen(\"log\", \"r\"); "
            "g = fopen(\"data\", \"r\"); g = fopen(\"data\", \"w\");}\nAxiom: A\nA --> A\nendlsystem\n");
  CompileInput input;
  input.modelFile = "m.l";
  const auto program = compile(input, files).program;
  ASSERT_NE(program, nullptr);
  ASSERT_EQ(program->files.size(), 2U);
  for (const auto& file : program->files) {
    EXPECT_TRUE(file.isRead && file.isWritten) << file.name;
  }
}

TEST(Compiler, ReadsTheFilesThatTheModelWillRead) {
  core::MemoryFileProvider files({{"folder/m.l",
                                   "Lsystem: 1\nStart: {f = fopen(\"data.txt\", \"r\"); g = fopen(\"./data.txt\", "
                                   "\"r\"); h = fopen(\"log\", \"w\");\n"
                                   "k = fopen(\"none\", \"r\"); o = fopen(\"m.l\", \"w\"); u = fopen(\"../up\", "
                                   "\"r\");}\nAxiom: A\nA --> A\nendlsystem\n"},
                                  {"folder/data.txt", "1 2 3"},
                                  {"folder/log", "old"},
                                  {"up", "secret"}});
  CompileInput input;
  input.modelFile = "folder/m.l";
  const auto program = compile(input, files).program;
  ASSERT_NE(program, nullptr);
  ASSERT_EQ(program->files.size(), 5U);
  EXPECT_EQ(program->files[0].name, "data.txt");
  ASSERT_EQ(program->sources.size(), 2U);
  EXPECT_EQ(program->sources[program->files[0].source].text, "1 2 3");
  EXPECT_EQ(program->files[1].source, ModelFile::kNoSource);  // only written
  EXPECT_EQ(program->files[2].source, ModelFile::kNoSource);  // not there
  EXPECT_TRUE(program->files[3].isRefused);                   // its own text
  EXPECT_TRUE(program->files[4].isRefused);                   // outside
  EXPECT_NE(disassemble(*program).find("FileOpen \"log\" \"w\""), std::string::npos);
}

TEST(Compiler, FscanfAssignsOnlyTheNumbersThatItRead) {
  const std::string code =
      disassemble(*programOf("Lsystem: 1\nStart: {f = 0; fscanf(f, \"%g\", &x);}\nAxiom: A\nA --> A\nendlsystem\n"));
  EXPECT_NE(
      code.find("     3  FileScan \"%g\" 1\n     4  StoreStatic 0 (numbers read)\n     5  StoreStatic 1 (number read)\n"
                "     6  LoadStatic 0 (numbers read)\n     7  Constant 1\n     8  GreaterEqual\n     9  JumpIfZero 12\n"
                "    10  LoadStatic 1 (number read)\n    11  StoreVariable 1 x\n    12  LoadStatic 0 (numbers read)\n  "
                "  13  Pop\n"),
      std::string::npos)
      << code;
}

TEST(Compiler, StackAndFrameSizesAreTheLargest) {
  const auto program = programOf(model("A(n) --> B(n+(n+(n+n)))\nL(a,b) < B(c) --> C(c)"));
  EXPECT_EQ(program->maximumStack, 4U);
  EXPECT_EQ(program->maximumSlots, 3);
  EXPECT_EQ(program->code.size(), program->codeRanges.size());
}

// ---- traits

TEST(Compiler, PurityOfProductions) {
  const auto production = [](const std::string& text) { return onlyProduction(programOf(model(text))); };
  EXPECT_TRUE(production("A(n) : n > Q --> B(sin(n), Z)").isPure);
  EXPECT_FALSE(production("A(n) --> B(ran(n))").isPure);
  EXPECT_TRUE(production("A(n) --> B(ran(n))").drawsRandom);
  EXPECT_FALSE(production("A(n) --> B(v)").isPure);
  EXPECT_FALSE(production("A(n) --> B(v * ran(1))").drawsRandom);
  EXPECT_FALSE(production("A(n) : {v = n;} * --> B").isPure);
  EXPECT_FALSE(production("A(n) : srand(1) --> B").isPure);
  EXPECT_FALSE(production("A(n) : srand(1) --> B").drawsRandom);
  EXPECT_TRUE(production("A(n) --> B(func(1, n))").isPure);
}

TEST(Compiler, PurityOfLSystems) {
  EXPECT_TRUE(programOf(model("A(n) --> B\nhomomorphism\nB --> C(ran(1))"))->systems[0].isPure);
  EXPECT_FALSE(programOf(model("A(n) --> B\ndecomposition\nB --> C(ran(1))"))->systems[0].isPure);
  EXPECT_TRUE(
      programOf("Lsystem: 1\nStart: {x = ran(1);}\nAxiom: A\nA --> A\nendlsystem\n")->systems[0].blocksDrawRandom);
  EXPECT_FALSE(programOf("Lsystem: 1\nStart: {x = 1;}\nAxiom: A\nA --> A\nendlsystem\n")->systems[0].blocksDrawRandom);
}

TEST(Compiler, QueriesContextsAndSubSystemsAreNoticed) {
  EXPECT_FALSE(programOf(model("A(n) --> B"))->hasQueries);
  EXPECT_TRUE(programOf(model("A(n) --> ?P(0,0)"))->hasQueries);
  EXPECT_TRUE(programOf(model("A(n) --> B\nhomomorphism\nC > ? --> D"))->hasQueries);
  EXPECT_TRUE(programOf(model("A(n) --> %(1)"))->hasQueries);
  EXPECT_FALSE(programOf(model("A(n) --> ?(2)B$"))->hasQueries);
  EXPECT_TRUE(programOf(model("A(n) --> ?(2)B$"))->hasSubSystems);
  EXPECT_FALSE(programOf(model("A(n) --> B\nhomomorphism\nC > B --> D"))->hasContexts);
  EXPECT_TRUE(programOf(model("A(n) --> B\ndecomposition\nC > B --> D"))->hasContexts);
}

TEST(Compiler, SpecialTypesAreKnownWhenUsed) {
  const auto none = programOf(model("A(n) --> B"));
  EXPECT_NE(none->openBranch, core::kNoModuleType);
  EXPECT_NE(none->closeBranch, core::kNoModuleType);
  EXPECT_EQ(none->cut, core::kNoModuleType);
  EXPECT_EQ(none->bareQuery, core::kNoModuleType);
  EXPECT_EQ(none->subSystemEnd, core::kNoModuleType);
  const auto all = programOf(model("A(n) --> %?E(1)$"));
  EXPECT_EQ(all->nameOf(all->cut), "%");
  EXPECT_EQ(all->nameOf(all->bareQuery), "?");
  EXPECT_EQ(all->nameOf(all->subSystemEnd), "$");
}

TEST(Compiler, TypesAreSymbolAndArity) {
  const auto program = programOf(model("A(l) --> A(l,l)A"));
  EXPECT_NE(program->findType("A", 0), program->findType("A", 1));
  EXPECT_EQ(program->arity[program->findType("A", 2)], 2);
  EXPECT_EQ(program->findType("A", 3), core::kNoModuleType);
  EXPECT_EQ(program->findType("X", 0), core::kNoModuleType);
}

TEST(Compiler, CandidatesAreInFileOrder) {
  const auto program = programOf(model("A(n) : n > 1 --> B\nB --> A(1)\nA(n) --> C\nA --> D"));
  const ProductionIndex& index = program->systems[0].productions.index;
  const auto candidates = index.candidates(program->findType("A", 1));
  EXPECT_EQ(std::vector<std::uint32_t>(candidates.begin(), candidates.end()), (std::vector<std::uint32_t>{0, 2}));
  EXPECT_TRUE(index.candidates(program->findType("C", 0)).empty());
}

TEST(Compiler, IgnoreAndConsiderAreResolvedBySymbol) {
  const auto isIgnored = [](const std::string& items, char symbol) {
    const auto program = programOf("Lsystem: 1\n" + items + "\nAxiom: A+B\nA --> A\nendlsystem\n");
    for (std::size_t i = 0; i < program->symbols.size(); ++i) {
      if (program->symbols[i].character() == symbol) {
        return static_cast<bool>(program->systems[0].isIgnored[i]);
      }
    }
    ADD_FAILURE() << "no symbol " << symbol;
    return false;
  };
  EXPECT_TRUE(isIgnored("ignore: +", '+'));
  EXPECT_FALSE(isIgnored("ignore: +", 'A'));
  EXPECT_FALSE(isIgnored("consider: A", 'A'));
  EXPECT_TRUE(isIgnored("consider: A", '['));
  EXPECT_TRUE(isIgnored("consider: AB\nignore: B", 'B'));
  EXPECT_FALSE(isIgnored("consider: A[]", ']'));
}

TEST(Compiler, BracketsAreIgnoredUnlessConsiderListsThem) {
  const auto ignoresBrackets = [](const std::string& items) {
    return programOf("Lsystem: 1\n" + items + "\nAxiom: A\nA --> A\nendlsystem\n")->systems[0].ignoresBrackets;
  };
  EXPECT_FALSE(ignoresBrackets("ignore: +"));
  EXPECT_TRUE(ignoresBrackets("ignore: ["));
  EXPECT_TRUE(ignoresBrackets("consider: A"));
  EXPECT_FALSE(ignoresBrackets("consider: A[]"));
}

// ---- files

TEST(Compiler, SourcesHoldEveryFileAndTheHashFollowsThem) {
  const auto compileFiles = [](const std::string& included, Compatibility mode, const std::string& value) {
    core::MemoryFileProvider files({{"d/m.l", "#include \"r.h\"\n" + model("A(n) --> B(R*N)")},
                                    {"d/r.h", included},
                                    {"d/m.v", "angle increment: 30\n"}});
    CompileInput input;
    input.modelFile = "d/m.l";
    input.viewFile = "d/m.v";
    input.compatibility = mode;
    input.defines = {{"N", value}};
    return compile(input, files).program;
  };
  const auto program = compileFiles("#define R 2\n", Compatibility::Espalier, "3");
  ASSERT_TRUE(program != nullptr);
  ASSERT_EQ(program->sources.size(), 3U);
  EXPECT_EQ(program->sources[0].name, "d/m.l");
  EXPECT_EQ(program->sources[1].name, "d/r.h");
  EXPECT_EQ(program->sources[2].name, "d/m.v");
  EXPECT_EQ(program->view.angleIncrementDegrees, 30.0);
  EXPECT_EQ(onlyProduction(program).expressions[0].constant, 6.0);
  EXPECT_EQ(program->hash, compileFiles("#define R 2\n", Compatibility::Espalier, "3")->hash);
  EXPECT_NE(program->hash, compileFiles("#define R 3\n", Compatibility::Espalier, "3")->hash);
  EXPECT_NE(program->hash, compileFiles("#define R 2\n", Compatibility::Cpfg, "3")->hash);
  EXPECT_NE(program->hash, compileFiles("#define R 2\n", Compatibility::Espalier, "4")->hash);
}

TEST(Compiler, FunctionSetsDefineMacrosExceptInBatchMode) {
  const std::string function = "fver 1 1\nname: grow\nsamples: 10\nflip: off\npoints: 4\n0 0\n0.3 0.3\n0.7 0.7\n1 1\n";
  const auto indexOf = [&](Compatibility mode) {
    core::MemoryFileProvider files({{"m.l", model("A(n) --> B(grow)")},
                                    {"m.v", "function set: f.fset\n"},
                                    {"f.fset", "funcgalleryver 1 1\nitems: 1\n" + function}});
    CompileInput input;
    input.modelFile = "m.l";
    input.viewFile = "m.v";
    input.compatibility = mode;
    const auto program = compile(input, files).program;
    EXPECT_TRUE(program != nullptr);
    const Expression& expression = onlyProduction(program).expressions[0];
    return expression.kind == Expression::Kind::Constant ? expression.constant : -1.0;
  };
  EXPECT_EQ(indexOf(Compatibility::Cpfg), 1.0);
  EXPECT_EQ(indexOf(Compatibility::CpfgBatch), -1.0);
}

TEST(Compiler, AFunctionOfASetWhoseNameHasAPointIsNoMacro) {
  core::MemoryFileProvider files(
      {{"m.l", model("A(n) --> B(grow)")},
       {"m.v", "function set: f.fset\n"},
       {"f.fset",
        "funcgalleryver 1 1\nitems: 1\nfver 1 1\nname: grow.func\nsamples: 10\nflip: off\npoints: 4\n0 0\n0.3 "
        "0.3\n0.7 0.7\n1 1\n"}});
  CompileInput input;
  input.modelFile = "m.l";
  input.viewFile = "m.v";
  const CompileResult result = compile(input, files);
  ASSERT_NE(result.program, nullptr);
  const Messages found = briefs(result.diagnostics);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].starts_with("0:0: warning: 'grow.func' cannot be defined: it is not a macro name")) << found[0];
  EXPECT_TRUE(found[1].starts_with("3:12: warning: unknown name 'grow'")) << found[1];
}

TEST(Compiler, CallersDefinesWinOverTheFile) {
  const CompileResult result =
      compileText("#define N 3\n" + model("A(n) --> B(N)"), Compatibility::Espalier, {}, {{"N", "9"}});
  ASSERT_TRUE(result.program != nullptr);
  EXPECT_EQ(onlyProduction(result.program).expressions[0].constant, 9.0);
}

TEST(Compiler, AMissingModelIsAnErrorWithoutProgram) {
  core::MemoryFileProvider files;
  CompileInput input;
  input.modelFile = "no.l";
  const CompileResult result = compile(input, files);
  EXPECT_TRUE(result.program == nullptr);
  EXPECT_EQ(result.diagnostics.errorCount(), 1U);
}

TEST(Compiler, ErrorsOfThePreprocessorDoNotHideThoseOfTheText) {
  EXPECT_EQ(
      messagesOf("#include \"no.h\"\n" + model("A(n) --> B(")),
      (Messages{"1:10: error: cannot read the included file 'no.h' | an included file is looked for beside the file "
                "that includes it",
                "4:12: error: expected an expression while reading the successor of A(n), found the end of the line"}));
}

TEST(Compiler, MistakesInsideMacrosNameUseAndDefinition) {
  const CompileResult result = compileText("#define R (1+)\n" + model("A(n) --> B(R)"));
  ASSERT_EQ(result.diagnostics.entries().size(), 1U);
  const core::Diagnostic& diagnostic = result.diagnostics.entries()[0];
  EXPECT_EQ(diagnostic.location.line, 4U);
  EXPECT_EQ(diagnostic.location.column, 12U);
  EXPECT_EQ(diagnostic.location.expansion, "in the expansion of R (m.l:1:9)");
}

TEST(Compiler, AnErrorBehindManyWarningsHasItsPlace) {
  std::string productions;
  for (int i = 0; i < 120; ++i) {
    productions += "A(n) : n > 1 --> B(v" + std::to_string(i) + ")\n";
  }
  const CompileResult result = compileText(model(productions + "A(n) --> B(sqr(n))"));
  EXPECT_EQ(result.diagnostics.warningCount(), 120U);
  ASSERT_EQ(result.diagnostics.errorCount(), 1U);
  EXPECT_EQ(result.diagnostics.entries().back().location.line, 123U);
}

TEST(Compiler, MessagesComeInTheOrderOfTheText) {
  EXPECT_EQ(
      messagesOf(model("A(n) --> B(sine(n))\nA(n) --> B(\nA(n) --> B(sqr(n))")),
      (Messages{"3:12: error: unknown function 'sine' in the successor of A(n) | did you mean 'sin'?",
                "4:12: error: expected an expression while reading the successor of A(n), found the end of the line",
                "5:12: error: unknown function 'sqr' in the successor of A(n) | did you mean 'sqrt'?"}));
}

}  // namespace
}  // namespace espalier::language::compiler_test
