#include "engine/language/dialects/turtle_painter.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::turtle_painter_test {
namespace {

std::string painter(const std::string& lines) {
  return "// Turtle Painter\n" + lines;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(TurtlePainter, APercentSignIsARandomNumberAndTheTimeIsTheStep) {
  EXPECT_TRUE(contains(cpfgText(painter("ω = A(1)\nA(p) : (p>%) & t < 3 → B(t)\n")),
                       "A(p) : (p>floor(ran(100))) && Q < 3 --> B(Q)\n"));
  // between two values it is the remainder, and a parameter hides the time
  EXPECT_TRUE(contains(cpfgText(painter("ω = A(1)\nA(t) : t % 2 = 0 → B(t)\n")), "A(t) : t % 2 == 0 --> B(t)\n"));
}

TEST(TurtlePainter, ATurnWithTwoParametersIsDrawnWhenItIsMade) {
  EXPECT_TRUE(contains(cpfgText(painter("ω = A(1)\nA(x) → +(10,20)&(5)/(0,x+1)\n")),
                       "+((10)+ran((20)-(10)))&(5)/((0)+ran((x+1)-(0)))\n"));
}

TEST(TurtlePainter, DrawsLeavesFruitsAndThickness) {
  const std::string text = cpfgText(painter("ω = F(2,0.5)p(1)o\nF(d,s) → F(d,s)\n"));
  EXPECT_TRUE(contains(text, "p(x) --> [;(2){.+(30)f(x)-(60)f(x)-(120)f(x)}]\n")) << text;
  EXPECT_TRUE(contains(text, "o --> [;(3)@O(0.5)]\n"));
  EXPECT_TRUE(contains(text, "F(d,s) --> !(s)F(d)\n"));
}

TEST(TurtlePainter, RollsAsTheTurtleDoes) {
  EXPECT_FALSE(contains(cpfgText(painter("ω = F/F\nF → F\n")), "/ -->"));
}

TEST(TurtlePainter, ObjectsComeFromFilesAndTheVectorMovesThem) {
  core::MemoryFileProvider files(
      {{"m.txt", painter("ω = p(2)\nF → F\nobject p: leaf.obj 0.5\nvector: 0, -0.5, 0.25\n")},
       {"leaf.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"}});
  CompileInput input;
  input.modelFile = "m.txt";
  const CompileResult result = compile(input, files);
  ASSERT_NE(result.program, nullptr);
  ASSERT_EQ(result.program->view.triangleSurfaces.size(), 1U);
  double longest = 0.0;
  for (const core::Vec3& point : result.program->view.triangleSurfaces.front().triangles.front().points) {
    longest = std::max(longest, core::length(point));
  }
  EXPECT_EQ(longest, 0.5);
  EXPECT_EQ(result.program->view.displacement, (core::Vec3{0.0, -0.5, 0.25}));
  EXPECT_TRUE(contains(result.program->sources.front().text, "p(x) --> [;(2)~p(x)]\n"));
}

TEST(TurtlePainter, ErrorsNameItsLinesAndTerms) {
  EXPECT_EQ(
      foreignMessages(painter("ω = F\nF → F\nobject q: a.obj\n")),
      Messages{
          "4:1: error: expected 'p' or 'o' and a file while reading 'object' | write 'object p: leaf.obj 0.5', the "
          "number is its size"});
  EXPECT_EQ(
      foreignMessages(painter("ω = F\nF → F\nobject p: a.obj 0\n")),
      Messages{"4:11: error: expected a size above 0 behind the file of an object | write 'object p: leaf.obj 0.5'"});
  EXPECT_EQ(foreignMessages(painter("ω = F\nF → F\nvector: 1, 2\n")),
            Messages{"4:9: error: expected three numbers while reading 'vector' | write 'vector: 0, -0.1, 0': "
                     "everything drawn moves by it"});
}

}  // namespace
}  // namespace espalier::language::turtle_painter_test
