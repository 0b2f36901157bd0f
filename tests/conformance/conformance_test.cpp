// The suite of the cpfg dialect, case by case: all in the mode that reproduces the reference, and the deterministic
// ones with Espalier's own numbers, where those that must differ are named in a list that may only shrink.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/conformance/suite.h"

namespace espalier::test::conformance_test {
namespace {

constexpr const char* kOwnNumbers = "own_numbers_exceptions.txt";

std::vector<ConformanceCase> deterministicCases() {
  std::vector<ConformanceCase> cases = readCases();
  std::erase_if(cases, [](const ConformanceCase& entry) { return entry.kind != "deterministic"; });
  return cases;
}

std::string testName(const testing::TestParamInfo<ConformanceCase>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// The largest deviations that a suite accepted, printed when all tests have run, so that drift shows.
class DeviationReport : public testing::Environment {
 public:
  void add(const std::string& suite, const std::string& name, const Deviation& deviation) {
    if (deviation.share > 0.0) {
      accepted_[suite].emplace_back(deviation.share, name + ", " + deviation.place);
    }
  }

  void TearDown() override {
    constexpr std::size_t kShown = 3;
    for (auto& [suite, deviations] : accepted_) {
      std::sort(deviations.rbegin(), deviations.rend());
      std::printf("%s: %zu cases deviate within the tolerance; the largest deviations as shares of it:\n",
                  suite.c_str(), deviations.size());
      for (std::size_t i = 0; i < std::min(deviations.size(), kShown); ++i) {
        std::printf("  %.3f %s\n", deviations[i].first, deviations[i].second.c_str());
      }
    }
  }

 private:
  std::map<std::string, std::vector<std::pair<double, std::string>>> accepted_;
};

// GoogleTest owns and ends it
DeviationReport* const kReport = [] {
  auto report = std::make_unique<DeviationReport>();
  DeviationReport* const shared = report.get();
  testing::AddGlobalTestEnvironment(report.release());
  return shared;
}();

/// Runs a case and reports the largest deviation that it accepts.
std::string runAndReport(const std::string& suite, const ConformanceCase& entry, core::Compatibility compatibility) {
  Deviation largest;
  const std::string difference = runCase(entry, compatibility, largest);
  kReport->add(suite, entry.name, largest);
  testing::Test::RecordProperty("largest_deviation", std::to_string(largest.share));
  return difference;
}

class Conformance : public testing::TestWithParam<ConformanceCase> {};
class OwnNumbers : public testing::TestWithParam<ConformanceCase> {};

TEST_P(Conformance, MatchesTheReference) {
  const std::string difference = runAndReport("Conformance", GetParam(), core::Compatibility::Cpfg);
  EXPECT_TRUE(difference.empty()) << GetParam().name << ": " << difference;
}

TEST_P(OwnNumbers, MatchTheReferenceWithinTheTolerance) {
  const std::string difference = runAndReport("OwnNumbers", GetParam(), core::Compatibility::Espalier);
  const std::string verdict = judge(GetParam(), difference, readExceptions(listFile(kOwnNumbers)), kOwnNumbers);
  EXPECT_TRUE(verdict.empty()) << GetParam().name << ": " << verdict;
}

INSTANTIATE_TEST_SUITE_P(Suite, Conformance, testing::ValuesIn(readCases()), testName);
INSTANTIATE_TEST_SUITE_P(Suite, OwnNumbers, testing::ValuesIn(deterministicCases()), testName);

TEST(ConformanceSuite, HasAllItsCases) {
  // 162 deterministic, 10 stochastic, 10 random, 36 environment (cases/README.md)
  std::map<std::string, int> count;
  for (const ConformanceCase& entry : readCases()) {
    ++count[entry.kind];
  }
  EXPECT_EQ(count, (std::map<std::string, int>{
                       {"deterministic", 162}, {"stochastic", 10}, {"random", 10}, {"environment", 36}}));
}

TEST(ConformanceSuite, ListNamesOnlyCasesAndGivesReasons) {
  const std::vector<ConformanceCase> cases = readCases();
  for (const auto& [name, reason] : readExceptions(listFile(kOwnNumbers))) {
    const auto isNamed = [&name = name](const ConformanceCase& entry) { return entry.name == name; };
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), isNamed)) << name << " in the list is not a case";
    EXPECT_FALSE(reason.empty()) << name << " in the list has no reason";
  }
}

TEST(ConformanceSuite, JudgesByTheList) {
  ConformanceCase listed;
  listed.name = "listed";
  ConformanceCase other;
  other.name = "other";
  const std::map<std::string, std::string> list{{"listed", "reason"}};
  EXPECT_EQ(judge(other, "", list, "list"), "");
  EXPECT_EQ(judge(other, "step 1 differs", list, "list"), "step 1 differs");
  EXPECT_EQ(judge(listed, "step 1 differs", list, "list"), "");
  EXPECT_EQ(judge(listed, "", list, "list"), "listed passes now: remove it from list");
}

}  // namespace
}  // namespace espalier::test::conformance_test
