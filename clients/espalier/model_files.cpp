#include "clients/espalier/model_files.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/language/dialects/dialect.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTitleSeparator = " / ";

std::string nameOf(const std::string& file) {
  return fs::path(file).filename().string();
}

bool isFile(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

// files of the folder with the suffix, sorted by name; control panels of editors belong to no model
std::vector<fs::path> filesWithSuffix(const fs::path& folder, const char* suffix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == suffix && entry.path().stem() != "panel" && !entry.is_directory(error)) {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// the file of the model's stem with the suffix, or an empty name
std::string besideModel(const fs::path& model, const char* suffix) {
  fs::path file = model;
  file.replace_extension(suffix);
  return isFile(file) ? file.string() : std::string{};
}

// the companion of a model in a folder: the file with its stem, else the only file with the suffix; a remark names
// every file that is not used
std::string companion(const fs::path& model, const char* suffix, const std::string& consequence, ModelFiles& files) {
  const std::vector<fs::path> candidates = filesWithSuffix(model.parent_path(), suffix);
  std::string chosen = besideModel(model, suffix);
  if (chosen.empty() && candidates.size() == 1) {
    chosen = candidates.front().string();
  }
  for (const fs::path& candidate : candidates) {
    if (candidate.string() != chosen) {
      core::Diagnostic remark;
      remark.severity = core::Severity::Note;
      remark.location.file = candidate.string();
      remark.message = "the file is not used: " + consequence;
      files.remarks.push_back(std::move(remark));
    }
  }
  return chosen;
}

std::string listOf(const std::vector<fs::path>& files) {
  std::string text;
  for (const fs::path& file : files) {
    text += (text.empty() ? "" : ", ") + file.filename().string();
  }
  return text;
}

Result<ModelFiles> onlyModelOf(const std::string& folder) {
  const std::vector<fs::path> models = filesWithSuffix(folder, ".l");
  if (models.empty()) {
    return problem("the folder '" + folder + "' holds no L-system file (.l): give another folder, or the file itself");
  }
  if (models.size() > 1) {
    return problem("the folder '" + folder + "' holds more than one L-system file (" + listOf(models) +
                   "): give the name of one");
  }
  ModelFiles files;
  files.isFolder = true;
  files.model = models.front().string();
  files.view = companion(models.front(), ".v", "its settings do not count", files);
  files.environment = companion(models.front(), ".e", "it does not answer communication modules", files);
  if (files.environment.empty()) {
    files.environment = besideModel(files.model, ".json");
  }
  files.animation = companion(models.front(), ".a", "it does not decide which step is the last", files);
  const std::string materials = companion(models.front(), ".mat", "its materials are not used", files);
  const std::string map = companion(models.front(), ".map", "its colours are not used", files);
  if (!map.empty()) {
    files.colours.push_back({map, 1, false});
  }
  // materials win over a map
  if (!materials.empty()) {
    files.colours.push_back({materials, 1, true});
  }
  return files;
}

std::string listOf(const std::vector<files::FolderCommand>& commands) {
  std::string text;
  for (std::size_t i = 0; i < commands.size(); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(i + 1) + " '" + commands[i].title + "' (" +
            nameOf(commands[i].model) + ")";
  }
  return text;
}

bool isCalled(const files::FolderCommand& command, const std::string& object) {
  const std::string tail = std::string(kTitleSeparator) + object;
  return command.title == object || command.title.ends_with(tail) || nameOf(command.model) == object;
}

// the command that `object` means, by number or by name
Result<files::FolderCommand> chosenCommand(const std::string& folder, const std::vector<files::FolderCommand>& commands,
                                           const std::string& object) {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    if (object == std::to_string(i + 1)) {
      return commands[i];
    }
  }
  std::vector<files::FolderCommand> called;
  std::copy_if(commands.begin(), commands.end(), std::back_inserter(called),
               [&](const files::FolderCommand& command) { return isCalled(command, object); });
  if (called.size() == 1) {
    return called.front();
  }
  return problem("the folder '" + folder + "' has " + (called.empty() ? "no object" : "several objects") + " '" +
                 object + "': give one of " + listOf(commands));
}

// the sentence about a command with a missing model
std::string missingModel(const std::string& folder, const std::string& model, const std::vector<std::string>& names) {
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const std::string_view nearest = core::nearestName(nameOf(model), candidates);
  return "the folder '" + folder + "' has no file '" + nameOf(model) + "', the model that its specifications run" +
         (nearest.empty() ? std::string(": add it, or give the name of a model")
                          : ": did you mean '" + std::string(nearest) + "'?");
}

Result<ModelFiles> commandOf(const std::string& path, const std::string& object) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  server::DiskFileProvider provider;
  const files::ModelFolder folder = files::readModelFolder(path, names, provider);

  ModelFiles files;
  files.isFolder = true;
  for (const core::Diagnostic& diagnostic : folder.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      return problem(diagnostic.location.file + ": " + diagnostic.message + ": " + diagnostic.hint);
    }
    files.remarks.push_back(diagnostic);
  }
  files::FolderCommand command = folder.commands.front();
  if (!object.empty()) {
    auto chosen = chosenCommand(path, folder.commands, object);
    if (!chosen) {
      return problem(std::move(chosen.error()));
    }
    command = std::move(*chosen);
  } else if (folder.commands.size() > 1) {
    core::Diagnostic remark;
    remark.severity = core::Severity::Note;
    remark.location.file = path;
    remark.message = "the folder offers " + std::to_string(folder.commands.size()) +
                     " objects, and the first is used: " + listOf(folder.commands);
    remark.hint = "--object TITLE chooses another";
    files.remarks.push_back(std::move(remark));
  }
  if (!isFile(command.model)) {
    return problem(missingModel(path, command.model, names));
  }
  if (command.writesAfterHomomorphism) {
    core::Diagnostic remark;
    remark.severity = core::Severity::Note;
    remark.location.file = (fs::path(path) / "specifications").string();
    remark.message = "the switch -homo is not used: strings are printed before homomorphism";
    files.remarks.push_back(std::move(remark));
  }
  files.model = command.model;
  // the remarks name the missing files
  files.view = isFile(command.view) ? command.view : std::string{};
  files.environment = isFile(command.environment) ? command.environment : std::string{};
  files.animation = isFile(command.animation) ? command.animation : std::string{};
  for (const files::ColourFile& colours : command.colours) {
    if (isFile(colours.file)) {
      files.colours.push_back(colours);
    }
  }
  files.colourBase = command.colourBase;
  files.startsInAnimation = command.startsInAnimation;
  return files;
}

}  // namespace

