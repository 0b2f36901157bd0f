#include "environment/base/configuration.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "engine/core/check.h"
#include "environment/base/json_text.h"
#include "environment/base/number_text.h"

namespace espalier::environment {

namespace {

using nlohmann::json;

/// Keys of processes, and those of files that the command line and the server read into them.
constexpr std::pair<std::string_view, std::string_view> kFileKeys[] = {
    {"triangles", "meshFile"}, {"spheres", "pointFile"}, {"points", "pointFile"}, {"heightField", "terrainFile"}};

/// No number of a configuration is larger: powers and products of these are finite. A size above 0 is not smaller:
/// their quotients are.
constexpr double kLargestNumber = 1e30;
constexpr double kSmallestSize = 1e-30;

std::string rangeText(const ConfigurationKey& key) {
  const bool hasMaximum = std::isfinite(key.maximum);
  if (std::isfinite(key.minimum) && hasMaximum && !key.isMinimumExclusive) {
    return "between " + numberText(key.minimum) + " and " + numberText(key.maximum);
  }
  std::string text;
  if (std::isfinite(key.minimum)) {
    text = (key.isMinimumExclusive ? "greater than " : "at least ") + numberText(key.minimum);
  }
  if (hasMaximum) {
    text += std::string(text.empty() ? "" : " and ") + "at most " + numberText(key.maximum);
  }
  return text;
}

std::string countText(const ConfigurationKey& key) {
  if (key.minimumCount == key.maximumCount) {
    return std::to_string(key.minimumCount) + " numbers";
  }
  if (key.maximumCount == std::numeric_limits<std::size_t>::max()) {
    return key.minimumCount == 0 ? "numbers" : "at least " + std::to_string(key.minimumCount) + " numbers";
  }
  return std::to_string(key.minimumCount) + " to " + std::to_string(key.maximumCount) + " numbers";
}

std::string expectedText(const ConfigurationKey& key) {
  switch (key.kind) {
    case KeyKind::Number:
      return "a number";
    case KeyKind::Integer:
      return "a whole number";
    case KeyKind::Boolean:
      return "true or false";
    case KeyKind::Choice: {
      std::string text = "one of";
      for (const std::string_view choice : key.choices) {
        text += (choice == key.choices.front() ? " '" : ", '") + std::string(choice) + "'";
      }
      return text;
    }
    case KeyKind::Text:
      return "a text";
    case KeyKind::Numbers:
      return "a list of " + countText(key) + (key.isNumberAllowed ? ", or a number" : "");
    case KeyKind::Rows:
      return "a list of lists of " + countText(key);
    case KeyKind::Entries:
      return "a list of environments";
  }
  return {};
}

json defaultJson(const ConfigurationKey& key) {
  switch (key.kind) {
    case KeyKind::Number:
      return key.defaultNumber;
    case KeyKind::Integer:
      return static_cast<std::int64_t>(key.defaultNumber);
    case KeyKind::Boolean:
      return key.defaultNumber != 0.0;
    case KeyKind::Choice:
    case KeyKind::Text:
      return std::string(key.defaultText);
    case KeyKind::Numbers:
      return std::vector<double>(key.defaultNumbers.begin(), key.defaultNumbers.end());
    case KeyKind::Rows:
    case KeyKind::Entries:
      return json::array();
  }
  return nullptr;
}

/// Reads the values of one object and collects the errors.
class ConfigurationReader {
 public:
  ConfigurationReader(std::string_view process, std::span<const ConfigurationKey> keys)
      : process_(process), keys_(keys) {}

  tl::expected<Configuration, std::vector<ConfigurationError>> read(const json& object) {
    std::vector<std::string> given;
    for (const auto& [name, value] : object.items()) {
      given.push_back(name);
      const auto key =
          std::find_if(keys_.begin(), keys_.end(), [&name = name](const auto& k) { return k.name == name; });
      if (key == keys_.end()) {
        addUnknownKey(name);
      } else if (auto read = readValue(*key, value)) {
        values_.insert_or_assign(name, std::move(*read));
      }
    }
    if (!errors_.empty()) {
      return tl::unexpected(takeErrors());
    }
    for (const ConfigurationKey& key : keys_) {
      values_.try_emplace(std::string(key.name), readDefault(key));
    }
    return Configuration(std::move(values_), std::move(given));
  }

