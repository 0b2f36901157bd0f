#include "engine/language/format/formatter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/compiler.h"
#include "engine/language/format/disassembler.h"
#include "engine/language/format/program_comparison.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::language::formatter_test {
namespace {

namespace fs = std::filesystem;

FormatResult formatted(const std::string& text, core::MemoryFileProvider files = {}) {
  files.add("model.l", text);
  CompileInput input;
  input.modelFile = "model.l";
  return format(input, files);
}

std::string layout(const std::string& text) {
  return formatted(text).text;
}

/// A model around productions, which stand alone in what is returned.
std::string productions(const std::string& lines) {
  const std::string head = "Lsystem: 1\nderivation length: 2\nAxiom: A(1)/ /F\n";
  const std::string tail = "endlsystem\n";
  const FormatResult result = formatted(head + lines + tail);
  EXPECT_TRUE(result.isCompiled) << lines;
  EXPECT_EQ(result.text.substr(0, head.size()), head);
  EXPECT_EQ(result.text.substr(result.text.size() - tail.size()), tail);
  return result.text.substr(head.size(), result.text.size() - head.size() - tail.size());
}

std::vector<fs::path> publishedModels() {
  std::vector<fs::path> found;
  for (const char* folder : {"/tests/conformance/cases", "/clients/gallery"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(sourceFolder() + std::string(folder))) {
      if (entry.path().extension() == ".l") {
        found.push_back(entry.path());
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// The same files with another text in place of one.
class WithText final : public core::FileProvider {
 public:
  WithText(std::string name, std::string text) : name_(std::move(name)), text_(std::move(text)) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    return name == name_ ? text_ : disk_.read(name);
  }

 private:
  test::DiskFiles disk_;
  std::string name_, text_;
};

TEST(Formatter, EveryPublishedModelRoundTripsInBothModesAndFormattingAgainChangesNothing) {
  std::size_t count = 0;
  std::size_t items = 0;
  std::size_t changed = 0;
  for (const fs::path& path : publishedModels()) {
    for (const core::Compatibility mode : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
      test::DiskFiles disk;
      CompileInput input;
      input.modelFile = path.string();
      const fs::path view = fs::path(path).replace_extension(".v");
      input.viewFile = fs::exists(view) ? view.string() : std::string();
      input.compatibility = mode;
      const std::shared_ptr<const Program> original = compile(input, disk).program;
      const FormatResult result = format(input, disk);
      ASSERT_EQ(result.isCompiled, original != nullptr) << path;
      if (!original) {
        continue;
      }
      ++count;
      items += result.untouchedItems;
      changed += result.text != test::readFile(input.modelFile) ? 1U : 0U;
      WithText files(input.modelFile, result.text);
      const std::shared_ptr<const Program> program = compile(input, files).program;
      ASSERT_TRUE(program) << path << "\n" << result.text;
      EXPECT_TRUE(isSameProgram(*program, *original)) << path << "\n" << result.text;
      EXPECT_EQ(format(input, files).text, result.text) << path;
    }
  }
  EXPECT_GT(count, 400U);
  EXPECT_GT(changed, 100U);
  // the guarantee must not hold only because nothing is changed
  EXPECT_LT(items, count / 10);
}

TEST(Formatter, PublishedModelsWithOtherBlanksRoundTrip) {
  std::mt19937 random(20);
  std::size_t count = 0;
  for (const fs::path& path : publishedModels()) {
    const std::string published = test::readFile(path.string()).value_or("");
    // more, fewer or no blanks where there are some, and blanks around signs
    std::string text;
    bool isAtLineStart = true;
    bool isDirective = false;
    for (const char c : published) {
      isDirective = isAtLineStart ? c == '#' : isDirective;
      isAtLineStart = c == '\n';
      const std::size_t choice = random() % 8;
      if (isDirective || c == '\n' || c == '\t') {
        text += c;
      } else if (c == ' ') {
        text += std::string(choice % 4, ' ');
      } else if (choice == 0 && std::string("(),+{};").find(c) != std::string::npos && !text.ends_with('\n')) {
        text += std::string(" ") + c + " ";
      } else {
        text += c;
      }
    }
    CompileInput input;
    input.modelFile = path.string();
    WithText files(input.modelFile, text);
    const std::shared_ptr<const Program> original = compile(input, files).program;
    if (!original) {
      continue;
    }
    ++count;
    const FormatResult result = format(input, files);
    WithText again(input.modelFile, result.text);
    const std::shared_ptr<const Program> program = compile(input, again).program;
    ASSERT_TRUE(program) << path << "\n" << result.text;
    EXPECT_TRUE(isSameProgram(*program, *original)) << path << "\n" << result.text;
    EXPECT_EQ(format(input, again).text, result.text) << path << "\n" << text;
  }
  EXPECT_GT(count, 150U);
}

TEST(Formatter, BlanksAroundSeparatorsAndOperators) {
  EXPECT_EQ(productions("A(l)<A(x):l>1&&x!=-2-->F(l)A( l * 2,1 )B(x>1):.5\n"),
            "A(l) < A(x) : l > 1 && x != -2 --> F(l)A(l*2,1)B(x > 1) : .5\n");
  EXPECT_EQ(productions("*<F>*   -->   *\n"), "* < F > * --> *\n");
  EXPECT_EQ(productions("A ( l )  :*-->F ( - l )\n"), "A(l) : * --> F(-l)\n");
}

TEST(Formatter, BlanksBetweenModulesStayOne) {
  EXPECT_EQ(productions("F -->  F/   /F  [+F]  ;F\n"), "F --> F/ /F [+F] ;F\n");
}

TEST(Formatter, SignsThatWouldJoinStayApart) {
  // without their blank, two signs side by side could become another token
  EXPECT_EQ(productions("A(l) --> F(l- -1)A(l/ 2)B(l / -1)\n"), "A(l) --> F(l- -1)A(l/2)B(l/ -1)\n");
}

TEST(Formatter, ContinuationLinesKeepTheirTab) {
  EXPECT_EQ(productions("A(l):l>0\n\t\t   -->F(l)\n\t  #(2)F\n"), "A(l) : l > 0\n\t--> F(l)\n\t#(2)F\n");
}

TEST(Formatter, BlocksAreIndented) {
  EXPECT_EQ(layout("Lsystem: 1\nStart:\n{\nn=1;\nif(n>0){\nn=max(n, 2);}\n}\nAxiom: A\nA:{x=1;\n\n\n  "
                   "y=2;\n}x>0-->A\nendlsystem"),
            "Lsystem: 1\nStart: {\n  n = 1;\n  if (n > 0) {\n    n = max(n,2); }\n}\nAxiom: A\n"
            "A : { x = 1;\n\n  y = 2;\n} x > 0 --> A\nendlsystem\n");
}

TEST(Formatter, CommentsStay) {
  EXPECT_EQ(productions("/* one */ F-->F  /* two */F  // three\n// four   \n\n\n"),
            "/* one */ F --> F /* two */ F // three\n// four\n\n");
}

TEST(Formatter, DirectivesAndLinesLeftOutStayAsTheyAre) {
  const std::string text = "#define   R 2  \n#define TWO(x)  F(x)F(x)\n#if 0\nA-->  wrong (\n#endif\n";
  EXPECT_EQ(layout(text + "Lsystem:1\nAxiom:TWO( R )\nF(x)-->F(x*R)\nendlsystem\n"),
            text + "Lsystem: 1\nAxiom: TWO(R)\nF(x) --> F(x*R)\nendlsystem\n");
}

TEST(Formatter, ItemsAroundADirectiveOrAJoinedLineStayAsTheyAre) {
  const std::string text = "Lsystem: 1\nAxiom: F\nF-->F\n#ifdef X\n\tG\n#endif\n\tF\nG-->F\\\nG\nendlsystem\n";
  const FormatResult result = formatted(text);
  EXPECT_EQ(result.text, text);
  EXPECT_EQ(result.untouchedItems, 2U);
}

TEST(Formatter, AnItemThatWouldMeanSomethingElseStaysAsItIs) {
  // the macro and the sign behind it are one operator after expansion, and would be two with a blank between them
  const std::string text =
      "#define LESS <\nLsystem: 1\nAxiom: A(1)\nA(x):x LESS= 1-->B\nA(x):x LESS 3-->C\nB-->C\nendlsystem\n";
  const FormatResult result = formatted(text);
  ASSERT_TRUE(result.isCompiled);
  EXPECT_EQ(
      result.text,
      "#define LESS <\nLsystem: 1\nAxiom: A(1)\nA(x):x LESS= 1-->B\nA(x) : x LESS 3 --> C\nB --> C\nendlsystem\n");
  EXPECT_EQ(result.untouchedItems, 1U);
}

TEST(Formatter, FreeSyntaxAndNamedModules) {
  EXPECT_EQ(layout("Syntax:free\nModule:Apex(age,vigor),?Light(flux)\nLsystem: 1\nAxiom: Apex(0,1)\n"
                   "Apex(a,v):a<3-->F(a)\n     Apex(a+1,v)   ;F(a)-->F(a)\nendlsystem\n"),
            "Syntax: free\nModule: Apex(age,vigor), ?Light(flux)\nLsystem: 1\nAxiom: Apex(0,1)\n"
            "Apex(a,v) : a < 3 --> F(a)\n  Apex(a+1,v); F(a) --> F(a)\nendlsystem\n");
}

TEST(Formatter, LineEndsOfTheFileAreKept) {
  EXPECT_EQ(layout("Lsystem:1\r\nAxiom:F\r\nF-->FF  \r\nendlsystem\r\n"),
            "Lsystem: 1\r\nAxiom: F\r\nF --> FF\r\nendlsystem\r\n");
}

TEST(Formatter, EveryEncodingOfAModelIsLaidOutAsUtf8WithNewlines) {
  const std::string plain = "Lsystem: 1\nderivation length: 2\nAxiom: A(1)/ /F\nA(x)-->A(x+1)\nendlsystem\n";
  const std::string expected = layout(plain);
  ASSERT_NE(expected, plain);
  std::string returns = plain;
  std::ranges::replace(returns, '\n', '\r');
  std::string utf16 = "\xFF\xFE";
  for (const char c : plain) {
    utf16 += c;
    utf16 += '\0';
  }
  for (const std::string& text : {"\xEF\xBB\xBF" + plain, returns, utf16}) {
    EXPECT_EQ(layout(text), expected);
  }
}

TEST(Formatter, AModelWithErrorsIsReturnedAsItIs) {
  const std::string text = "Lsystem:1\nAxiom:F\nF->F\nendlsystem\n";
  const FormatResult result = formatted(text);
  EXPECT_FALSE(result.isCompiled);
  EXPECT_EQ(result.text, text);
  EXPECT_TRUE(result.diagnostics.hasErrors());
}

}  // namespace
}  // namespace espalier::language::formatter_test
