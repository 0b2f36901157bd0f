#include "tests/environment/candidates.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "environment/registry.h"
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

std::string nameOf(const testing::TestParamInfo<Candidate>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name + std::to_string(info.index);
}

}  // namespace espalier::environment