  void add(std::string key, const std::string& message, std::string hint = {}) {
    errors_.push_back({std::move(key), wrongConfiguration(process_, message, std::move(hint))});
  }
  std::vector<ConfigurationError> takeErrors() { return std::move(errors_); }

 private:
  void addUnknownKey(const std::string& name) {
    std::vector<std::string_view> names;
    for (const ConfigurationKey& key : keys_) {
      names.push_back(key.name);
      // the command line and the server replace these by the keys
      for (const auto& [target, fileKey] : kFileKeys) {
        if (key.name == target) {
          names.push_back(fileKey);
        }
      }
    }
    std::sort(names.begin(), names.end());
    add(name, "unknown key '" + name + "'",
        names.empty() ? "this process has no configuration" : core::suggestName(name, names));
  }

  void addWrongType(const ConfigurationKey& key, const std::string& path, std::string_view expected,
                    const json& value) {
    add(std::string(key.name), "'" + path + "' must be " + std::string(expected) + ", found " + foundText(value),
        std::string(key.name) + ": " + std::string(key.description));
  }

  std::optional<double> readNumber(const ConfigurationKey& key, const std::string& path, const json& value) {
    const bool isWhole = key.kind == KeyKind::Integer || key.isWhole;
    if (!value.is_number()) {
      addWrongType(key, path, isWhole ? "a whole number" : "a number", value);
      return std::nullopt;
    }
    const double number = value.get<double>();
    if (isWhole && number != std::floor(number)) {
      addWrongType(key, path, "a whole number", value);
      return std::nullopt;
    }
    const bool isBelow = key.isMinimumExclusive ? number <= key.minimum : number < key.minimum;
    if (isBelow || number > key.maximum) {
      add(std::string(key.name), "'" + path + "' must be " + rangeText(key) + ", found " + numberText(number),
          std::string(key.name) + ": " + std::string(key.description));
      return std::nullopt;
    }
    const bool isTooSmall = key.isMinimumExclusive && key.minimum == 0.0 && number < kSmallestSize;
    if (isTooSmall || std::abs(number) > kLargestNumber) {
      add(std::string(key.name),
          "'" + path + "' must be " +
              (isTooSmall ? "at least " + numberText(kSmallestSize)
                          : "between " + numberText(-kLargestNumber) + " and " + numberText(kLargestNumber)) +
              ", found " + numberText(number),
          std::string(key.name) + ": " + std::string(key.description));
      return std::nullopt;
    }
    return number;
  }

  std::optional<std::vector<double>> readNumbers(const ConfigurationKey& key, const std::string& path,
                                                 const json& value) {
    if (!value.is_array()) {
      const bool isList = key.kind == KeyKind::Numbers;
      addWrongType(key, path, isList ? expectedText(key) : "a list of " + countText(key), value);
      return std::nullopt;
    }
    if (value.size() < key.minimumCount || value.size() > key.maximumCount) {
      add(std::string(key.name),
          "'" + path + "' must be a list of " + countText(key) + ", found " + std::to_string(value.size()),
          std::string(key.name) + ": " + std::string(key.description));
      return std::nullopt;
    }
    // the first wrong number of a list stands for the others
    std::vector<double> numbers;
    for (std::size_t i = 0; i < value.size(); ++i) {
      const auto number = readNumber(key, path + "[" + std::to_string(i) + "]", value[i]);
      if (!number) {
        return std::nullopt;
      }
      numbers.push_back(*number);
    }
    return numbers;
  }

  std::optional<ConfigurationValue> readRows(const ConfigurationKey& key, const json& value) {
    if (!value.is_array()) {
      addWrongType(key, std::string(key.name), expectedText(key), value);
      return std::nullopt;
    }
    if (!value.empty() && std::all_of(value.begin(), value.end(), [](const json& part) { return part.is_number(); })) {
      add(std::string(key.name),
          "'" + std::string(key.name) + "' must be " + expectedText(key) + ", found a list of numbers",
          "write [[" + numberText(value[0].get<double>()) + ", …]]. " + std::string(key.name) + ": " +
              std::string(key.description));
      return std::nullopt;
    }
    ConfigurationRows rows;
    bool isComplete = true;
    for (std::size_t i = 0; i < value.size(); ++i) {
      auto row = readNumbers(key, std::string(key.name) + "[" + std::to_string(i) + "]", value[i]);
      isComplete = isComplete && row.has_value();
      rows.push_back(row ? std::move(*row) : std::vector<double>{});
    }
    return isComplete ? std::optional<ConfigurationValue>(std::move(rows)) : std::nullopt;
  }

