#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// A process with a configuration in which its queries matter to each other.
struct Candidate {
  std::string name;
  std::string configuration;
  std::size_t parameterCount;  // of a query, at most
};

/// A configuration that its process refuses when it is made, opened or asked, and a part of the message.
struct BadConfiguration {
  std::string name;
  std::string configuration;
  std::string said;
  std::vector<double> parameters{1.0, 1.0, 1.0};  // of the query
};

void PrintTo(const Candidate& candidate, std::ostream* stream);

/// The members "queries" of tests/environment/processes/NAME.json, for all processes of the registry.
[[nodiscard]] std::vector<Candidate> candidates();

/// The members "wrong" of the same files.
[[nodiscard]] std::vector<BadConfiguration> badConfigurations();

/// Queries at random places for a step of a candidate; some have one parameter only.
[[nodiscard]] turtle::QueryBatch queriesOf(const Candidate& candidate, std::uint64_t step, std::mt19937_64& random);

/// The name of a test of a candidate.
[[nodiscard]] std::string nameOf(const testing::TestParamInfo<Candidate>& info);

}  // namespace espalier::environment
