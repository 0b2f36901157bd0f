#include "server/remote/models/model_files.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/dialects/dialect.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSpecificationsFile = "specifications";
constexpr std::string_view kTitleSeparator = " / ";

std::string nameOf(const std::string& file) {
  return fs::path(file).filename().string();
}

tl::unexpected<std::string> refused(std::string sentence) {
  return tl::unexpected<std::string>(std::move(sentence));
}

std::string noSuchFile(const std::string& path) {
  const std::string sentence = "there is no file '" + path + "'";
  // a name without folder and suffix may be the misspelt name of a gallery model
  if (path.find_first_of("/.") == std::string::npos) {
    const std::vector<std::string> names = galleryNames(galleryOfProgram());
    const std::string_view near = core::nearestName(path, {names.begin(), names.end()});
    if (near == path) {
      return sentence + ". A model of the gallery has this name";
    }
    if (!near.empty()) {
      return sentence + ". Did you mean the model '" + std::string(near) + "' of the gallery?";
    }
  }
  return sentence + ": give the name of an L-system file (.l) or of its folder";
}

// the files among which those of a model are looked for
class Place {
 public:
  // a folder on the disk; only its own files are listed, and only when they are asked for: a folder may hold thousands
  Place(const fs::path& folder, core::FileProvider& provider)
      : folder_(folder), provider_(provider), isListed_(false) {}
  // the files of a message
  Place(const std::map<std::string, std::string>& files, core::FileProvider& provider) : provider_(provider) {
    for (const auto& [name, bytes] : files) {
      names_.push_back(name);
    }
  }

  [[nodiscard]] const fs::path& folder() const { return folder_; }
  [[nodiscard]] const std::vector<std::string>& names() const {
    if (!std::exchange(isListed_, true)) {
      std::error_code error;
      for (const fs::directory_entry& entry : fs::directory_iterator(folder_.empty() ? "." : folder_, error)) {
        if (!entry.is_directory(error)) {
          names_.push_back(entry.path().filename().string());
        }
      }
      std::sort(names_.begin(), names_.end());
    }
    return names_;
  }
  [[nodiscard]] core::FileProvider& provider() const { return provider_; }
  // how messages name it
  [[nodiscard]] std::string title() const { return folder_.empty() ? "of the message" : "'" + folder_.string() + "'"; }
  [[nodiscard]] bool has(const fs::path& file) const {
    if (!isListed_) {
      std::error_code error;
      const fs::file_status status = fs::status(file, error);
      return fs::exists(status) && !fs::is_directory(status);
    }
    const bool isNamed =
        file.parent_path() == folder_ && std::binary_search(names_.begin(), names_.end(), file.filename().string());
    return isNamed || std::binary_search(names_.begin(), names_.end(), file.string()) ||
           (!file.empty() && provider_.read(file.string()).has_value());
  }
  // files with the suffix, sorted by name; control panels of editors belong to no model
  [[nodiscard]] std::vector<fs::path> withSuffix(const char* suffix) const {
    std::vector<fs::path> found;
    for (const std::string& name : names()) {
      if (fs::path(name).extension() == suffix && fs::path(name).stem() != "panel") {
        found.push_back(folder_ / name);
      }
    }
    return found;
  }
  // the file of the model's stem with the suffix, or an empty name
  [[nodiscard]] std::string beside(const fs::path& model, const char* suffix) const {
    fs::path file = model;
    file.replace_extension(suffix);
    return has(file) ? file.string() : std::string{};
  }

 private:
  fs::path folder_;                         // empty: names are whole
  mutable std::vector<std::string> names_;  // sorted
  core::FileProvider& provider_;
  mutable bool isListed_ = true;  // names_ holds the files of the folder
};