  std::optional<ConfigurationValue> readValue(const ConfigurationKey& key, const json& value) {
    const std::string path(key.name);
    switch (key.kind) {
      case KeyKind::Number:
      case KeyKind::Integer: {
        const auto number = readNumber(key, path, value);
        return number ? std::optional<ConfigurationValue>(*number) : std::nullopt;
      }
      case KeyKind::Boolean:
        if (value.is_boolean()) {
          return value.get<bool>();
        }
        break;
      case KeyKind::Choice:
        if (value.is_string()) {
          auto text = value.get<std::string>();
          if (std::find(key.choices.begin(), key.choices.end(), text) != key.choices.end()) {
            return text;
          }
          add(path, "'" + path + "' must be " + expectedText(key) + ", found '" + text + "'",
              core::suggestName(text, {key.choices.begin(), key.choices.end()}));
          return std::nullopt;
        }
        break;
      case KeyKind::Text:
        if (value.is_string()) {
          return value.get<std::string>();
        }
        break;
      case KeyKind::Numbers: {
        if (key.isNumberAllowed && value.is_number()) {
          const auto number = readNumber(key, path, value);
          return number ? std::optional<ConfigurationValue>(std::vector{*number}) : std::nullopt;
        }
        auto numbers = readNumbers(key, path, value);
        return numbers ? std::optional<ConfigurationValue>(std::move(*numbers)) : std::nullopt;
      }
      case KeyKind::Rows:
        return readRows(key, value);
      case KeyKind::Entries:
        if (value.is_array()) {
          std::vector<std::string> entries;
          for (const json& entry : value) {
            entries.push_back(entry.dump());
          }
          return entries;
        }
        break;
    }
    addWrongType(key, path, expectedText(key), value);
    return std::nullopt;
  }

  ConfigurationValue readDefault(const ConfigurationKey& key) {
    switch (key.kind) {
      case KeyKind::Boolean:
        return key.defaultNumber != 0.0;
      case KeyKind::Choice:
      case KeyKind::Text:
        return std::string(key.defaultText);
      case KeyKind::Numbers:
        return std::vector<double>(key.defaultNumbers.begin(), key.defaultNumbers.end());
      case KeyKind::Rows:
        return ConfigurationRows{};
      case KeyKind::Entries:
        return std::vector<std::string>{};
      case KeyKind::Number:
      case KeyKind::Integer:
        break;
    }
    return key.defaultNumber;
  }

