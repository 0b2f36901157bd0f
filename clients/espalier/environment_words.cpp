#include "clients/espalier/environment_words.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace espalier::command {
namespace {

using nlohmann::json;

constexpr std::size_t kNameColumn = 22;

// "light, gradientX (1/m)"
std::string listOf(const json& variables) {
  std::string text;
  for (const json& variable : variables) {
    const std::string unit = variable.value("unit", "1");
    text += (text.empty() ? "" : ", ") + variable.value("name", std::string()) + (unit == "1" ? "" : " (" + unit + ")");
  }
  return text;
}

/// Whether a unit is one of the world's lengths, such as m^3/day or 1/m; W/m^2 and mol are not.
bool isOfLength(const json& variable) {
  const std::string unit = variable.value("unit", "1");
  return unit == "m" || unit.starts_with("m^") || unit.starts_with("m/") || unit == "1/m" || unit.starts_with("1/m^") ||
         unit == "1 or m";
}

std::string joined(const json& texts) {
  std::string all;
  for (const json& text : texts) {
    all += (all.empty() ? "" : ", ") + text.get<std::string>();
  }
  return all;
}

std::string padded(const std::string& name) {
  return name + std::string(name.size() < kNameColumn ? kNameColumn - name.size() : 1, ' ');
}

// one key of a configuration, and below it those of an object
void addKey(const std::string& name, const json& key, std::string& text) {
  text += "  " + padded(name) + key.value("description", "");
  const std::string unit = key.value("unit", "1");
  std::string more = unit == "1" ? "" : unit;
  if (key.contains("default") && !key["default"].is_object()) {
    more += (more.empty() ? "" : "; ") + std::string("default ") + key["default"].dump();
  }
  if (key.contains("enum")) {
    more += (more.empty() ? "" : "; ") + std::string("one of ") + key["enum"].dump();
  }
  text += (more.empty() ? "" : " (" + more + ")") + "\n";
}

}  // namespace

std::string environmentInWords(const std::string& descriptionJson) {
  const json all = json::parse(descriptionJson, nullptr, false);
  if (!all.is_object()) {
    return descriptionJson + "\n";
  }
  const std::string name = all.value("name", "");
  std::string text = name + ": " + all.value("summary", "") + "\n";
  if (all.contains("aliases") && !all["aliases"].empty()) {
    text += "Also called " + joined(all["aliases"]) + ".\n";
  }
  if (const std::string source = all.value("source", ""); !source.empty()) {
    text += "Source: " + source + ".\n";
  }
  const json inputs = all.value("inputs", json::array());
  const json outputs = all.value("outputs", json::array());
  text += "\nA module sends   " + (inputs.empty() ? "nothing" : listOf(inputs)) + "\n";
  text += "and gets back    " + (outputs.empty() ? "nothing" : listOf(outputs)) + "\n";
  if (std::ranges::any_of(inputs, isOfLength) || std::ranges::any_of(outputs, isOfLength)) {
    text += "m stands for the world's lengthUnit, which is m unless a world says another.\n";
  }
  text += "It reads         " + joined(all.value("needs", json::array())) + "\n";
  text += all.value("stateful", false) ? "It has a state, which snapshots hold.\n" : "It has no state.\n";
  const json configuration = all.value("configuration", json::object());
  const json keys = configuration.value("properties", json::object());
  text += keys.empty() ? "\nIt has no configuration.\n" : "\nConfiguration:\n";
  for (const auto& [key, value] : keys.items()) {
    addKey(key, value, text);
  }
  text += "\nespalier run MODEL.l -o plant.png --environment " + name + "\n";
  if (!keys.empty()) {
    text += "With a configuration: --environment FILE.json, with {\"type\": \"" + name +
            "\", …} in the file. --schema prints its JSON Schema.\n";
  }
  return text;
}

}  // namespace espalier::command
