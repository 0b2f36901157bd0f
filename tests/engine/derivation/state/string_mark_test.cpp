#include "engine/derivation/state/string_mark.h"

#include <gtest/gtest.h>

#include <array>

#include "engine/derivation/state/module_string.h"
#include "tests/support/derived_model.h"

namespace espalier::derivation {
namespace {

using Kept = std::vector<KeptModules>;
using test::DerivedModel;

ModuleString stringOf(std::size_t modules) {
  ModuleString string;
  for (std::size_t i = 0; i < modules; ++i) {
    string.append(1, std::array{0.5});
  }
  return string;
}

TEST(StringMark, IsForgottenByWhateverChangesTheContents) {
  const auto forgets = [](auto change) {
    ModuleString string = stringOf(3);
    const auto mark = string.marked();
    EXPECT_EQ(string.mark(), mark);
    change(string);
    return string.mark() != mark;
  };
  EXPECT_FALSE(forgets([](ModuleString& string) { static_cast<void>(string.parameters()); }));
  EXPECT_FALSE(forgets([](ModuleString& string) { static_cast<void>(string.marked()); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.mutableParameters()[1] = 2.0; }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.setParameter(1, 2.0); }));
  EXPECT_FALSE(forgets([](ModuleString& string) { string.setParameter(1, 0.5); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.append(1, {}); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.appendAll({}, std::array{1.0}); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.typeBuffer().data()[0] = 2; }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.parameterBuffer().resize(1); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string.clear(); }));
  EXPECT_TRUE(forgets([](ModuleString& string) { string = stringOf(3); }));
  EXPECT_TRUE(forgets([](ModuleString& string) {
    string.append(1, {});
    string.typeBuffer().resize(3);
  }));
}

TEST(StringMark, GoesWithTheContents) {
  ModuleString string = stringOf(3);
  const auto mark = string.marked();
  ModuleString other = stringOf(5);
  string.swap(other);
  EXPECT_EQ(string.mark(), nullptr);
  EXPECT_EQ(other.mark(), mark);
  const ModuleString copy = other;
  EXPECT_EQ(copy.mark(), mark);
  const ModuleString moved = std::move(other);
  EXPECT_EQ(moved.mark(), mark);
  EXPECT_EQ(keptModules(*mark, moved.mark(), 3), (Kept{{0, 0, 3}}));
  EXPECT_TRUE(keptModules(*mark, nullptr, 3).empty());
}

TEST(StringMark, IsRememberedBesideParametersThatWereSet) {
  ModuleString string = stringOf(2'000);
  const auto mark = string.marked();
  EXPECT_FALSE(string.wereSet(0, 2'000));
  string.setParameter(1'000, 0.75);
  EXPECT_EQ(string.parameters()[1'000], 0.75);
  EXPECT_EQ(string.mark(), nullptr);
  EXPECT_EQ(string.earlierMark(), mark);
  EXPECT_TRUE(string.wereSet(0, 2'000));
  EXPECT_TRUE(string.wereSet(1'000, 1));
  EXPECT_FALSE(string.wereSet(1'000, 0));
  EXPECT_FALSE(string.wereSet(0, 700));
  EXPECT_FALSE(string.wereSet(1'300, 700));
  ModuleString other;
  other.swap(string);
  EXPECT_EQ(other.earlierMark(), mark);
  EXPECT_TRUE(other.wereSet(1'000, 1));
  EXPECT_FALSE(string.wereSet(0, 1));
  static_cast<void>(other.mutableParameters());
  EXPECT_EQ(other.earlierMark(), nullptr);
  EXPECT_FALSE(other.wereSet(1'000, 1));
  other.setParameter(1'000, 0.25);
  EXPECT_FALSE(other.wereSet(1'000, 1));
}

TEST(StringMark, OfSeveralStepsIsWhatAllOfThemKeep) {
  KeptModulesRecorder recorder;
  const auto first = std::make_shared<const StringMark>();
  const auto asked = first;
  recorder.begin(first);
  recorder.note(0, 0, 100);
  recorder.note(100, 100, 100);
  recorder.note(300, 400, 100);
  auto second = recorder.finish();
  EXPECT_EQ(keptModules(*first, second, 1000), (Kept{{0, 0, 200}, {300, 400, 100}}));

  // nobody keeps the second
  recorder.begin(second);
  recorder.note(50, 60, 100);
  recorder.note(160, 170, 290);
  const auto third = recorder.finish();
  EXPECT_EQ(keptModules(*first, third, 1000), (Kept{{50, 60, 100}, {160, 170, 40}, {300, 410, 50}}));
  EXPECT_TRUE(keptModules(*second, third, 1000).empty());

  // somebody does
  const auto kept = second;
  recorder.begin(second);
  recorder.note(7, 8, 9);
  EXPECT_EQ(keptModules(*second, recorder.finish(), 1000), (Kept{{7, 8, 9}}));
}

TEST(StringMark, NobodyKeepsNothingIsNoted) {
  KeptModulesRecorder recorder;
  recorder.begin(nullptr);
  recorder.note(0, 0, 100);
  EXPECT_EQ(recorder.finish(), nullptr);
  auto first = std::make_shared<const StringMark>();
  recorder.begin(first);
  recorder.note(0, 0, 100);
  EXPECT_EQ(recorder.finish(), nullptr);
  // or no longer
  auto asked = first;
  recorder.begin(first);
  recorder.note(0, 0, 100);
  const auto second = recorder.finish();
  ASSERT_NE(second, nullptr);
  asked = nullptr;
  first = nullptr;
  recorder.begin(second);
  recorder.note(0, 0, 100);
  EXPECT_EQ(recorder.finish(), nullptr);
}

TEST(StringMark, ALongStringKeepsWhatIsNeitherNearWhatGrowsNorNearAnAnswer) {
  std::string rest;
  for (int i = 0; i < 20'000; ++i) {
    rest += i % 3 == 0 ? "F(1)" : "+(7)";
  }
  for (const unsigned threads : {1U, 2U}) {
    DerivationOptions options;
    options.threads = threads;
    options.threadedModules = 1;
    DerivedModel model(test::modelText("", rest + "A(0)" + rest, "A(x) --> F(x)A(x+1)\n"), options);
    const auto mark = model.state().string.marked();
    for (std::uint64_t step = 1; step < 5; ++step) {
      // an answer
      model.state().string.setParameter(6'600, static_cast<double>(step) + 0.5);
      model.steps(1);
      const Kept kept = keptModules(*mark, model.state().string.mark(), model.state().string.size());
      ASSERT_EQ(kept.size(), 3U);
      EXPECT_EQ(kept[0].from, 0U);
      EXPECT_EQ(kept[0].to, 0U);
      EXPECT_GT(kept[0].modules, 4'000U);
      EXPECT_LE(kept[0].modules, 6'600U);
      EXPECT_GT(kept[1].from, 6'600U);
      EXPECT_EQ(kept[1].to, kept[1].from);
      EXPECT_GT(kept[1].modules, 9'000U);
      EXPECT_EQ(kept[2].to, kept[2].from + step);
      EXPECT_GT(kept[2].modules, 17'900U);
      EXPECT_EQ(kept[2].to + kept[2].modules, model.state().string.size());
    }
  }
}

}  // namespace
}  // namespace espalier::derivation
