#include "engine/turtle/interpretation/branch_parts.h"

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::branch_parts_test {
namespace {

std::vector<BranchPart> partsOf(const std::string& text, std::uint64_t smallest, std::uint64_t largest) {
  const TurtleRun run(text);
  return findBranchParts(InterpretationTables(run.program), run.program.arity, run.state.string.types(), smallest,
                         largest);
}

TEST(BranchParts, AreTheLargestBranchesThatAreNotTooLarge) {
  // modules: 0 F, 1 [, 2 F, 3 [, 4 F, 5 F, 6 ], 7 [, 8 F, 9 ], 10 ], 11 [, 12 F, 13 F, 14 ]
  const std::string text = "F[F(1)[F(2,3)F][F]][FF]";
  const auto all = partsOf(text, 2, 8);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].firstModule, 2U);
  EXPECT_EQ(all[0].endModule, 10U);
  EXPECT_EQ(all[0].firstOffset, 0U);
  EXPECT_EQ(all[0].endOffset, 3U);
  EXPECT_EQ(all[1].firstModule, 12U);
  EXPECT_EQ(all[1].firstOffset, 3U);
  // the first branch has 8 modules: too large now, its inner one of two is taken
  const auto inner = partsOf(text, 2, 7);
  ASSERT_EQ(inner.size(), 2U);
  EXPECT_EQ(inner[0].firstModule, 4U);
  EXPECT_EQ(inner[0].endModule, 6U);
  EXPECT_EQ(inner[0].firstOffset, 1U);
  EXPECT_EQ(inner[0].endOffset, 3U);
}

TEST(BranchParts, LoneBracketsMakeNone) {
  EXPECT_TRUE(partsOf("F]FF[FF", 0, 100).empty());
  // behind one that closes nothing, and far inside others
  EXPECT_EQ(partsOf("]F[FF]", 2, 2).size(), 1U);
  const std::string deep(200, '[');
  const auto inner = partsOf(deep + "FF" + std::string(200, ']'), 2, 2);
  ASSERT_EQ(inner.size(), 1U);
  EXPECT_EQ(inner[0].firstModule, 200U);
}

}  // namespace
}  // namespace espalier::turtle::branch_parts_test
