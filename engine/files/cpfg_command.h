#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/files/data_file.h"
#include "engine/files/model_folder.h"

namespace espalier::files {

/// A word of a command line and its place in the file.
struct CommandWord {
  std::string text;  // without quotes
  core::SourceRange range;
};

/// The words of one shell command, up to a `|`, `;`, `&`, `<` or `>`. Quotes group words and are removed.
[[nodiscard]] std::vector<CommandWord> commandWords(TextCursor line);

/// Whether a command's first word runs a program; folders and the suffix .exe are ignored.
[[nodiscard]] bool runsProgram(std::string_view word, std::string_view program);

/// Reads the switches and files of a cpfg command (docs/model-files.md, 2.3); names stay as written. Each unused
/// switch gives a note with its consequence; an unknown switch is a warning.
[[nodiscard]] FolderCommand readCpfgCommand(const DataFile& file, const std::vector<CommandWord>& words);

}  // namespace espalier::files
