#include "engine/derivation/state/step_changes.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "tests/support/derived_model.h"

namespace espalier::derivation::step_changes_test {
namespace {

using Kept = std::vector<KeptModules>;
using test::DerivedModel;

// type 0 has no parameter, type 1 has one, type 2 has two
constexpr std::array<std::uint16_t, 3> kArity{0, 1, 2};

ModuleString stringOf(const std::vector<std::pair<int, double>>& modules) {
  ModuleString string;
  for (const auto& [type, value] : modules) {
    const std::array parameters{value, value};
    string.append(static_cast<core::ModuleTypeId>(type),
                  std::span(parameters).first(kArity[static_cast<unsigned>(type)]));
  }
  return string;
}

Kept between(const std::vector<std::pair<int, double>>& older, const std::vector<std::pair<int, double>>& newer) {
  return StepChanges::between(stringOf(older), stringOf(newer), kArity).kept();
}

TEST(StepChanges, OfTwoStringsAreWhatBothEndsShare) {
  EXPECT_EQ(between({{0, 0}, {1, 1}, {2, 2}}, {{0, 0}, {1, 1}, {2, 2}}), (Kept{{0, 0, 3}}));
  EXPECT_EQ(between({{0, 0}, {1, 1}, {2, 2}}, {{0, 0}, {1, 9}, {2, 2}}), (Kept{{0, 0, 1}, {2, 2, 1}}));
  // an insertion, and a removal
  EXPECT_EQ(between({{0, 0}, {2, 2}}, {{0, 0}, {1, 1}, {2, 2}}), (Kept{{0, 0, 1}, {1, 2, 1}}));
  EXPECT_EQ(between({{0, 0}, {1, 1}, {2, 2}}, {{0, 0}, {2, 2}}), (Kept{{0, 0, 1}, {2, 1, 1}}));
  // the same number elsewhere, the same type with another number
  EXPECT_EQ(between({{1, 1}}, {{2, 1}}), Kept{});
  EXPECT_EQ(between({{0, 0}, {0, 0}, {0, 0}}, {{0, 0}, {0, 0}}), (Kept{{0, 0, 2}}));
  EXPECT_EQ(between({}, {{0, 0}}), Kept{});
  EXPECT_EQ(between({{0, 0}}, {}), Kept{});
  EXPECT_EQ(StepChanges().kept(), Kept{});
  EXPECT_EQ(StepChanges::nothing(7).kept(), (Kept{{0, 0, 7}}));
  EXPECT_EQ(StepChanges::nothing(0).kept(), Kept{});
}

TEST(StepChanges, OfParametersAreTheRunsBetweenThem) {
  const std::vector<std::uint64_t> modules{100, 100, 110, 500};
  EXPECT_EQ(StepChanges::ofParameters(modules, 1000).kept(), (Kept{{0, 0, 100}, {112, 112, 388}, {502, 502, 498}}));
  EXPECT_EQ(StepChanges::ofParameters({}, 1000).kept(), (Kept{{0, 0, 1000}}));
  EXPECT_EQ(StepChanges::ofParameters(std::vector<std::uint64_t>{0, 999}, 1000).kept(), (Kept{{2, 2, 997}}));
}

TEST(StepChanges, InARowKeepWhatEachOfThemKeeps) {
  StepChanges first;
  first.keep(0, 0, 100);
  first.keep(100, 100, 100);
  first.keep(300, 400, 100);
  EXPECT_EQ(first.kept(), (Kept{{0, 0, 200}, {300, 400, 100}}));
  StepChanges second;
  second.keep(50, 60, 100);
  second.keep(160, 170, 290);
  EXPECT_EQ(first.then(second).kept(), (Kept{{50, 60, 100}, {160, 170, 40}, {300, 410, 50}}));
  EXPECT_EQ(first.then(StepChanges::nothing(500)), first);
  EXPECT_EQ(StepChanges::nothing(400).then(first), first);
  EXPECT_EQ(first.then({}), StepChanges());
}

TEST(StepChanges, OfRandomEditsInARowEqualAComparisonOfTheStrings) {
  // each module has a name of its own, so that the comparison is exact
  std::mt19937 dice(3);
  const auto draw = [&dice](std::uint64_t bound) { return static_cast<std::uint64_t>(dice()) % bound; };
  for (int round = 0; round < 300; ++round) {
    double nextName = 0.0;
    std::vector<std::pair<int, double>> first;
    for (std::uint64_t i = draw(60); i > 0; --i) {
      first.emplace_back(static_cast<int>(draw(2)) + 1, ++nextName);
    }
    std::vector<std::pair<int, double>> now = first;
    StepChanges joined = StepChanges::nothing(first.size());
    for (std::uint64_t edits = draw(8); edits > 0; --edits) {
      const ModuleString before = stringOf(now);
      const auto at = now.begin() + static_cast<std::ptrdiff_t>(draw(now.size() + 1));
      if (draw(2) == 0 && at != now.end()) {
        now.erase(at);
      } else {
        now.insert(at, {static_cast<int>(draw(2)) + 1, ++nextName});
      }
      joined = joined.then(StepChanges::between(before, stringOf(now), kArity));
    }
    // the full comparison: where each module of the first string is now
    StepChanges expected;
    for (std::size_t to = 0; to < now.size(); ++to) {
      for (std::size_t from = 0; from < first.size(); ++from) {
        if (first[from] == now[to]) {
          expected.keep(from, to, 1);
        }
      }
    }
    ASSERT_EQ(joined, expected) << "round " << round;
  }
}

TEST(StepChanges, ALongStringKeepsWhatDoesNotGrow) {
  std::string rest;
  for (int i = 0; i < 20'000; ++i) {
    rest += i % 3 == 0 ? "F(1)" : "+(7)";
  }
  struct Case {
    const char* rules;
    unsigned threads;
  };
  // in batches, one at a time because of a block, and both on two threads
  for (const Case& model :
       {Case{"A(x) --> F(x)A(x+1)\n", 1}, Case{"A(x) --> F(x)A(x+1)\n", 2},
        Case{"A(x) : x >= 0 {n = x + 1;} --> F(x)A(n)\n", 1}, Case{"A(x) : x >= 0 {n = x + 1;} --> F(x)A(n)\n", 2}}) {
    DerivationOptions options;
    options.threads = model.threads;
    options.threadedModules = 1;
    DerivedModel run(test::modelText("", rest + "A(0)" + rest, model.rules), options);
    StepChanges joined = StepChanges::nothing(run.state().string.size());
    for (std::uint64_t step = 1; step < 5; ++step) {
      StepChanges changes;
      run.derivation().derive(run.state(), &changes);
      joined = joined.then(changes);
      EXPECT_EQ(joined.kept(), (Kept{{0, 0, 20'000}, {20'001, 20'001 + step, 20'000}})) << model.rules << model.threads;
    }
  }
}

TEST(StepChanges, BeginAnewAfterAFailedStep) {
  DerivedModel model(test::modelText("", "F(1)F(1)A(1)", "A(x) : x > 0 --> A(x-1)\nA(x) --> A(exp(1000))\n"));
  StepChanges changes;
  model.derivation().derive(model.state(), &changes);
  EXPECT_EQ(changes.kept(), (Kept{{0, 0, 2}}));
  EXPECT_THROW(model.derivation().derive(model.state(), &changes), core::SimulationFailure);
  model.state().string.setParameter(2, 1.0);
  model.derivation().derive(model.state(), &changes);
  EXPECT_EQ(changes.kept(), (Kept{{0, 0, 2}}));
}

}  // namespace
}  // namespace espalier::derivation::step_changes_test
