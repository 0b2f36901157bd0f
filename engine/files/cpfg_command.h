#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/files/data_file.h"
#include "engine/files/model_folder.h"

namespace espalier::language {

/// A word of a command line and its place in the file.
struct CommandWord {
  std::string text;  // without quotes
  core::SourceRange range;
};

/// The words of one shell command, up to a `|`, `;`, `&`, `<` or `>`. Quotes group and are taken away.
[[nodiscard]] std::vector<CommandWord> commandWords(TextCursor line);

/// Whether a command's first word runs cpfg: folders and a suffix .exe are not looked at.
[[nodiscard]] bool runsCpfg(std::string_view word);

/// Reads the switches and files of a cpfg command (FILES §2.3); names stay as written. What is not used is named in a
/// note with its consequence; an unknown switch is a warning.
[[nodiscard]] FolderCommand readCpfgCommand(const DataFile& file, const std::vector<CommandWord>& words);

}  // namespace espalier::language
