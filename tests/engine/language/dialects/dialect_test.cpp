#include "engine/language/dialects/dialect.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::dialect_test {
namespace {

const char* const kTwo = "First { angle 4\naxiom f\n}\nSecond { angle 6\naxiom ff\n}\n";

TEST(Dialect, IsRecognisedByContent) {
  EXPECT_EQ(recognised("Koch {\n Angle 6\n Axiom F\n F=F+F\n}\n"), "fractint");
  EXPECT_EQ(recognised("axiom F\nangle 60\nprule F -> F+F\n"), "lsv");
  EXPECT_EQ(recognised("axiom: F\nF -> F+F--F+F\nangle: 60\n"), "textbook");
  EXPECT_EQ(recognised("axiom: F\nangle: 60\nF=F+F--F+F\n"), "textbook");
  EXPECT_EQ(recognised("axiom: F\nF ⟹ F+F--F+F\nangle: 60\n"), "textbook");
  EXPECT_EQ(recognised("recursion 3\nthickness 5\naxiom F\nrule F=FF\n"), "lparser");
  EXPECT_EQ(recognised("3\n90\n10\nF\nF=FF\n@\n"), "lparser");
  EXPECT_EQ(recognised("Axiom: F\nproduction:\nF --> FF\n"), "lpy");
  EXPECT_EQ(recognised("Espécie 6\nAxioma: F\nRegras: F -> F[+F]F\n"), "species");
  EXPECT_EQ(recognised("ω: F\np1: F → F+F\n"), "textbook");
  EXPECT_EQ(recognised("w: F\np: F -> F[+F]F : 0.5\n"), "textbook");
  EXPECT_EQ(recognised("// Turtle Painter\nω = F\nF → FF\n"), "turtle-painter");
  EXPECT_EQ(recognised("ω = A(1)\nA(p) : (p>%) → F A(p)\n"), "turtle-painter");
}

TEST(Dialect, LeavesCpfgAlone) {
  EXPECT_EQ(recognised("Lsystem: 1\nAxiom: F\nF --> FF\nendlsystem\n"), "");
  EXPECT_EQ(recognised("#include \"model.h\"\n"), "");
  // a broken cpfg model is reported as one
  EXPECT_EQ(recognised("Axiom: F\nF --> FF\nendlsystem\n"), "");
  EXPECT_EQ(recognised(""), "");
}

TEST(Dialect, LinesOfThePreprocessorMakeNoForeignTextACpfgModel) {
  // in these notations the lines are remarks
  EXPECT_EQ(recognised("#include leaves\nAxiom: F\nproduction:\nF --> FF\n"), "lpy");
  EXPECT_EQ(recognised("Axiom: F\n#if you want more, write 5\nproduction:\nF --> FF\nendlsystem\n"), "lpy");
  EXPECT_EQ(recognised("#include \"colours.h\"\naxiom: F\nF -> F+F\nangle: 60\n"), "textbook");
  // parts of a cpfg model may stand in another file
  EXPECT_EQ(recognised("#include \"head.h\"\nAxiom: F\nF --> FF\nendlsystem\n"), "");
  EXPECT_EQ(recognised("#ifdef BIG\n#include \"big.l\"\n#else\n#include \"small.l\"\n#endif\n"), "");
  // an arrow of XL alone makes no XL model
  EXPECT_EQ(
      foreignMessages("Lsystem: 1\nAxiom: A\nA ==> AB\nendlsystem\n"),
      Messages{"3:3: error: expected '-->' while reading a production, found '==>' | the arrow of a production has "
               "two strokes"});
}

TEST(Dialect, FilesOfOtherEditorsAreReadToo) {
  const std::string text = "ω: F\r\nδ = 60°\r\nF → F+F\r\n";
  EXPECT_EQ(cpfgText("\xEF\xBB\xBF" + text), cpfgText(text));
  // places are those that an editor shows
  EXPECT_EQ(foreignMessages("\xEF\xBB\xBFw: F*\nF -> F\n").front().substr(0, 5), "1:5: ");
  // Espécie in Latin-1
  EXPECT_EQ(recognised("Esp\xE9"
                       "cie 6\nAxioma: F\nRegras: F -> F[+F]F\n"),
            "species");
}

TEST(Dialect, BlanksOfPrintAreBlanks) {
  const auto same = [](const std::string& text) {
    std::string printed;
    for (const char c : text) {
      printed += c == ' ' ? std::string("\u00A0") : std::string(1, c);
    }
    EXPECT_FALSE(cpfgText(text).empty()) << text;
    EXPECT_EQ(cpfgText(printed), cpfgText(text)) << text;
  };
  same("Koch {\n Angle 6\n Axiom F\n F=F + F\n}\n");
  same("axiom F\nangle 60\nprule F -> F+F\n");
  same("recursion 3\nthickness 5\naxiom F\nrule F=FF\n");
  same("Axiom: A(1)\nderivation length: 2\nproduction:\nA(x) :\n  if x > 1:\n    produce F\n  produce A(x)\n");
  same("Espécie 6\nAxioma: F\nRegras: F -> F[+F]F\n");
  same("w: F\np: F -> F[+F]F : 0.5\n");
  same("ω = F\nF → F F\nIteracja : 2\n");
}

TEST(Dialect, FilesOfOldSystemsAreReadToo) {
  const std::string text = "axiom: F\nF -> F+F\nangle: 60\n";
  const std::string plain = cpfgText(text);
  ASSERT_FALSE(plain.empty());
  std::string little = "\xFF\xFE";
  std::string big = "\xFE\xFF";
  std::string macintosh = text;
  for (const char c : text) {
    little += std::string(1, c) + std::string(1, '\0');
    big += std::string(1, '\0') + std::string(1, c);
  }
  std::replace(macintosh.begin(), macintosh.end(), '\n', '\r');
  EXPECT_EQ(cpfgText(little), plain);
  EXPECT_EQ(cpfgText(big), plain);
  EXPECT_EQ(cpfgText(macintosh), plain);
  EXPECT_EQ(cpfgText(text + "\x1A"), plain);
  EXPECT_EQ(cpfgText(text + "\x1A" + std::string(100, '\0')), plain);
  // a byte order mark in the middle: two files were joined
  EXPECT_EQ(cpfgText("axiom: F\n\xEF\xBB\xBF"
                     "F -> F+F\nangle: 60\n"),
            plain);
  // Windows-1252: an en dash as the stroke of the arrow, and a degree sign
  EXPECT_EQ(cpfgText("axiom: F\nF \x96> F+F\nangle: 60\xB0\n"), plain);
}

TEST(Dialect, AControlPanelIsNamed) {
  const std::string items = "panel name: buds 200 100\nbackground: 0,0,0\ntype: slider\nname: angle\n";
  const Messages expected{
      "1:1: error: this is a control panel, not a model | give the .l file whose numbers it edits; the studio shows "
      "the "
      "panel above its sliders"};
  EXPECT_EQ(foreignMessages(items), expected);
  EXPECT_EQ(foreignMessages("target: buds.l\n" + items), expected);
}

TEST(Dialect, AFileWithoutTextIsNamed) {
  const std::string png = "\x89PNG\r\n\x1A\n" + std::string(100, '\0');
  EXPECT_EQ(foreignMessages(png),
            Messages{"1:1: error: this is a PNG picture, not a model | give the name of a text file with an L-system"});
  EXPECT_EQ(foreignMessages(png, {}, "cpfg"), foreignMessages(png));
  // "axiom: F" of two bytes a letter, in both orders
  for (const std::size_t zero : {0U, 1U}) {
    std::string utf16;
    for (const char c : std::string("axiom: F\nF -> F+F\n")) {
      utf16 += zero == 0 ? std::string{'\0', c} : std::string{c, '\0'};
    }
    EXPECT_EQ(foreignMessages(utf16),
              Messages{"1:1: error: this is a text in UTF-16 without a byte order mark | save it as UTF-8"});
  }
  EXPECT_EQ(foreignMessages("%PDF-1.4\n").front(),
            "1:1: error: this is a PDF document, not a model | give the name of a text file with an L-system");
  for (const std::string& bytes : {std::string("A\0B", 3), std::string("\x03\x9F\x02Q\x1A\x05\0", 7)}) {
    EXPECT_EQ(foreignMessages(bytes).front(),
              "1:1: error: this is a binary file, not a model | give the name of a text file with an L-system");
  }
}

TEST(Dialect, ModelsOfOtherProgramsAreNamed) {
  EXPECT_EQ(foreignMessages("#include <lpfgall.h>\nderivation length: 3;\nmodule A(int);\nAxiom: A(0);\n")
                .front()
                .substr(0, 49),
            "1:1: error: this is an L+C model for lpfg, and Es");
  EXPECT_EQ(foreignMessages("module A(float);\nAxiom: A(1);\nA(x): { produce A(x+1); }\n").size(), 1U);
  EXPECT_EQ(foreignMessages("module A(float len);\npublic void run() [\n A(x) ==> F(x) [RU(30) A(x)];\n]\n")
                .front()
                .substr(0, 43),
            "3:7: error: this is an XL model for GroIMP,");
  EXPECT_EQ(foreignMessages("<!DOCTYPE html>\n<html></html>\n").front().substr(0, 45),
            "1:1: error: this is a web page or another XML");
  EXPECT_EQ(foreignMessages("const koch = new LSystem({\n  axiom: 'F',\n  productions: {'F': 'F-F'}\n})\n")
                .front()
                .substr(0, 45),
            "1:1: error: this is a program with an L-syste");
}

TEST(Dialect, EveryEntryOfAFileIsListedOnce) {
  core::MemoryFileProvider files(
      {{"m.txt", "A { angle 4\naxiom f\n}\na { angle 4\naxiom ff\n}\nB { angle 4\naxiom f\n}\n"},
       {"one.txt", "axiom: F\nF -> FF\n"}});
  CompileInput input;
  input.modelFile = "m.txt";
  EXPECT_EQ(entriesOf(input, files), (std::vector<std::string>{"A", "a-2", "B"}));
  input.modelFile = "m.txt:a-2";
  EXPECT_NE(compile(input, files).program->sources.front().text.find("Axiom: FF\n"), std::string::npos);
  input.modelFile = "one.txt";
  EXPECT_EQ(entriesOf(input, files), std::vector<std::string>{});
}

TEST(Dialect, TranslationsGetTheWarningsAboutModels) {
  EXPECT_EQ(foreignMessages("ω: A(1)\nA(x) → F\nA(x) → FF\n").size(), 1U);
  EXPECT_EQ(foreignMessages("ω: A\nA → F\nB → F\n"),
            Messages{"3:1: warning: 'B' never matches: no axiom or successor makes the module B"});
}

TEST(Dialect, IsOverriddenByName) {
  const std::string text = "w: F\np: F -> FF\n";
  EXPECT_EQ(foreignMessages(text, {}, "lsv").front().substr(0, 26), "1:1: error: unknown comman");
  EXPECT_EQ(foreignMessages(text, {}, "cpfg").front().substr(0, 11), "1:1: error:");
  EXPECT_EQ(
      foreignMessages(text, {}, "textbok"),
      Messages{"1:1: error: there is no dialect 'textbok' | Did you mean 'textbook'? Available: cpfg, fractint, lpy, "
               "lparser, lsv, species, turtle-painter, textbook."});
}

TEST(Dialect, AnEntryIsChosenWithoutRegardToCase) {
  EXPECT_NE(cpfgText(kTwo, "second").find("Axiom: FF\n"), std::string::npos);
  EXPECT_NE(cpfgText(kTwo, "First").find("Axiom: F\n"), std::string::npos);
}

TEST(Dialect, WithoutAnEntryTheFirstIsUsedAndTheOthersAreNamed) {
  const CompileResult result = compileForeign(kTwo);
  ASSERT_NE(result.program, nullptr);
  ASSERT_EQ(result.diagnostics.entries().size(), 1U);
  EXPECT_EQ(result.diagnostics.entries().front().severity, core::Severity::Note);
  EXPECT_EQ(result.diagnostics.entries().front().message, "the file holds 2 models; the first is used: First, Second");
  EXPECT_EQ(result.diagnostics.entries().front().hint, "m.txt:NAME chooses another");
}

TEST(Dialect, AnEntryThatIsNotThereIsAnError) {
  EXPECT_EQ(foreignMessages(kTwo, "Secnd"),
            Messages{"1:1: error: the file has no entry 'Secnd' | Did you mean 'Second'? Available: First, Second."});
  EXPECT_EQ(foreignMessages("ω: F\nF → FF\n", "X"),
            Messages{"1:1: error: the file has no entry 'X' | the file holds one model: remove the ':' and the name"});
}

TEST(Dialect, MessagesOfTheCompilerNameTheForeignLine) {
  EXPECT_EQ(
      foreignMessages("ω: A(1)\n\np1: A(x) → F(x)A(x+y)\n"),
      Messages{"3:22: warning: unknown name 'y' in the successor of A(x): its value is 0 | names visible here: x, Q, "
               "Z"});
}

TEST(Dialect, ASnapshotsFilesCompileToTheSameProgram) {
  const CompileResult first = compileForeign(kTwo, "Second");
  ASSERT_NE(first.program, nullptr);
  core::MemoryFileProvider files;
  for (const files::SourceMap::File& file : first.program->sources) {
    files.add(file.name, file.text);
  }
  CompileInput input;
  input.modelFile = first.program->modelFile;
  input.viewFile = first.program->viewFile;
  const CompileResult second = compile(input, files);
  ASSERT_NE(second.program, nullptr);
  EXPECT_EQ(second.program->hash, first.program->hash);
  EXPECT_EQ(second.program->view.angleIncrementDegrees, 60.0);
  EXPECT_EQ(second.program->view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
}

TEST(Dialect, AViewFileOfTheCallerCountsAfterTheDialects) {
  core::MemoryFileProvider files({{"a/m.txt", "ω: F\nδ = 30°\nα0 = 0\nF → FF\n"}, {"b/v.v", "angle increment: 10\n"}});
  CompileInput input;
  input.modelFile = "a/m.txt";
  input.viewFile = "b/v.v";
  const CompileResult result = compile(input, files);
  ASSERT_NE(result.program, nullptr);
  EXPECT_EQ(result.program->view.angleIncrementDegrees, 10.0);
  EXPECT_EQ(result.program->view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
}

TEST(Dialect, BracketsWithoutPartnerAreErrorsInEveryDialect) {
  EXPECT_EQ(
      foreignMessages("ω: F[+F\nF → F]F\nδ = 30°\n"),
      (Messages{"1:6: error: the bracket '[' is never closed in the axiom | a ']' goes back to where the turtle was "
                "at '['",
                "2:8: error: ']' closes no bracket in the successor | each ']' goes back to the '[' before it"}));
}

}  // namespace
}  // namespace espalier::language::dialect_test
