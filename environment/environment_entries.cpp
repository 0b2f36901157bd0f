#include "environment/environment_entries.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "environment/base/json_text.h"
#include "environment/base/letter_case.h"

namespace espalier::environment {

namespace {

using nlohmann::json;

core::Diagnostic errorOf(std::string message, std::string hint) {
  core::Diagnostic diagnostic;
  diagnostic.message = std::move(message);
  diagnostic.hint = std::move(hint);
  return diagnostic;
}

constexpr std::string_view kExample = R"(an environment is written as {"type":"honda","radius":0.5})";

/// The text of a key taken out of the object, or nothing (with an error when it is required or of another type).
std::optional<std::string> takeText(json& object, const std::string& key, bool isRequired, const std::string& path,
                                    std::vector<core::Diagnostic>& errors) {
  const auto found = object.find(key);
  if (found == object.end()) {
    if (isRequired) {
      std::vector<std::string_view> keys;
      for (const auto& [name, value] : object.items()) {
        keys.push_back(name);
      }
      const std::string_view nearest = core::nearestName(key, keys);
      errors.push_back(errorOf(
          path + " has no '" + key + "'",
          (nearest.empty() ? "" : "is '" + std::string(nearest) + "' the '" + key + "'? ") + std::string(kExample)));
    }
    return std::nullopt;
  }
  std::optional<std::string> text;
  if (!found->is_string()) {
    errors.push_back(
        errorOf(path + ": '" + key + "' must be a text, found " + foundText(*found), std::string(kExample)));
  } else if (found->get<std::string>().empty()) {
    errors.push_back(errorOf(path + ": '" + key + "' is empty", std::string(kExample)));
  } else {
    text = found->get<std::string>();
  }
  object.erase(found);
  return text;
}

void readEntry(json object, const std::string& path, std::vector<EnvironmentEntry>& entries,
               std::vector<core::Diagnostic>& errors) {
  if (!object.is_object()) {
    errors.push_back(errorOf(path + " must be an object, found " + foundText(object), std::string(kExample)));
    return;
  }
  const auto type = takeText(object, "type", true, path, errors);
  const auto name = takeText(object, "name", false, path, errors);
  if (!type) {
    return;
  }
  EnvironmentEntry entry{*type, name.value_or(*type), object.dump()};
  for (const EnvironmentEntry& other : entries) {
    if (equalIgnoringCase(other.name, entry.name)) {
      errors.push_back(errorOf(path + ": another environment is named '" + other.name + "' already",
                               "give one of them another 'name': a model addresses it as ?Name(...)"));
    }
  }
  entries.push_back(std::move(entry));
}

}  // namespace

tl::expected<std::vector<EnvironmentEntry>, std::vector<core::Diagnostic>> parseEnvironmentEntries(
    std::string_view text) {
  auto parsed = parseJson(text, "environment");
  if (!parsed) {
    parsed.error().message = "the environment " + parsed.error().message;
    return tl::unexpected(std::vector{std::move(parsed.error())});
  }
  json& value = *parsed;
  std::vector<EnvironmentEntry> entries;
  std::vector<core::Diagnostic> errors;
  if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      readEntry(std::move(value[i]), "environment[" + std::to_string(i) + "]", entries, errors);
    }
  } else if (value.is_object()) {
    readEntry(std::move(value), "environment", entries, errors);
  } else {
    errors.push_back(errorOf("environment must be an object or a list of objects, found " + foundText(value),
                             std::string(kExample)));
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return entries;
}

}  // namespace espalier::environment
