#include "tests/environment/candidates.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "environment/registry.h"
#include "tests/environment/query_builder.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::environment {

namespace {

/// The entries of one member of every process's file.
template <typename Visit>
void forEachCase(const char* member, const Visit& visit) {
  for (const std::string& name : processNames()) {
    const auto text = test::readFile(sourceFolder() + "/tests/environment/processes/" + name + ".json");
    const nlohmann::json cases = nlohmann::json::parse(text.value_or("{}"));
    for (const nlohmann::json& one : cases.value(member, nlohmann::json::array())) {
      // a text is a configuration that is no valid object
      const nlohmann::json& configuration = one.at("configuration");
      visit(name, configuration.is_string() ? configuration.get<std::string>() : configuration.dump(), one);
    }
  }
}

}  // namespace

void PrintTo(const Candidate& candidate, std::ostream* stream) {
  *stream << candidate.name << " " << candidate.configuration;
}

std::vector<Candidate> candidates() {
  std::vector<Candidate> all;
  forEachCase("queries", [&](const std::string& name, std::string configuration, const nlohmann::json& one) {
    all.push_back({name, std::move(configuration), one.at("parameters").get<std::size_t>()});
  });
  return all;
}

std::vector<BadConfiguration> badConfigurations() {
  std::vector<BadConfiguration> all;
  forEachCase("wrong", [&](const std::string& name, std::string configuration, const nlohmann::json& one) {
    BadConfiguration bad{name, std::move(configuration), one.at("says").get<std::string>()};
    bad.parameters = one.value("parameters", bad.parameters);
    all.push_back(std::move(bad));
  });
  return all;
}

turtle::QueryBatch queriesOf(const Candidate& candidate, std::uint64_t step, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(0.0, 10.0);
  QueryBuilder builder;
  for (std::size_t i = 0; i < 24; ++i) {
    std::vector<double> parameters(i % 6 == 5 && candidate.name != "multiple" ? 1 : candidate.parameterCount);
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      parameters[k] = k == 0 ? 1.0 + static_cast<double>(i % 2) : place(random) / 10.0;
    }
    builder.add({place(random), place(random), place(random)}, parameters);
  }
  builder.batch().step = step;
  return builder.batch();
}

std::string nameOf(const testing::TestParamInfo<Candidate>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name + std::to_string(info.index);
}

}  // namespace espalier::environment
