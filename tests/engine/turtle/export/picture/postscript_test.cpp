#include "engine/turtle/export/picture/postscript.h"

#include <cmath>
#include <sstream>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::postscript_test {
namespace {

std::string postScriptOf(std::string_view text, const files::ViewSettings& view = {},
                         const PostScriptOptions& options = {}) {
  TurtleRun run(text, view);
  run.draw();
  core::StringSink sink;
  writePostScript(run.scene, view, options, sink);
  return sink.take();
}

// what an interpreter of the few operators in use sees on the page
struct Page {
  double left = 1e9, right = -1e9, bottom = 1e9, top = -1e9;
  int lines = 0, strokes = 0, tapered = 0, fills = 0, discs = 0;
  double lineWidth = 0.0;
};

Page interpret(const std::string& text) {
  Page page;
  std::istringstream words(text.substr(text.find("gsave")));
  std::vector<double> stack;
  const auto see = [&page](double x, double y) {
    page.left = std::min(page.left, x);
    page.right = std::max(page.right, x);
    page.bottom = std::min(page.bottom, y);
    page.top = std::max(page.top, y);
  };
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end == '\0') {
      stack.push_back(number);
      continue;
    }
    const std::size_t n = stack.size();
    if (word == "m" || word == "l") {
      see(stack[n - 2], stack[n - 1]);
      page.lines += word == "l" ? 1 : 0;
    } else if (word == "t") {
      see(stack[n - 6], stack[n - 5]);
      see(stack[n - 3], stack[n - 2]);
      ++page.tapered;
    } else if (word == "setlinewidth") {
      page.lineWidth = stack[n - 1];
    }
    page.strokes += word == "s" ? 1 : 0;
    page.fills += word == "f" ? 1 : 0;
    page.discs += word == "d" ? 1 : 0;
    stack.clear();
  }
  return page;
}

TEST(PostScript, TheDrawingFillsItsBoundingBox) {
  // a line of length 10 in a box of 100 by 200: the margin is 0.03 of 200
  files::ViewSettings view;
  view.isLineStyleGiven = true;
  const std::string text = postScriptOf("F(4)F(6)", view, {.widthPoints = 100, .heightPoints = 200});
  EXPECT_TRUE(
      text.starts_with("%!PS-Adobe-3.0 EPSF-3.0\n%%Creator: Espalier\n%%BoundingBox: 0 0 12 200\n"
                       "%%HiResBoundingBox: 0 0 12 200\n"))
      << text;
  EXPECT_TRUE(text.ends_with("grestore\nshowpage\n%%EOF\n"));
  const Page page = interpret(text);
  EXPECT_DOUBLE_EQ(page.left, 6.0);
  EXPECT_DOUBLE_EQ(page.right, 6.0);
  EXPECT_DOUBLE_EQ(page.bottom, 6.0);  // y goes up: the base is at the bottom
  EXPECT_DOUBLE_EQ(page.top, 194.0);
  EXPECT_EQ(page.lines, 2);
  EXPECT_EQ(page.strokes, 1);
  EXPECT_DOUBLE_EQ(page.lineWidth, 1.0);
}

TEST(PostScript, EveryOrganIsPainted) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  const Page page = interpret(postScriptOf("!(2)F(10)!(1)F(10)[+F(5)@O(2)]{.+(60)f.+(60)f.}@o(1)", view));
  EXPECT_EQ(page.tapered, 2);
  EXPECT_EQ(page.discs, 2);
  EXPECT_EQ(page.fills, 1);
}

TEST(PostScript, LineCapAndLabelsAreThoseOfTheModel) {
  files::ViewSettings view;
  view.postScriptLineCap = 2;
  TurtleRun run("@L(0)F", view);
  run.program.strings.push_back("a(b)\\c");
  run.draw();
  core::StringSink sink;
  writePostScript(run.scene, view, {}, sink);
  EXPECT_NE(sink.text().find("\n2 setlinecap "), std::string::npos);
  EXPECT_NE(sink.text().find("(a\\(b\\)\\\\c) show\n"), std::string::npos) << sink.text();
}

TEST(PostScript, LongLinesAreStrokedInPieces) {
  std::string text;
  for (int i = 0; i < 2500; ++i) {
    text += "+(1)F";
  }
  const Page page = interpret(postScriptOf(text));
  EXPECT_EQ(page.lines, 2500);
  EXPECT_EQ(page.strokes, 3);
}

}  // namespace
}  // namespace espalier::turtle::postscript_test
