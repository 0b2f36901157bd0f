#include "environment/base/state_numbers.h"

#include <utility>

#include "environment/base/state_bytes.h"

namespace espalier::environment {

std::string saveNumbers(const std::vector<double>& numbers) {
  StateWriter writer;
  writer.integer(numbers.size());
  for (const double number : numbers) {
    writer.number(number);
  }
  return writer.take();
}

std::optional<turtle::EnvironmentError> restoreNumbers(std::string_view state, std::string_view process,
                                                       std::vector<double>& numbers) {
  StateReader reader(state);
  std::vector<double> read;
  if (reader.integer() == numbers.size()) {
    read.reserve(numbers.size());
    while (reader.isIntact() && read.size() < numbers.size()) {
      read.push_back(reader.number());
    }
  }
  if (!reader.isComplete() || read.size() != numbers.size()) {
    return turtle::EnvironmentError{"The saved state of environment '" + std::string(process) +
                                        "' is damaged, or it has another size. Use a complete snapshot "
                                        "of this configuration.",
                                    false};
  }
  numbers = std::move(read);
  return std::nullopt;
}

}  // namespace espalier::environment
