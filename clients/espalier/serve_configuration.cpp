#include "clients/espalier/serve_configuration.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::command {
namespace {

/// The option of the section [store].
constexpr const char* kDurability = "durability";

/// Options that a configuration file does not have outside of sections: limits and the store have sections of their
/// own, a token has its hash or its own file.
bool isLeftOut(const std::string& name) {
  constexpr std::array<std::string_view, 7> kNames{"help",  "config",           "print-config", "limit",
                                                   "token", "until-input-ends", kDurability};
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

/// Why an item outside of limits, commands and tokens is none of a configuration, or nothing.
std::optional<std::string> whyUnknown(const CLI::App& command, const CLI::ConfigItem& item) {
  const std::vector<std::string> keys = keysOf(command);
  const bool isOfStore = item.parents == std::vector<std::string>{"store"} && item.name == kDurability;
  if (!isOfStore && (!item.parents.empty() || std::find(keys.begin(), keys.end(), item.name) == keys.end())) {
    const std::vector<std::string_view> views(keys.begin(), keys.end());
    constexpr std::size_t kShown = 40;
    return "'" + item.fullname().substr(0, kShown) + "' is not an option. " + core::suggestName(item.fullname(), views);
  }
  return std::nullopt;
}

std::optional<std::string> applyOption(CLI::App& command, const CLI::ConfigItem& item) {
  if (auto problem = whyUnknown(command, item)) {
    return problem;
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

std::string listText(const std::vector<std::string>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i == 0 ? "" : ", ") + quoted(values[i]);
  }
  return text + "]";
}

std::optional<std::string> applyCommand(server::ServerOptions& options, const CLI::ConfigItem& item) {
  auto read = server::readSpawnCommand(item.name, item.inputs);
  if (!read) {
    return read.error();
  }
  return options.remote.spawn.emplace(item.name, std::move(*read)).second
             ? std::nullopt
             : std::optional("the command '" + item.name + "' is there twice in [spawn]: give one another name.");
}

std::optional<std::string> applyToken(std::vector<server::Token>& tokens, const CLI::ConfigItem& item) {
  std::string line;
  for (const std::string& input : item.inputs) {
    line += (line.empty() ? "" : " ") + input;
  }
  auto read = server::readToken(item.name, line);
  if (!read) {
    return read.error();
  }
  for (const server::Token& other : tokens) {
    if (other.name == read->name || other.hash == read->hash) {
      return "the tokens '" + other.name + "' and '" + read->name +
             "' have the same name or the same hash: give each its own.";
    }
  }
  tokens.push_back(std::move(*read));
  return std::nullopt;
}

std::optional<std::string> applyLimit(server::ServerLimits& limits, const CLI::ConfigItem& item) {
  if (item.inputs.size() != 1) {
    return "the limit '" + item.name + "' takes one number.";
  }
  return server::setLimit(limits, item.name + "=" + item.inputs.front());
}

std::string sectionOf(const CLI::ConfigItem& item) {
  return item.parents.size() == 1 ? item.parents.front() : std::string();
}

std::optional<std::string> applyItem(CLI::App& command, server::ServerOptions& options, const CLI::ConfigItem& item) {
  const std::string section = sectionOf(item);
  if (section == "limits") {
    return applyLimit(options.limits, item);
  }
  if (section == "spawn") {
    return applyCommand(options, item);
  }
  return section == "tokens" ? applyToken(options.tokens, item) : applyOption(command, item);
}

using Apply = std::function<std::optional<std::string>(const CLI::ConfigItem&)>;

/// Hands over the items of a configuration. The first mistake, or nothing.
std::optional<std::string> readItems(const std::string& file, const Apply& apply) {
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
      if (const auto problem = apply(item)) {
        return where + *problem;
      }
    }
  } catch (const CLI::Error& error) {
    return where + error.what();
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> readServeConfiguration(CLI::App& command, const std::string& file,
                                                  server::ServerOptions& options) {
  return readItems(file, [&](const CLI::ConfigItem& item) { return applyItem(command, options, item); });
}

tl::expected<ConfiguredAgain, std::string> readConfigurationAgain(const CLI::App& command, const std::string& file,
                                                                  bool hasLimits) {
  ConfiguredAgain read;
  std::vector<std::string> names;
  auto problem = readItems(file, [&](const CLI::ConfigItem& item) -> std::optional<std::string> {
    const std::string section = sectionOf(item);
    if (section == "tokens") {
      return applyToken(read.tokens, item);
    }
    if (section != "limits") {
      read.items[item.fullname()] = item.inputs;
      return section == "spawn" ? std::nullopt : whyUnknown(command, item);
    }
    if (std::find(names.begin(), names.end(), item.name) != names.end()) {
      return "the limit '" + item.name + "' is there twice.";
    }
    names.push_back(item.name);
    return applyLimit(read.limits, item);
  });
  if (!problem && hasLimits && names.empty()) {
    problem = "the configuration '" + file + "' has no limit any more: perhaps it is only half written. To have the " +
              "defaults, write one of them under [limits].";
  }
  if (problem) {
    return tl::unexpected(std::move(*problem));
  }
  return read;
}

bool setsLimits(const std::string& file) {
  bool isThere = false;
  (void)readItems(file, [&isThere](const CLI::ConfigItem& item) -> std::optional<std::string> {
    isThere = isThere || sectionOf(item) == "limits";
    return std::nullopt;
  });
  return isThere;
}

std::map<std::string, std::vector<std::string>> readStartItems(const std::string& file) {
  std::map<std::string, std::vector<std::string>> items;
  (void)readItems(file, [&items](const CLI::ConfigItem& item) -> std::optional<std::string> {
    if (const std::string section = sectionOf(item); section != "limits" && section != "tokens") {
      items[item.fullname()] = item.inputs;
    }
    return std::nullopt;
  });
  return items;
}

std::string serveConfigurationText(const CLI::App& command, const server::ServerOptions& options) {
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
      text += listText(values);
    }
    text += "\n";
  }
  const CLI::Option* const durability = command.get_option(std::string("--") + kDurability);
  text += std::string("\n[store]\n") + kDurability + " = " +
          quoted(durability->count() > 0 ? durability->reduced_results().front() : durability->get_default_str()) +
          "\n";
  text += "\n[limits]\n";
  for (const server::LimitEntry& entry : server::limitEntries()) {
    text += std::string(entry.name) + " = " + std::to_string(entry.get(options.limits)) + "  # " +
            std::string(entry.meaning) + "\n";
  }
  text += options.remote.spawn.empty() ? "" : "\n[spawn]\n";
  for (const auto& [name, spawned] : options.remote.spawn) {
    std::vector<std::string> words = spawned.words;
    if (spawned.takesArguments) {
      words.emplace_back("...");
    }
    text += name + " = " + listText(words) + "\n";
  }
  text += options.tokens.empty() ? "" : "\n[tokens]\n";
  for (const server::Token& token : options.tokens) {
    text += token.name + " = " + quoted(server::toText(token)) + "\n";
  }
  return text;
}

}  // namespace espalier::command
