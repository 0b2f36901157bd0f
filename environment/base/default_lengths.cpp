#include "environment/base/default_lengths.h"

#include <string>

namespace espalier::environment {

namespace {

/// The power of a length in the unit of a key: 1 in "length/day", -3 in "mol/length^3", 0 in "degree".
int powerOfLength(std::string_view unit) {
  constexpr std::string_view kLength = "length";
  const std::size_t at = unit.find(kLength);
  if (at == std::string_view::npos) {
    return 0;
  }
  const std::size_t behind = at + kLength.size();
  const int power = behind + 1 < unit.size() && unit[behind] == '^' ? unit[behind + 1] - '0' : 1;
  return unit.substr(0, at).find('/') == std::string_view::npos ? power : -power;
}

double converted(double value, int power, double metres) {
  for (; power > 0; --power) {
    value /= metres;
  }
  for (; power < 0; ++power) {
    value *= metres;
  }
  return value;
}

}  // namespace

Configuration withDefaultLengths(Configuration configuration, std::span<const ConfigurationKey> keys,
                                 const LengthUnit* unit) {
  if (unit == nullptr || unit->metres == 1.0) {
    return configuration;
  }
  ConfigurationValues values;
  for (const ConfigurationKey& key : keys) {
    const int power = powerOfLength(key.unit);
    if (power == 0 || configuration.isGiven(key.name)) {
      continue;
    }
    if (key.kind == KeyKind::Number) {
      values.emplace(key.name, converted(configuration.number(key.name), power, unit->metres));
    } else if (key.kind == KeyKind::Numbers) {
      std::vector<double> numbers = configuration.numbers(key.name);
      for (double& number : numbers) {
        number = converted(number, power, unit->metres);
      }
      values.emplace(key.name, std::move(numbers));
    }
  }
  configuration.setDefaults(values);
  return configuration;
}

}  // namespace espalier::environment
