#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// The type of a configuration key.
enum class KeyKind : std::uint8_t {
  Number,   // a finite number
  Integer,  // a whole number
  Boolean,  // true or false
  Choice,   // one of ConfigurationKey::choices
  Text,     // any text
  Numbers,  // a list of numbers
  Rows,     // a list of lists of numbers
  Entries,  // a list of environments, each an object; kept as JSON text
};

/// One key of a process's configuration. Tables of these give the reader, the JSON Schema and the documentation.
struct ConfigurationKey {
  std::string_view name;
  KeyKind kind = KeyKind::Number;
  std::string_view description;                               // one sentence without a final full stop
  std::string_view unit = "1";                                // "length": the world's length unit
  double minimum = -std::numeric_limits<double>::infinity();  // of every number
  double maximum = std::numeric_limits<double>::infinity();
  bool isMinimumExclusive = false;
  bool isWhole = false;                         // Numbers, Rows: whole numbers only
  double defaultNumber = 0.0;                   // Number, Integer; Boolean: not 0 is true
  std::string_view defaultText{};               // Choice, Text
  std::span<const double> defaultNumbers{};     // Numbers
  std::span<const std::string_view> choices{};  // Choice
  std::size_t minimumCount = 0;                 // Numbers: of the list; Rows: of each row
  std::size_t maximumCount = std::numeric_limits<std::size_t>::max();
  bool isNumberAllowed = false;  // Numbers: a number stands for a list of one
};

using ConfigurationRows = std::vector<std::vector<double>>;
/// Number and Integer are doubles.
using ConfigurationValue =
    std::variant<double, bool, std::string, std::vector<double>, ConfigurationRows, std::vector<std::string>>;
using ConfigurationValues = std::map<std::string, ConfigurationValue, std::less<>>;

/// A checked configuration: every key of the table has a value of its kind and range, given or by default.
class Configuration {
 public:
  Configuration(ConfigurationValues values, std::vector<std::string> givenKeys)
      : values_(std::move(values)), givenKeys_(std::move(givenKeys)) {}

  [[nodiscard]] double number(std::string_view key) const;
  [[nodiscard]] std::int64_t integer(std::string_view key) const;
  [[nodiscard]] bool flag(std::string_view key) const;
  [[nodiscard]] const std::string& text(std::string_view key) const;
  [[nodiscard]] const std::vector<double>& numbers(std::string_view key) const;
  [[nodiscard]] const ConfigurationRows& rows(std::string_view key) const;
  [[nodiscard]] const std::vector<std::string>& entries(std::string_view key) const;
  /// Replaces the values of keys that the text does not have.
  void setDefaults(const ConfigurationValues& values);
  /// Whether the text has the key; otherwise its value is the default.
  [[nodiscard]] bool isGiven(std::string_view key) const;

 private:
  ConfigurationValues values_;
  std::vector<std::string> givenKeys_;
};

/// An error in one key. A caller that knows where the key was written sets the location.
struct ConfigurationError {
  std::string key;  // empty: the whole text
  core::Diagnostic diagnostic;
};

/// The error "environment process 'wind': MESSAGE" with a hint.
[[nodiscard]] core::Diagnostic wrongConfiguration(std::string_view process, const std::string& message,
                                                  std::string hint);

/// Reads the JSON text of an object by a table of keys; empty or blank text means all defaults. Returns all errors,
/// each with the name of the process and the key's path ("values[2]"): malformed JSON (with line and column), unknown
/// key (with the nearest one), key written twice, wrong type, value out of range; of a list the first wrong number.
/// Beside the range of its key a number is at most 10³⁰ in size, and one that must be above 0 at least 10⁻³⁰. O(text).
[[nodiscard]] tl::expected<Configuration, std::vector<ConfigurationError>> readConfiguration(
    std::string_view process, std::span<const ConfigurationKey> keys, std::string_view json);

/// Tables of keys, or of published keywords, one after another.
template <typename Row, std::size_t... n>
[[nodiscard]] constexpr auto joinTables(const std::array<Row, n>&... tables) {
  std::array<Row, (n + ...)> joined;
  auto next = joined.begin();
  ((next = std::copy(tables.begin(), tables.end(), next)), ...);
  return joined;
}

/// The JSON Schema (draft 2020-12) of a table of keys, with units and defaults.
[[nodiscard]] std::string writeSchema(std::string_view process, std::string_view summary,
                                      std::span<const ConfigurationKey> keys);

/// The JSON text of the given values, which must not be Entries. readConfiguration reads it back exactly.
[[nodiscard]] std::string writeConfiguration(const ConfigurationValues& values);

}  // namespace espalier::environment
