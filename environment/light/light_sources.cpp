#include "environment/light/light_sources.h"

#include <string>

namespace espalier::environment {

std::vector<core::Diagnostic> problemsOfSources(std::string_view process, const ConfigurationRows& rows,
                                                bool areDirections) {
  std::vector<core::Diagnostic> problems;
  const auto add = [&](const std::string& message, const char* hint) {
    problems.push_back(wrongConfiguration(process, message, hint));
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& row = rows[i];
    const std::string place = "'sources[" + std::to_string(i) + "]'";
    if (row[3] < 0.0) {
      add(place + " has a negative weight", "its last number is the weight, relative to the other sources");
    }
    if (areDirections && row[0] == 0.0 && row[1] == 0.0 && row[2] == 0.0) {
      add(place + " has a direction of no length", "its first three numbers point towards the light");
    }
    sum += row[3];
  }
  if (!rows.empty() && sum == 0.0) {
    add("'sources' have the weight 0 together, so there is no light",
        "the last number of each source is its weight; leave 'sources' out for the usual light");
  }
  return problems;
}

}  // namespace espalier::environment