// the companion of a model in a folder: the file with its stem, else the only file with the suffix; a remark names
// every file that is not used
std::string companion(const Place& place, const fs::path& model, const char* suffix, const std::string& consequence,
                      ModelFiles& files) {
  const std::vector<fs::path> candidates = place.withSuffix(suffix);
  std::string chosen = place.beside(model, suffix);
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

// materials win over a map
void addColours(const std::string& map, const std::string& materials, ModelFiles& files) {
  if (!map.empty()) {
    files.colours.push_back({map, 1, false});
  }
  if (!materials.empty()) {
    files.colours.push_back({materials, 1, true});
  }
}

std::string listOf(const std::vector<fs::path>& files) {
  std::string text;
  for (const fs::path& file : files) {
    text += (text.empty() ? "" : ", ") + file.filename().string();
  }
  return text;
}

FoundModel onlyModelOf(const Place& place) {
  std::vector<fs::path> models = place.withSuffix(".l");
  if (models.empty()) {
    std::vector<fs::path> others;
    for (const char* suffix : {".lsv", ".ls", ".lpy", ".txt"}) {
      const std::vector<fs::path> found = place.withSuffix(suffix);
      others.insert(others.end(), found.begin(), found.end());
    }
    return refused("the folder " + place.title() + " holds no L-system file (.l): " +
                   (others.empty() ? "give another folder, or the file itself"
                                   : "give the name of one of its other files: " + listOf(others)));
  }
  // of several the one with the folder's name
  const auto named = std::find(
      models.begin(), models.end(),
      place.folder() / (fs::path(place.folder() / ".").lexically_normal().parent_path().filename().string() + ".l"));
  if (models.size() > 1 && named == models.end()) {
    return refused("the folder " + place.title() + " holds more than one L-system file (" + listOf(models) +
                   "): give the name of one");
  }
  const fs::path model = named == models.end() ? models.front() : *named;
  ModelFiles files;
  files.isFolder = true;
  files.model = model.string();
  files.view = companion(place, model, ".v", "its settings do not count", files);
  files.environment = companion(place, model, ".e", "it does not answer communication modules", files);
  if (files.environment.empty()) {
    files.environment = place.beside(model, ".json");
  }
  files.animation = companion(place, model, ".a", "it does not decide which step is the last", files);
  const std::string materials = companion(place, model, ".mat", "its materials are not used", files);
  addColours(companion(place, model, ".map", "its colours are not used", files), materials, files);
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
tl::expected<files::FolderCommand, std::string> chosenCommand(const Place& place,
                                                              const std::vector<files::FolderCommand>& commands,
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
  return refused("the folder " + place.title() + " has " + (called.empty() ? "no object" : "several objects") + " '" +
                 object + "': give one of " + listOf(commands));
}

// the sentence about a command with a missing model
std::string missingModel(const Place& place, const std::string& model) {
  const std::vector<std::string_view> candidates(place.names().begin(), place.names().end());
  const std::string_view nearest = core::nearestName(nameOf(model), candidates);
  return "the folder " + place.title() + " has no file '" + nameOf(model) + "', the model that its specifications run" +
         (nearest.empty() ? std::string(": add it, or give the name of a model")
                          : ": did you mean '" + std::string(nearest) + "'?");
}

FoundModel commandOf(const Place& place, const std::string& object) {
  const std::string path = place.folder().string();
  const files::ModelFolder folder = files::readModelFolder(path, place.names(), place.provider());

  ModelFiles files;
  files.isFolder = true;
  for (const core::Diagnostic& diagnostic : folder.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      return refused(diagnostic.location.file + ": " + diagnostic.message + ": " + diagnostic.hint);
    }
    files.remarks.push_back(diagnostic);
  }
  files::FolderCommand command = folder.commands.front();
  if (!object.empty()) {
    auto chosen = chosenCommand(place, folder.commands, object);
    if (!chosen) {
      return refused(std::move(chosen.error()));
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
  if (!place.has(command.model)) {
    return refused(missingModel(place, command.model));
  }
  if (command.writesAfterHomomorphism) {
    core::Diagnostic remark;
    remark.severity = core::Severity::Note;
    remark.location.file = (place.folder() / kSpecificationsFile).string();
    remark.message = "the switch -homo is not used: strings are printed before homomorphism";
    files.remarks.push_back(std::move(remark));
  }
  files.model = command.model;
  // the remarks name the missing files
  const auto present = [&place](const std::string& file) { return place.has(file) ? file : std::string{}; };
  files.view = present(command.view);
  files.environment = present(command.environment);
  files.animation = present(command.animation);
  for (const files::ColourFile& colours : command.colours) {
    if (place.has(colours.file)) {
      files.colours.push_back(colours);
    }
  }
  files.colourBase = command.colourBase;
  files.startsInAnimation = command.startsInAnimation;
  return files;
}

// the companions of a file that was named
ModelFiles besideFile(const Place& place, const std::string& model) {
  ModelFiles files;
  files.model = model;
  files.view = place.beside(model, ".v");
  files.environment = place.beside(model, ".e");
  if (files.environment.empty()) {
    files.environment = place.beside(model, ".json");
  }
  files.animation = place.beside(model, ".a");
  addColours(place.beside(model, ".map"), place.beside(model, ".mat"), files);
  return files;
}

}  // namespace

FoundModel findModelFiles(const std::string& path, const std::string& object) {
  std::error_code error;
  DiskFileProvider provider;
  // one model of a file with several: its companions are those of the file
  const language::NamedEntry named = language::splitEntry(path, provider);
  if (!named.entry.empty() && fs::is_regular_file(named.file, error) && object.empty()) {
    auto found = findModelFiles(named.file);
    if (found) {
      found->model = path;
    }
    return found;
  }
  const bool isFolder = fs::is_directory(path, error);
  if (!isFolder && !fs::exists(path, error)) {
    return refused(noSuchFile(path));
  }
  const Place place(isFolder ? fs::path(path) : fs::path(path).parent_path(), provider);
  if (isFolder && place.has(fs::path(path) / kSpecificationsFile)) {
    return commandOf(place, object);
  }
  if (!object.empty()) {
    return refused("--object chooses one of the models that the specifications of a folder list, and '" + path +
                   "' has none: leave out --object");
  }
  return isFolder ? onlyModelOf(place) : besideFile(place, path);
}

FoundModel findModelFiles(const std::map<std::string, std::string>& files, const std::string& main) {
  core::MemoryFileProvider provider(files);
  const Place place(files, provider);
  if (!main.empty()) {
    // one model of a file with several: its companions are those of the file
    const language::NamedEntry named = language::splitEntry(main, provider);
    ModelFiles found = besideFile(place, named.file);
    found.model = main;
    return found;
  }
  return files.contains(kSpecificationsFile) ? commandOf(place, {}) : onlyModelOf(place);
}

}  // namespace espalier::server
