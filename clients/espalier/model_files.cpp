#include "clients/espalier/model_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

// files of the folder with the suffix, sorted by name
std::vector<fs::path> filesWithSuffix(const fs::path& folder, const char* suffix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == suffix && !entry.is_directory(error)) {
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
  std::error_code error;
  return fs::is_regular_file(file, error) ? file.string() : std::string{};
}

std::string listOf(const std::vector<fs::path>& files) {
  std::string text;
  for (const fs::path& file : files) {
    text += (text.empty() ? "" : ", ") + file.filename().string();
  }
  return text;
}

}  // namespace

std::variant<ModelFiles, std::string> findModelFiles(const std::string& path) {
  std::error_code error;
  const bool isFolder = fs::is_directory(path, error);
  if (!isFolder && !fs::exists(path, error)) {
    return "there is no file '" + path + "': give the name of an L-system file (.l) or of the folder that holds it";
  }
  ModelFiles files;
  if (!isFolder) {
    files.model = path;
    files.view = besideModel(path, ".v");
    files.environment = besideModel(path, ".e");
    return files;
  }

  // a folder: exactly one model
  const std::vector<fs::path> models = filesWithSuffix(path, ".l");
  if (models.empty()) {
    return "the folder '" + path + "' holds no L-system file (.l): give a folder that does, or the file itself";
  }
  if (models.size() > 1) {
    return "the folder '" + path + "' holds more than one L-system file (" + listOf(models) + "): give the name of one";
  }
  files.model = models.front().string();

  // its companions by stem, else the only one of their kind
  files.view = besideModel(models.front(), ".v");
  files.environment = besideModel(models.front(), ".e");
  const std::vector<fs::path> views = filesWithSuffix(path, ".v");
  if (files.view.empty() && views.size() == 1) {
    files.view = views.front().string();
  }
  const std::vector<fs::path> environments = filesWithSuffix(path, ".e");
  if (files.environment.empty() && environments.size() == 1) {
    files.environment = environments.front().string();
  }
  return files;
}

}  // namespace espalier::command
