#include "clients/espalier/serve_configuration.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <fstream>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::command {
namespace {

/// Options that a configuration file does not have: limits have their own section, a token has its own file.
bool isLeftOut(const std::string& name) {
  constexpr std::array<std::string_view, 5> kNames{"help", "config", "print-config", "limit", "token"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

/// The long names of options that a configuration may have.
std::vector<std::string> keysOf(const CLI::App& command) {
  std::vector<std::string> keys;
  for (const CLI::Option* option : command.get_options()) {
    if (const std::string name = option->get_single_name(); !isLeftOut(name)) {
      keys.push_back(name);
    }
  }
  return keys;
}

std::optional<std::string> applyOption(CLI::App& command, const CLI::ConfigItem& item) {
  const std::vector<std::string> keys = keysOf(command);
  if (!item.parents.empty() || std::find(keys.begin(), keys.end(), item.name) == keys.end()) {
    const std::vector<std::string_view> views(keys.begin(), keys.end());
    return "'" + item.fullname() + "' is not an option. " + core::suggestName(item.fullname(), views);
  }
  CLI::Option* const option = command.get_option("--" + item.name);
  // the command line wins; an empty value sets nothing
  const bool isEmpty =
      std::all_of(item.inputs.begin(), item.inputs.end(), [](const auto& text) { return text.empty(); });
  if (option->count() > 0 || isEmpty) {
    return std::nullopt;
  }
  const bool isFlag = option->get_expected_max() == 0;
  if (isFlag && item.inputs.front() == "false") {
    return std::nullopt;
  }
  if (isFlag && item.inputs.front() != "true") {
    return "'" + item.name + "' is true or false, not '" + item.inputs.front() + "'.";
  }
  option->add_result(item.inputs);
  option->run_callback();
  return std::nullopt;
}

std::string quoted(const std::string& text) {
  return '"' + text + '"';
}

}  // namespace

std::optional<std::string> readServeConfiguration(CLI::App& command, const std::string& file,
                                                  server::ServerLimits& limits) {
  const std::string where = "the configuration '" + file + "': ";
  std::ifstream stream(file);
  if (!stream) {
    return "the configuration '" + file + "' (--config) cannot be read: check the name and the working folder.";
  }
  try {
    for (const CLI::ConfigItem& item : CLI::ConfigTOML().from_config(stream)) {
      if (item.name == "++" || item.name == "--") {
        continue;  // the reader marks the begin and the end of a section so
      }
      const bool isLimit = item.parents.size() == 1 && item.parents.front() == "limits" && item.inputs.size() == 1;
      const auto problem =
          isLimit ? server::setLimit(limits, item.name + "=" + item.inputs.front()) : applyOption(command, item);
      if (problem) {
        return where + *problem;
      }
    }
  } catch (const CLI::Error& error) {
    return where + error.what();
  }
  return std::nullopt;
}

std::string serveConfigurationText(const CLI::App& command, const server::ServerLimits& limits) {
  std::string text;
  for (const std::string& key : keysOf(command)) {
    const CLI::Option* const option = command.get_option("--" + key);
    const std::vector<std::string> values =
        option->count() > 0 ? option->reduced_results() : std::vector<std::string>{option->get_default_str()};
    text += key + " = ";
    if (option->get_expected_max() == 0) {
      text += option->count() > 0 ? "true" : "false";
    } else if (values.size() == 1) {
      text += quoted(values.front());
    } else {
      text += "[";
      for (std::size_t i = 0; i < values.size(); ++i) {
        text += (i == 0 ? "" : ", ") + quoted(values[i]);
      }
      text += "]";
    }
    text += "\n";
  }
  text += "\n[limits]\n";
  for (const server::LimitEntry& entry : server::limitEntries()) {
    text += std::string(entry.name) + " = " + std::to_string(entry.get(limits)) + "  # " + std::string(entry.meaning) +
            "\n";
  }
  return text;
}

}  // namespace espalier::command
