#include "engine/turtle/interpretation/parted_interpretation.h"

#include <algorithm>
#include <optional>

#include "tests/engine/turtle/textured_view.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::parted_interpretation_test {
namespace {

// a tree of 2^(depth + 1) - 1 nodes with queries in front of, in and behind branches; `leaf` is at the tips
std::string tree(int depth, const std::string& leaf) {
  if (depth == 0) {
    return leaf;
  }
  const std::string branch = tree(depth - 1, leaf);
  return "F(1)!(0.5)?E(1,2)[+(25)" + branch + "]/(137)?P(0,0,0)[-(31)&(10)" + branch + "]f(0.5)?E(3)";
}

constexpr int kDepth = 12;  // about 70,000 modules
const char* const kLeaf = "F(0.5)?E(7)A(1,2)?H(0,0,0)";

std::optional<core::SimulationError> pass(TurtleRun& run, unsigned threads) {
  run.threads = threads;
  try {
    run.pass(kAllButGeometry);
  } catch (const core::SimulationFailure& failure) {
    return failure.error();
  }
  return std::nullopt;
}

bool isSame(const std::vector<core::Vec3>& a, const std::vector<core::Vec3>& b) {
  return a == b;
}

// one thread, then two and three: everything that a pass gives, and the string it leaves
void expectSame(const std::string& text, std::uint64_t maximumQueries = 1'000'000,
                const files::ViewSettings& view = {}) {
  TurtleRun one(text, view);
  one.limits.maximumQueries = maximumQueries;
  const auto expected = pass(one, 1);
  for (const unsigned threads : {2U, 3U}) {
    TurtleRun several(text, view);
    several.limits.maximumQueries = maximumQueries;
    const auto found = pass(several, threads);
    ASSERT_EQ(found.has_value(), expected.has_value());
    if (expected) {
      EXPECT_EQ(found->message, expected->message);
      EXPECT_EQ(found->module, expected->module);
    }
    EXPECT_EQ(several.queries.plant, one.queries.plant);
    EXPECT_EQ(several.queries.module, one.queries.module);
    EXPECT_EQ(several.queries.symbol, one.queries.symbol);
    EXPECT_EQ(several.queries.isTransient, one.queries.isTransient);
    EXPECT_TRUE(isSame(several.queries.position, one.queries.position));
    EXPECT_TRUE(isSame(several.queries.heading, one.queries.heading));
    EXPECT_TRUE(isSame(several.queries.left, one.queries.left));
    EXPECT_TRUE(isSame(several.queries.up, one.queries.up));
    EXPECT_EQ(several.queries.width, one.queries.width);
    EXPECT_EQ(several.queries.scale, one.queries.scale);
    EXPECT_EQ(several.queries.parameterOffset, one.queries.parameterOffset);
    EXPECT_EQ(several.queries.parameters, one.queries.parameters);
    EXPECT_EQ(several.queries.following, one.queries.following);
    EXPECT_EQ(several.queries.followingOffset, one.queries.followingOffset);
    EXPECT_EQ(several.queries.followingParameters, one.queries.followingParameters);
    EXPECT_EQ(several.offsets, one.offsets);
    EXPECT_EQ(several.messages, one.messages);
    ASSERT_EQ(several.changes.size(), one.changes.size());
    for (std::size_t i = 0; i < one.changes.size(); ++i) {
      ASSERT_EQ(several.changes[i].offset, one.changes[i].offset) << i;
      ASSERT_EQ(several.changes[i].before, one.changes[i].before) << i;
    }
    const auto left = one.state.string.parameters();
    const auto right = several.state.string.parameters();
    EXPECT_TRUE(std::equal(left.begin(), left.end(), right.begin(), right.end()));
  }
}

std::optional<core::SimulationError> drawInto(Scene& scene, TurtleRun& run, unsigned threads) {
  run.threads = threads;
  try {
    run.interpret({}, {.scene = &scene, .queryParameterOffsets = nullptr});
  } catch (const core::SimulationFailure& failure) {
    return failure.error();
  }
  return std::nullopt;
}

// the same for what is drawn, behind a plant that the scene has already
void expectSameScene(const std::string& text, const files::ViewSettings& view = texturedView()) {
  TurtleRun first("F[+F]@O(1)");
  TurtleRun one(text, view);
  Scene expected;
  ASSERT_FALSE(drawInto(expected, first, 1));
  const auto expectedFailure = drawInto(expected, one, 1);
  for (const unsigned threads : {2U, 3U}) {
    TurtleRun several(text, view);
    Scene found;
    ASSERT_FALSE(drawInto(found, first, 1));
    const auto failure = drawInto(found, several, threads);
    ASSERT_EQ(failure.has_value(), expectedFailure.has_value());
    if (failure) {
      EXPECT_EQ(failure->message, expectedFailure->message);
    }
    EXPECT_EQ(found.lineStyle, expected.lineStyle);
    ASSERT_EQ(found.segments.size(), expected.segments.size());
    EXPECT_TRUE(std::ranges::equal(found.segments, expected.segments));
    EXPECT_EQ(found.polygons, expected.polygons);
    EXPECT_EQ(found.balls, expected.balls);
    EXPECT_EQ(found.surfaces, expected.surfaces);
    EXPECT_EQ(found.labels, expected.labels);
    EXPECT_EQ(found.cylinders, expected.cylinders);
    EXPECT_EQ(several.messages, one.messages);
    EXPECT_TRUE(std::ranges::equal(several.state.string.parameters(), one.state.string.parameters()));
  }
}

bool isTaken(const std::string& text, unsigned threads, bool isScene, const files::ViewSettings& view = {}) {
  TurtleRun run(text, view);
  derivation::DerivationOptions options;
  options.threads = threads;
  derivation::Derivation derivation(run.program, options);
  const InterpretationTables tables(run.program);
  std::set<std::string> reported;
  const PlantPlacement placement;
  const Interpretation::Subject subject{run.program, tables, reported, derivation, run.state, 0, placement};
  InterpretationOutput output{.queryParameterOffsets = nullptr};
  output.scene = isScene ? &run.scene : nullptr;
  output.queries = isScene ? nullptr : &run.queries;
  const bool result = PartedInterpretation().run(subject, output);
  EXPECT_TRUE(result || run.scene.empty());
  return result;
}

TEST(PartedInterpretation, TakesALongStringWithBranchesAndNoOther) {
  for (const bool isScene : {false, true}) {
    SCOPED_TRACE(isScene);
    EXPECT_TRUE(isTaken(tree(kDepth, kLeaf), 2, isScene));
    EXPECT_FALSE(isTaken(tree(kDepth, kLeaf), 1, isScene));
    EXPECT_FALSE(isTaken(tree(5, kLeaf), 2, isScene));
    EXPECT_FALSE(isTaken(std::string(60'000, 'F') + "?E(1)", 2, isScene));
    EXPECT_FALSE(isTaken(tree(kDepth, kLeaf) + "?(1,2)F$", 2, isScene));
  }
}

const char* const kOrgans = "F(0.5);(7){F(1)+(40)F(1)+(40)F(1)}[@O(0.2)~p(0.5)][f(1)@Tx(1)F(2)]?P(0,0,0)~p";

TEST(PartedInterpretation, DrawsWhatOneThreadDraws) {
  files::ViewSettings view = texturedView();
  EXPECT_TRUE(isTaken(tree(kDepth, kOrgans), 2, true, view));
  expectSameScene(tree(kDepth, kOrgans), view);
  // lines that begin with the width of the line before them, which may be in front of their branch
  view.hasTaperedLines = true;
  expectSameScene(tree(kDepth, kOrgans), view);
  // a surface called F: it draws no line
  view.surfaces.push_back(view.surfaces.back());
  view.surfaces.back().id = 'F';
  expectSameScene(tree(kDepth, "F~F(2)"), view);
  // cuts and cylinders, also of one point
  view.interpretsPastCut = false;
  expectSameScene("F[" + tree(kDepth, "F[@GsFF@Ge]{(1)FF}@Gs%F") + "F[F%F]%" + tree(kDepth - 1, "F") + "]F", view);
  expectSameScene("@Q[" + tree(kDepth, "F@YA@H") + "]@N[" + tree(kDepth - 1, "F@VA@Q") + "]@U", view);
}

TEST(PartedInterpretation, OneThreadDrawsWhatDoesNotEndInABranch) {
  const std::string whole = tree(kDepth, kOrgans);
  // a polygon around branches, one that a branch leaves open, and one that ends in a later branch
  for (const std::string& text :
       {"{F" + whole + "F}", "[" + tree(kDepth, "F{F") + "]" + whole, "[" + whole + "{F][F" + whole + "F}]"}) {
    EXPECT_FALSE(isTaken(text, 2, true, texturedView()));
    expectSameScene(text);
  }
  // a branch that goes on with the cylinder around it, and one that leaves it alone
  const std::string cylinder = "@GsF@Gc[" + tree(kDepth, "F@GsF@Ge") + "]F@Ge";
  EXPECT_TRUE(isTaken(cylinder, 2, true));
  expectSameScene(cylinder);
  EXPECT_FALSE(isTaken("@GsF[" + tree(kDepth, "F@Gc") + "]F@Ge", 2, true));
  expectSameScene("@GsF[" + tree(kDepth, "F@Gc") + "]F@Ge");
}

TEST(PartedInterpretation, DrawingFailsAsOneThreadDoes) {
  std::string inside = tree(kDepth, kLeaf);
  inside.insert(inside.rfind(kLeaf), "[F(1e308)F(1e308)]");
  inside.insert(inside.find(kLeaf), "[F(1)F(1e308)F(1e308)]");
  EXPECT_FALSE(isTaken(inside, 2, true));
  expectSameScene(inside);
}

TEST(PartedInterpretation, GivesWhatOneThreadGives) {
  expectSame(tree(kDepth, kLeaf));
  // cuts: one of them ends the walk before all branches to the right of it
  const std::string cut =
      "F[" + tree(kDepth, kLeaf) + "F[?E(1)%" + tree(3, kLeaf) + "]%" + tree(kDepth - 1, kLeaf) + "]?E(2)";
  expectSame(cut);
  files::ViewSettings view;
  view.interpretsPastCut = false;
  expectSame(cut, 1'000'000, view);
  expectSame(cut + tree(kDepth, kLeaf), 1'000'000, view);
}

TEST(PartedInterpretation, WarnsInTheOrderOfTheString) {
  const std::string text = "@Q[" + tree(kDepth, "F?E(1)@YA@H") + "]@N[" + tree(kDepth - 1, "F?E(1)@VA@Q") + "]@U";
  expectSame(text);
  TurtleRun run(text);
  ASSERT_FALSE(pass(run, 2));
  ASSERT_EQ(run.messages.size(), 6U);
  EXPECT_NE(run.messages[1].find("'@Y'"), std::string::npos);
  EXPECT_NE(run.messages[5].find("'@U'"), std::string::npos);
}

TEST(PartedInterpretation, FailsAsOneThreadDoes) {
  // two failures: the first in the string is told, though another thread may meet the second before
  const std::string bad = "[F(1e308)F(1e308)?E(1)]";
  expectSame(tree(kDepth, kLeaf) + bad + tree(kDepth, kLeaf));
  std::string inside = tree(kDepth, kLeaf);
  inside.insert(inside.rfind(kLeaf), bad);
  inside.insert(inside.find(kLeaf), "[F(1e308)F(1e308)]");
  expectSame(inside);
  expectSame(tree(kDepth, kLeaf), 5'000);
}

}  // namespace
}  // namespace espalier::turtle::parted_interpretation_test
