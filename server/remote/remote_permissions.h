#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace espalier::server {

/// A command that the operator lists in the section [spawn] of the server's configuration.
struct SpawnCommand {
  std::vector<std::string> words;  // the file of the program, then its arguments
  bool takesArguments = false;     // it was listed with `...` at its end: clients may add arguments
};

/// The environments in other processes that clients may name. By default none: the operator lists them.
struct RemotePermissions {
  std::map<std::string, SpawnCommand> spawn;  // by the name that clients send
  std::vector<std::string> addresses;         // HOST:PORT that `tcp` may dial; `any`: all
  bool isSpawnAllowed = false;                // any command of a client, through the shell

  [[nodiscard]] bool mayDial(std::string_view address) const;
  /// Why a client may not have this name and these arguments, or nothing.
  [[nodiscard]] std::optional<std::string> problemOfName(const std::string& name, bool hasArguments) const;
};

/// Reads the command of a name: one text, whose words blanks divide except within quotes, or its words. No shell reads
/// it. An error sentence when the name is unusual, or when the program's file or the script of an interpreter is
/// missing.
[[nodiscard]] tl::expected<SpawnCommand, std::string> readSpawnCommand(const std::string& name,
                                                                       const std::vector<std::string>& texts);

}  // namespace espalier::server
