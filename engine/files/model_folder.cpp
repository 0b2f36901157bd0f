#include "engine/files/model_folder.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "engine/files/cpfg_command.h"
#include "engine/files/data_file.h"

namespace espalier::files {
namespace {

constexpr std::string_view kSpecifications = "specifications";
// no menu has deeper titles
constexpr std::size_t kMostDepth = 100;

std::string inFolder(const std::string& folder, const std::string& name) {
  if (folder.empty() || name.empty() || name.front() == '/') {
    return name;
  }
  return folder.back() == '/' ? folder + name : folder + '/' + name;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool isRefreshMode(std::string_view line) {
  for (const std::string_view keyword :
       {"rmode:", "refresh mode:", "Refresh mode:", "refresh Mode:", "Refresh Mode:", "refreshMode:"}) {
    if (line.starts_with(keyword)) {
      return true;
    }
  }
  return false;
}

/// Files of control panels begin with this name and may have any suffix.
bool isPanel(std::string_view name) {
  return name.starts_with("panel.");
}

core::Diagnostic folderDiagnostic(core::Severity severity, const std::string& folder, std::string message,
                                  std::string hint = {}) {
  core::Diagnostic diagnostic;
  diagnostic.severity = severity;
  diagnostic.message = std::move(message);
  diagnostic.location.file = folder.empty() ? "." : folder;
  diagnostic.hint = std::move(hint);
  return diagnostic;
}

/// Reads the file list, up to the line `*`. False when no line ends it: the menu is part of it then.
bool readFileList(TextCursor& cursor, ModelFolder& result) {
  bool isIgnored = false;
  while (!cursor.atEnd()) {
    const std::string_view whole = cursor.takeLine().rest();
    const std::string_view line = trimmed(whole);
    if (line == "*") {
      return true;
    }
    if (line.empty() || whole.starts_with(';') || isRefreshMode(line)) {
      continue;
    }
    // the following lines are patterns of files that an editor does not save
    if (line == "ignore:") {
      isIgnored = true;
    } else if (!isIgnored) {
      result.listedFiles.emplace_back(line);
    }
  }
  return false;
}

/// A sentence and its hint.
struct Refusal {
  std::string message = "no command of the menu runs cpfg";
  std::string hint = "name the model and its view file";
};

/// Reads the menu: titles by their depth, and the cpfg commands among its commands. The answer says why there is none.
Refusal readMenu(const DataFile& file, TextCursor& cursor, ModelFolder& result) {
  std::vector<std::string> titles;
  Refusal refusal;
  while (!cursor.atEnd()) {
    TextCursor line = cursor.takeLine();
    if (line.peek() == ';') {
      continue;
    }
    const std::size_t begin = line.position();
    line.skip("\t");
    const std::size_t depth = std::min(line.position() - begin, kMostDepth);
    if (line.atLineEnd()) {
      continue;
    }
    const std::size_t colon = line.rest().find(':');
    if (colon != std::string_view::npos) {
      titles.resize(depth);
      titles.emplace_back(trimmed(line.rest().substr(0, colon)));
      continue;
    }
    const std::vector<CommandWord> words = commandWords(line);
    if (!words.empty() && runsProgram(words.front().text, "lpfg")) {
      refusal = {"the menu runs lpfg, and Espalier does not read L+C, the language of its models",
                 "write the model in the language of docs/language.md"};
    }
    if (words.empty() || !runsProgram(words.front().text, "cpfg")) {
      continue;
    }
    FolderCommand command = readCpfgCommand(file, words);
    if (command.model.empty() || command.view.empty()) {
      const std::string missing = command.model.empty() ? "model" : "view file";
      file.warn(words.front().range, "the command is ignored: it names no " + missing);
      refusal = {"the cpfg command of the menu names no " + missing +
                     (command.model.empty() ? "" : " behind '" + command.model + "'"),
                 "write it as 'cpfg [switches] model.l view.v'; -e, -m, -M and -c take the word behind them"};
      continue;
    }
    for (std::size_t i = 0; i < std::min(depth, titles.size()); ++i) {
      command.title += (command.title.empty() || titles[i].empty() ? "" : " / ") + titles[i];
    }
    result.commands.push_back(std::move(command));
  }
  return refusal;
}

/// Without `specifications`: the folder's only model and view file.
void findOnlyModel(const std::string& folder, const std::vector<std::string>& names, ModelFolder& result) {
  std::vector<std::string> models;
  std::vector<std::string> views;
  for (const std::string& name : names) {
    if (!isPanel(name) && name.ends_with(".l")) {
      models.push_back(name);
    } else if (!isPanel(name) && name.ends_with(".v")) {
      views.push_back(name);
    }
  }
  if (models.size() == 1 && views.size() == 1) {
    FolderCommand command;
    command.model = models.front();
    command.view = views.front();
    result.commands.push_back(std::move(command));
    return;
  }
  result.diagnostics.add(folderDiagnostic(core::Severity::Error, folder,
                                          "the folder has no file 'specifications', and " +
                                              std::to_string(models.size()) + " models and " +
                                              std::to_string(views.size()) + " view files to choose from",
                                          "name the model and its view file"));
}

/// Warns about files that a command names and the folder lacks, except its model: without that there is nothing to run.
void checkNames(const std::string& folder, const std::vector<std::string>& names, const FolderCommand& command,
                ModelFolder& result) {
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const auto check = [&](const std::string& name, const std::string& consequence) {
    if (name.empty() || name.find('/') != std::string::npos ||
        std::find(names.begin(), names.end(), name) != names.end()) {
      return;
    }
    const std::string_view nearest = core::nearestName(name, candidates);
    result.diagnostics.add(folderDiagnostic(core::Severity::Warning, folder,
                                            "the folder has no file '" + name + "': " + consequence,
                                            nearest.empty() ? "" : "did you mean '" + std::string(nearest) + "'?"));
  };
  check(command.view, "every view setting has its default");
  check(command.animation, "the derivation length decides which step is last");
  check(command.environment, "communication modules are not answered");
  for (const ColourFile& colours : command.colours) {
    check(colours.file, "its colours are the default ones");
  }
}

/// Notes files of the folder that a run could have used and no command names.
void noteUnusedFiles(const std::string& folder, const std::vector<std::string>& names, ModelFolder& result) {
  const auto isNamed = [&](const std::string& name) {
    return std::any_of(result.commands.begin(), result.commands.end(), [&](const FolderCommand& command) {
      return name == command.model || name == command.view || name == command.animation ||
             name == command.environment ||
             std::any_of(command.colours.begin(), command.colours.end(),
                         [&](const ColourFile& colours) { return colours.file == name; });
    });
  };
  const std::pair<std::string_view, std::string_view> kinds[] = {
      {".map", "its colours are not used"},
      {".mat", "its materials are not used"},
      {".a", "it does not decide which steps are shown"},
      {".e", "it does not answer communication modules"},
  };
  for (const std::string& name : names) {
    for (const auto& [suffix, consequence] : kinds) {
      if (name.ends_with(suffix) && !isPanel(name) && !isNamed(name)) {
        result.diagnostics.add(folderDiagnostic(core::Severity::Note, folder,
                                                "no command names '" + name + "': " + std::string(consequence)));
      }
    }
  }
}

void joinToFolder(const std::string& folder, FolderCommand& command) {
  for (std::string* name : {&command.model, &command.view, &command.animation, &command.environment}) {
    *name = inFolder(folder, *name);
  }
  for (ColourFile& colours : command.colours) {
    colours.file = inFolder(folder, colours.file);
  }
}

}  // namespace

ModelFolder readModelFolder(const std::string& folder, const std::vector<std::string>& names,
                            core::FileProvider& files) {
  ModelFolder result;
  const std::string file = inFolder(folder, std::string(kSpecifications));
  if (std::optional<std::string> text = files.read(file)) {
    const DataFile specifications(file, *text, result.diagnostics);
    TextCursor cursor = specifications.cursor();
    const bool hasMenu = readFileList(cursor, result);
    Refusal refusal = readMenu(specifications, cursor, result);
    if (!hasMenu) {
      refusal = {"the file has no menu, because no line '*' ends its list of files",
                 "put a line with only '*' between the files and the menu"};
    }
    if (result.commands.empty()) {
      result.diagnostics.add(
          folderDiagnostic(core::Severity::Error, file, std::move(refusal.message), std::move(refusal.hint)));
    }
  } else {
    findOnlyModel(folder, names, result);
  }
  for (const FolderCommand& command : result.commands) {
    checkNames(folder, names, command, result);
  }
  noteUnusedFiles(folder, names, result);
  for (FolderCommand& command : result.commands) {
    joinToFolder(folder, command);
  }
  return result;
}

Palette readPalette(const FolderCommand& command, core::FileProvider& files, core::DiagnosticList& diagnostics) {
  Palette palette;
  palette.base = command.colourBase;
  for (const ColourFile& colours : command.colours) {
    const std::optional<std::string> bytes = files.read(colours.file);
    if (!bytes) {
      core::Diagnostic diagnostic;
      diagnostic.severity = core::Severity::Warning;
      diagnostic.message = "the file cannot be read; its colours are the default ones";
      diagnostic.location.file = colours.file;
      diagnostics.add(std::move(diagnostic));
    } else if (colours.isMaterial) {
      readMaterials(*bytes, colours.file, colours.block, palette, diagnostics);
    } else {
      readColourMap(*bytes, colours.file, colours.block, palette, diagnostics);
    }
  }
  // the kind of the last file counts, also when that file could not be read
  palette.usesMaterials = !command.colours.empty() && command.colours.back().isMaterial;
  return palette;
}

}  // namespace espalier::files