Result<ModelFiles> findModelFiles(const std::string& path, const std::string& object) {
  std::error_code error;
  // one model of a file with several: its companions are those of the file
  server::DiskFileProvider provider;
  const language::NamedEntry named = language::splitEntry(path, provider);
  if (!named.entry.empty() && isFile(named.file) && object.empty()) {
    auto found = findModelFiles(named.file);
    if (found) {
      found->model = path;
    }
    return found;
  }
  const bool isFolder = fs::is_directory(path, error);
  if (!isFolder && !fs::exists(path, error)) {
    return problem("there is no file '" + path + "': give the name of an L-system file (.l) or of its folder");
  }
  if (isFolder && isFile(fs::path(path) / "specifications")) {
    return commandOf(path, object);
  }
  if (!object.empty()) {
    return problem("--object chooses one of the commands in a folder's specifications, and '" + path +
                   "' has none: leave out --object");
  }
  if (isFolder) {
    return onlyModelOf(path);
  }
  ModelFiles files;
  files.model = path;
  files.view = besideModel(path, ".v");
  files.environment = besideModel(path, ".e");
  if (files.environment.empty()) {
    files.environment = besideModel(path, ".json");
  }
  files.animation = besideModel(path, ".a");
  return files;
}

}  // namespace espalier::command
