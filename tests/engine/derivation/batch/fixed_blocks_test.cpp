#include "engine/derivation/batch/fixed_blocks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/support/derived_model.h"

namespace espalier::fixed_blocks_test {
namespace {

using core::ModuleTypeId;
using derivation::FixedBlocks;
using derivation::ProductionPlan;
using test::DerivedModel;
using test::modelText;

constexpr ModuleTypeId kUntouched = 0xFFFF;

/// Writes what random modules of a model become, by pairs and one by one, with no room to spare.
void compare(const std::string& productions, std::uint32_t seed) {
  DerivedModel model(modelText("", "ABCDE", productions));
  const ProductionPlan plan(model.program(), model.program().systems[0]);
  const FixedBlocks blocks(model.program(), plan);
  ASSERT_TRUE(blocks.hasTable());
  std::mt19937 random(seed);
  for (std::size_t count = 0; count < 100; ++count) {
    std::vector<ModuleTypeId> modules;
    std::vector<ModuleTypeId> wanted;
    for (std::size_t i = 0; i < count; ++i) {
      modules.push_back(static_cast<ModuleTypeId>(random() % model.program().moduleTypeCount()));
      const derivation::TypePlan& type = plan[modules.back()];
      wanted.insert(wanted.end(), plan.types() + type.firstType, plan.types() + type.firstType + type.length);
    }
    const std::size_t made = wanted.size();
    wanted.resize(made + 1, kUntouched);
    std::vector<ModuleTypeId> written(made + 1, kUntouched);
    EXPECT_EQ(blocks.write(modules.data(), count, written.data(), written.data() + made), written.data() + made);
    EXPECT_EQ(written, wanted) << count << " modules";
    // with room behind, what counts is the same
    written.assign(made + 200, kUntouched);
    EXPECT_EQ(blocks.write(modules.data(), count, written.data(), written.data() + written.size()),
              written.data() + made);
    written.resize(made);
    wanted.resize(made);
    EXPECT_EQ(written, wanted) << count << " modules";
  }
}

TEST(FixedBlocks, WritesTheSameTwoAtATimeAsOneByOne) {
  compare("A --> A[BA]\nB --> *\nC --> CC\n", 1);
}

TEST(FixedBlocks, BlocksThatDoNotFitATableAreWrittenWhole) {
  const std::string eleven = "ABCDEABCDEA";
  compare(
      "A --> " + eleven + eleven + eleven + eleven + "\nB --> " + eleven + eleven + "\nC --> " + eleven + "\nD --> *\n",
      2);
}

TEST(FixedBlocks, OnlyFewTypesWithoutParametersAndChoicesHaveATable) {
  const auto hasTable = [](const std::string& axiom, const std::string& productions) {
    DerivedModel model(modelText("", axiom, productions));
    const ProductionPlan plan(model.program(), model.program().systems[0]);
    return FixedBlocks(model.program(), plan).hasTable();
  };
  EXPECT_TRUE(hasTable("AB", "A --> AB\n"));
  EXPECT_FALSE(hasTable("AB(1)", "A --> AB(1)\n"));
  EXPECT_FALSE(hasTable("AB(1)", "A --> A\n"));
  EXPECT_FALSE(hasTable("AB", "A < B --> A\n"));
  EXPECT_FALSE(hasTable("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz", "A --> AB\n"));
  EXPECT_FALSE(FixedBlocks().hasTable());
}

}  // namespace
}  // namespace espalier::fixed_blocks_test
