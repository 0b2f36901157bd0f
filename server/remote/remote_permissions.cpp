#include "server/remote/remote_permissions.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "engine/core/diagnostic.h"
#include "server/remote/processes/legacy_process.h"

namespace espalier::server {
namespace {

constexpr std::string_view kMore = "...";

bool isCommandName(std::string_view name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

/// The words of a command; quotes of either kind hold blanks together. Nothing when a quote does not end.
std::optional<std::vector<std::string>> wordsOf(std::string_view text) {
  std::vector<std::string> words;
  std::optional<std::string> word;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
      word = word.value_or("");
    } else if (quote == 0 && (c == ' ' || c == '\t')) {
      if (word) {
        words.push_back(std::move(*word));
        word.reset();
      }
    } else {
      word = word.value_or("") + c;
    }
  }
  if (word) {
    words.push_back(std::move(*word));
  }
  return quote == 0 ? std::optional(std::move(words)) : std::nullopt;
}

/// The script that an interpreter is told to read. Empty: none.
std::string scriptOf(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 9> kInterpreters{"python", "sh",   "bash",    "dash", "perl",
                                                          "ruby",   "node", "Rscript", "julia"};
  std::string program = std::filesystem::path(words.front()).filename().string();
  // python3.11 is python
  program.erase(program.find_last_not_of("0123456789.") + 1);
  const bool isInterpreter = std::find(kInterpreters.begin(), kInterpreters.end(), program) != kInterpreters.end();
  // an option may take the next word, or make a script unnecessary
  return isInterpreter && words.size() > 1 && !words[1].starts_with("-") ? words[1] : std::string();
}

}  // namespace

bool RemotePermissions::mayDial(std::string_view address) const {
  return std::any_of(addresses.begin(), addresses.end(),
                     [address](const std::string& listed) { return listed == "any" || listed == address; });
}

std::optional<std::string> RemotePermissions::problemOfName(const std::string& name, bool hasArguments) const {
  const auto found = spawn.find(name);
  if (found == spawn.end()) {
    std::vector<std::string_view> names;
    for (const auto& [listed, command] : spawn) {
      names.push_back(listed);
    }
    return "'" + name + "' is not a command that the operator of the server lists under [spawn]. " +
           (names.empty() ? std::string("The server lists none.") : core::suggestName(name, names));
  }
  if (hasArguments && !found->second.takesArguments) {
    return "the command '" + name +
           "' takes no arguments from clients. Use \"configuration\", or let the operator end it with ' ...' under "
           "[spawn].";
  }
  return std::nullopt;
}

tl::expected<SpawnCommand, std::string> readSpawnCommand(const std::string& name,
                                                         const std::vector<std::string>& texts) {
  const std::string where = "the command '" + name + "' of [spawn] ";
  if (!isCommandName(name)) {
    return tl::unexpected(where + "has an unusual name: use letters, digits, '-' and '_', at most 64.");
  }
  auto words = texts.size() == 1 ? wordsOf(texts.front()) : std::optional(texts);
  if (!words) {
    return tl::unexpected(where + "has a quote that does not end: add the second one.");
  }
  SpawnCommand command{std::move(*words)};
  if (!command.words.empty() && command.words.back() == kMore) {
    command.takesArguments = true;
    command.words.pop_back();
  }
  if (command.words.empty()) {
    return tl::unexpected(where + "is empty: write a program and its arguments.");
  }
  const std::string program = command.words.front();
  command.words.front() = findExecutable(program, ".");
  if (command.words.front().empty()) {
    return tl::unexpected(where + "names the program '" + program +
                          "', which is not there or not executable: give the path of its file.");
  }
  std::error_code error;
  if (const std::string script = scriptOf(command.words);
      !script.empty() && !std::filesystem::is_regular_file(script, error)) {
    return tl::unexpected(where + "names the file '" + script + "', which is not there: give its path.");
  }
  return command;
}

}  // namespace espalier::server
