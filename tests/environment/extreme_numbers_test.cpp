// For all finite numbers that a model sends, a process answers with finite numbers, or fails and is as before.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/environment/candidates.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::extreme_numbers_test {
namespace {

class ExtremeNumbers : public testing::TestWithParam<Candidate> {};

constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
// as large as a square may be without being infinite
constexpr double kNumbers[] = {0.0,  -0.0,  1.0,   -1.0,  2.0,   0.5,  1e-9,      1e9,        -1e9,        1e18,
                               1e30, 1e-30, -1e30, 1e100, -1e70, -3.0, kSmallest, -kSmallest, 2147483648.0};

/// The queries of a step: `share` of their numbers are extreme, the others small.
turtle::QueryBatch randomBatch(const Candidate& candidate, std::uint64_t step, double share, std::mt19937_64& random) {
  std::uniform_int_distribution<std::size_t> which(0, std::size(kNumbers) - 1);
  std::uniform_int_distribution<std::size_t> length(candidate.name == "multiple" ? 1 : 0, candidate.parameterCount);
  std::uniform_real_distribution<double> place(0.0, 10.0);
  std::bernoulli_distribution isExtreme(share);
  const auto number = [&] { return isExtreme(random) ? kNumbers[which(random)] : place(random); };
  QueryBuilder builder;
  for (int i = 0; i < 12; ++i) {
    std::vector<double> parameters(length(random));
    std::generate(parameters.begin(), parameters.end(), number);
    if (candidate.name == "multiple") {
      parameters[0] = 1.0 + static_cast<double>(i % 2);
    }
    builder.add({number(), number(), number()}, parameters);
  }
  builder.batch().step = step;
  return builder.batch();
}

TEST_P(ExtremeNumbers, AreAnsweredWithFiniteNumbersOrRefused) {
  std::mt19937_64 random(3);
  for (int run = 0; run < 40; ++run) {
    const auto process = openProcess(GetParam().name, GetParam().configuration);
    ASSERT_TRUE(process);
    for (std::uint64_t step = 0; step < 3; ++step) {
      const turtle::QueryBatch queries = randomBatch(GetParam(), step, run % 4 == 0 ? 1.0 : 0.2, random);
      const std::string before = process->save();
      turtle::ReplyBatch replies;
      replies.prepare(queries);
      if (const auto error = process->step(queries, replies)) {
        EXPECT_TRUE(process->save() == before) << error->message;
        EXPECT_NE(error->message.find(GetParam().name), std::string::npos) << error->message;
        continue;
      }
      for (std::size_t query = 0; query < queries.size(); ++query) {
        for (std::uint64_t k = queries.parameterOffset[query]; k < queries.parameterOffset[query + 1]; ++k) {
          if (replies.isSet[k] != 0 && !std::isfinite(replies.values[k])) {
            std::string sent;
            for (const double value : queries.parametersOf(query)) {
              sent += " " + std::to_string(value);
            }
            FAIL() << "run " << run << " step " << step << " value " << k - queries.parameterOffset[query] + 1
                   << " of a query at " << queries.position[query].x << " " << queries.position[query].y << " "
                   << queries.position[query].z << " that sent" << sent << ": " << replies.values[k];
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Processes, ExtremeNumbers, testing::ValuesIn(candidates()), nameOf);

}  // namespace
}  // namespace espalier::environment::extreme_numbers_test
