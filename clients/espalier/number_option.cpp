#include "clients/espalier/number_option.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <optional>

#include "engine/core/number_text.h"

namespace espalier::command {

CLI::Option* addWholeNumber(CLI::App& command, const std::string& name, const std::string& help, std::uint64_t least,
                            std::uint64_t most, const std::function<void(std::uint64_t)>& set) {
  return command.add_option_function<std::string>(
      name,
      [name, least, most, set](const std::string& text) {
        std::uint64_t value = 0;
        const char* const end = text.data() + text.size();
        const auto [last, problem] = std::from_chars(text.data(), end, value);
        if (problem != std::errc() || last != end || value < least || value > most) {
          throw CLI::ValidationError(name, "'" + text + "' is not possible: give a whole number from " +
                                               std::to_string(least) + " to " + std::to_string(most));
        }
        set(value);
      },
      help);
}

CLI::Option* addPositiveNumber(CLI::App& command, const std::string& name, const std::string& help,
                               const std::string& unit, const std::function<void(double)>& set) {
  return command.add_option_function<std::string>(
      name,
      [name, unit, set](const std::string& text) {
        const std::optional<double> value = core::parseNumber(text);
        if (!value || !std::isfinite(*value) || *value <= 0.0) {
          throw CLI::ValidationError(name, "'" + text + "' is not possible: give " + unit + ", above 0");
        }
        set(*value);
      },
      help);
}

CLI::Validator numberFrom(double least, double most) {
  std::string range = "from ";
  core::appendNumber(range, least, core::NumberStyle::PercentG);
  range += " to ";
  core::appendNumber(range, most, core::NumberStyle::PercentG);
  return CLI::Validator(
      [least, most, range](std::string& text) -> std::string {
        const std::optional<double> value = core::parseNumber(text);
        return value && *value >= least && *value <= most ? std::string{}
                                                          : "'" + text + "' is not possible: give a number " + range;
      },
      "FLOAT " + range, "number");
}

}  // namespace espalier::command
