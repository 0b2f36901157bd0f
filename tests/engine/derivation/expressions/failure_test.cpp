#include "engine/derivation/expressions/failure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/derived_model.h"

namespace espalier::failure_test {
namespace {

using core::SimulationErrorCode;
using derivation::FailurePlace;
using test::DerivedModel;
using test::modelText;

core::SimulationError caught(const language::Program& program, const FailurePlace& place, core::SourceRange range) {
  try {
    derivation::fail(program, place, SimulationErrorCode::Model, "it broke", range);
  } catch (const core::SimulationFailure& failure) {
    return failure.error();
  }
}

TEST(Failure, NamesStepPlantModuleAndPlace) {
  DerivedModel model(modelText("", "AB", "B --> A\n"));
  const core::SourceRange range = model.program().systems[0].productions.productions[0].range;
  FailurePlace place{7, 2, true, 1, model.program().findType("B", 0)};
  core::SimulationError error = caught(model.program(), place, range);
  EXPECT_EQ(error.message, "step 7, plant 2, module 1 ('B', model.l:4:1): it broke. The simulation stays at step 6.");
  EXPECT_EQ(error.step, 7U);
  EXPECT_EQ(error.plant, 2U);
  EXPECT_EQ(error.module, std::optional<std::uint64_t>(1));
  EXPECT_EQ(error.location.line, 4U);

  error = caught(model.program(), place, {});
  EXPECT_EQ(error.message, "step 7, plant 2, module 1 ('B'): it broke. The simulation stays at step 6.");
  place.hasModule = false;
  error = caught(model.program(), place, range);
  EXPECT_EQ(error.message, "step 7, plant 2 (model.l:4:1): it broke. The simulation stays at step 6.");
  EXPECT_FALSE(error.module.has_value());
}

TEST(Failure, SaysNothingAboutEarlierStepsWhileRewinding) {
  DerivedModel model(modelText("", "AB", "B --> A\n"));
  EXPECT_EQ(caught(model.program(), {}, {}).message, "step 0, plant 0: it broke.");
}

TEST(Failure, FoldsBlanksOfSourceText) {
  DerivedModel model(modelText("", "A", "A --> B(1 +\n\t  2)\n"));
  const language::Production& production = model.program().systems[0].productions.productions[0];
  EXPECT_EQ(derivation::sourceText(model.program(), production.range), "A --> B(1 + 2)");
}

TEST(Failure, NamesNonFiniteValues) {
  EXPECT_STREQ(derivation::nonFiniteName(std::nan("")), "NaN");
  EXPECT_STREQ(derivation::nonFiniteName(INFINITY), "infinite");
  EXPECT_STREQ(derivation::nonFiniteName(-INFINITY), "infinite");
}

}  // namespace
}  // namespace espalier::failure_test