  std::string_view process_;
  std::span<const ConfigurationKey> keys_;
  ConfigurationValues values_;
  std::vector<ConfigurationError> errors_;
};

json numberSchema(const ConfigurationKey& key) {
  json schema = {{"type", key.kind == KeyKind::Integer || key.isWhole ? "integer" : "number"}};
  if (std::isfinite(key.minimum)) {
    schema[key.isMinimumExclusive ? "exclusiveMinimum" : "minimum"] = key.minimum;
  }
  if (std::isfinite(key.maximum)) {
    schema["maximum"] = key.maximum;
  }
  return schema;
}

json listSchema(const ConfigurationKey& key) {
  json schema = {{"type", "array"}, {"items", numberSchema(key)}};
  if (key.minimumCount > 0) {
    schema["minItems"] = key.minimumCount;
  }
  if (key.maximumCount != std::numeric_limits<std::size_t>::max()) {
    schema["maxItems"] = key.maximumCount;
  }
  return schema;
}

json keySchema(const ConfigurationKey& key) {
  json schema;
  switch (key.kind) {
    case KeyKind::Number:
    case KeyKind::Integer:
      schema = numberSchema(key);
      break;
    case KeyKind::Boolean:
      schema = {{"type", "boolean"}};
      break;
    case KeyKind::Choice: {
      json choices = json::array();
      for (const std::string_view choice : key.choices) {
        choices.push_back(std::string(choice));
      }
      schema = {{"enum", choices}};
      break;
    }
    case KeyKind::Text:
      schema = {{"type", "string"}};
      break;
    case KeyKind::Numbers:
      schema = listSchema(key);
      if (key.isNumberAllowed) {
        // bounds of a number do not hold for a list
        schema.update(numberSchema(key));
        schema["type"] = json::array({"array", "number"});
      }
      break;
    case KeyKind::Rows:
      schema = {{"type", "array"}, {"items", listSchema(key)}};
      break;
    case KeyKind::Entries:
      schema = {
          {"type", "array"},
          {"items", {{"type", "object"}, {"required", {"type"}}, {"properties", {{"type", {{"type", "string"}}}}}}}};
      break;
  }
  schema["description"] = std::string(key.description) + ".";
  schema["default"] = defaultJson(key);
  if (key.kind != KeyKind::Boolean && key.kind != KeyKind::Choice && key.kind != KeyKind::Text &&
      key.kind != KeyKind::Entries) {
    schema["unit"] = std::string(key.unit);
  }
  return schema;
}

const ConfigurationValue& find(const ConfigurationValues& values, std::string_view key) {
  const auto found = values.find(key);
  ESPALIER_CHECK_VALUES(found != values.end(), std::string(key));
  return found->second;
}

}  // namespace

double Configuration::number(std::string_view key) const {
  return std::get<double>(find(values_, key));
}
std::int64_t Configuration::integer(std::string_view key) const {
  return static_cast<std::int64_t>(number(key));
}
bool Configuration::flag(std::string_view key) const {
  return std::get<bool>(find(values_, key));
}
const std::string& Configuration::text(std::string_view key) const {
  return std::get<std::string>(find(values_, key));
}
const std::vector<double>& Configuration::numbers(std::string_view key) const {
  return std::get<std::vector<double>>(find(values_, key));
}
const ConfigurationRows& Configuration::rows(std::string_view key) const {
  return std::get<ConfigurationRows>(find(values_, key));
}
const std::vector<std::string>& Configuration::entries(std::string_view key) const {
  return std::get<std::vector<std::string>>(find(values_, key));
}
void Configuration::setDefaults(const ConfigurationValues& values) {
  for (const auto& [key, value] : values) {
    if (!isGiven(key)) {
      values_.insert_or_assign(key, value);
    }
  }
}

bool Configuration::isGiven(std::string_view key) const {
  return std::find(givenKeys_.begin(), givenKeys_.end(), key) != givenKeys_.end();
}

core::Diagnostic wrongConfiguration(std::string_view process, const std::string& message, std::string hint) {
  return {core::Severity::Error, "environment process '" + std::string(process) + "': " + message, {}, std::move(hint)};
}

tl::expected<Configuration, std::vector<ConfigurationError>> readConfiguration(std::string_view process,
                                                                               std::span<const ConfigurationKey> keys,
                                                                               std::string_view text) {
  ConfigurationReader reader(process, keys);
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    return reader.read(json::object());
  }
  auto parsed = parseJson(text, "configuration");
  if (!parsed) {
    core::Diagnostic error = wrongConfiguration(process, "the configuration " + parsed.error().message, {});
    error.location = parsed.error().location;
    return tl::unexpected(std::vector<ConfigurationError>{{"", std::move(error)}});
  }
  if (!parsed->is_object()) {
    reader.add("", "the configuration must be an object of keys and values, found " + foundText(*parsed));
    return tl::unexpected(reader.takeErrors());
  }
  return reader.read(*parsed);
}

std::string writeSchema(std::string_view process, std::string_view summary, std::span<const ConfigurationKey> keys) {
  json properties = json::object();
  for (const ConfigurationKey& key : keys) {
    properties[std::string(key.name)] = keySchema(key);
  }
  const json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                       {"title", std::string(process)},
                       {"description", std::string(summary)},
                       {"type", "object"},
                       {"properties", properties},
                       {"additionalProperties", false}};
  return schema.dump(2);
}

std::string writeConfiguration(const ConfigurationValues& values) {
  json object = json::object();
  for (const auto& [name, value] : values) {
    std::visit([&, &key = name](const auto& held) { object[key] = held; }, value);
  }
  return object.dump();
}

}  // namespace espalier::environment
