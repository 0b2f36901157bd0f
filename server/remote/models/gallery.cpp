#include "server/remote/models/gallery.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "server/remote/disk_files.h"

namespace espalier::server {

namespace fs = std::filesystem;

namespace {

// the folder beside an installed program, or in the source tree in which it was built; empty when there is none
std::string folderOfProgram(const char* installed, const char* inSources) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (fs::path folder = program.parent_path(); !error && folder != folder.parent_path();
       folder = folder.parent_path()) {
    for (const char* const place : {installed, inSources}) {
      std::error_code missing;
      if (fs::is_directory(folder / place, missing)) {
        return (folder / place).string();
      }
    }
  }
  return {};
}

// of one file of a model that is sent
constexpr std::size_t kMostGalleryBytes = 16'000'000;
// pictures and tables beside a model that nobody edits
constexpr std::array<std::string_view, 4> kNotEdited{".png", ".svg", ".tsv", ".pnm"};

bool contains(const auto& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& file : fs::directory_iterator(folder, error)) {
    if (file.is_regular_file(error)) {
      found.push_back(file.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::string galleryOfProgram() {
  return folderOfProgram("share/espalier/gallery", "clients/gallery");
}

std::string conformanceOfProgram() {
  return folderOfProgram("share/espalier/conformance", "tests/conformance/cases");
}

std::string handbookOfProgram() {
  return folderOfProgram("share/doc/espalier/handbook", "build/handbook/site");
}

std::vector<std::string> galleryNames(const std::string& gallery) {
  std::vector<std::string> names;
  std::error_code error;
  if (gallery.empty()) {
    return names;
  }
  for (const auto& entry : fs::directory_iterator(gallery, error)) {
    if (entry.is_directory(error)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> galleryEntries(const std::string& gallery) {
  std::vector<std::string> entries;
  for (const std::string& name : galleryNames(gallery)) {
    const fs::path folder = fs::path(gallery) / name;
    std::error_code error;
    if (!fileWithSuffix(folder, name, ".l").empty() && fs::is_regular_file(folder / (name + ".l"), error)) {
      entries.push_back(name);
      continue;
    }
    std::vector<std::string> models;
    for (const auto& file : fs::directory_iterator(folder, error)) {
      const std::string suffix = file.path().extension().string();
      if (suffix == ".l" || suffix == ".txt" || suffix == ".lsv" || suffix == ".ls" || suffix == ".lpy") {
        models.push_back(file.path().filename().string());
      }
    }
    std::sort(models.begin(), models.end());
    DiskFileProvider files;
    for (const std::string& model : models) {
      language::CompileInput input;
      input.modelFile = (folder / model).string();
      const std::vector<std::string> own = language::entriesOf(input, files);
      for (const std::string& entry : own) {
        entries.push_back(name + "/" + model + ":" + entry);
      }
      // text that is no model is not offered
      const bool isModel = language::compile(input, files).program != nullptr;
      if (own.empty() && isModel) {
        entries.push_back(name + "/" + model);
      }
    }
  }
  return entries;
}

std::optional<fs::path> galleryFolderOf(const std::string& gallery, const std::string& name) {
  const auto names = galleryNames(gallery);
  if (!std::binary_search(names.begin(), names.end(), name)) {
    return std::nullopt;
  }
  return fs::path(gallery) / name;
}

std::string withinGallery(const std::string& gallery, std::string text) {
  const std::string prefix = (fs::path(gallery) / "").string();
  for (std::size_t at = text.find(prefix); !gallery.empty() && at != std::string::npos; at = text.find(prefix, at)) {
    text.erase(at, prefix.size());
  }
  return text;
}

std::string pathOrGallery(const std::string& name) {
  std::error_code error;
  const auto folder = fs::exists(name, error) ? std::nullopt : galleryFolderOf(galleryOfProgram(), name);
  return folder ? folder->string() : name;
}

GalleryModel readGalleryModel(const std::string& gallery, const std::string& entry,
                              const std::vector<std::string>& used) {
  const std::size_t slash = entry.find('/');
  const std::string name = entry.substr(0, slash);
  const auto folder = galleryFolderOf(gallery, name);
  GalleryModel model;
  if (!folder) {
    return model;
  }
  const bool isOneOfMany = slash != std::string::npos;
  model.main =
      isOneOfMany ? entry.substr(slash + 1) : fs::path(fileWithSuffix(*folder, name, ".l")).filename().string();
  DiskFileProvider files(kMostGalleryBytes);
  for (const auto& file : filesIn(*folder)) {
    const std::string own = file.filename().string();
    const bool isUsed = std::find(used.begin(), used.end(), file.string()) != used.end();
    const bool isLeftOut = isOneOfMany || contains(kNotEdited, file.extension().string());
    if (!isUsed && isLeftOut) {
      continue;
    }
    if (auto bytes = files.read(file.string())) {
      model.files.emplace(own, std::move(*bytes));
    }
  }
  return model;
}

std::map<std::string, std::string> galleryPictures(const std::string& gallery,
                                                   const std::vector<std::string>& entries) {
  std::map<std::string, std::string> pictures;
  for (const std::string& entry : entries) {
    const std::size_t slash = entry.find('/');
    const std::string name = entry.substr(0, slash);
    const std::string file = slash == std::string::npos ? name : entry.substr(slash + 1);
    const std::size_t colon = std::min(file.find(':'), file.size());
    const std::string stem = slash == std::string::npos ? name : fs::path(file.substr(0, colon)).stem().string();
    const std::string ofEntry = colon < file.size() ? stem + "-" + file.substr(colon + 1) : stem;
    for (const std::string& candidate : {ofEntry, stem}) {
      std::error_code error;
      if (fs::is_regular_file(fs::path(gallery) / name / (candidate + ".png"), error)) {
        pictures.emplace(entry, "/gallery/" + name + "/" + candidate + ".png");
        break;
      }
    }
  }
  return pictures;
}

std::optional<std::string> readGalleryPicture(const std::string& gallery, const std::string& name,
                                              const std::string& file) {
  const auto folder = galleryFolderOf(gallery, name);
  const fs::path plain = fs::path(file).filename();
  if (!folder || plain.string() != file || plain.extension() != ".png") {
    return std::nullopt;
  }
  return DiskFileProvider(kMostGalleryBytes).readInside(folder->string(), (*folder / plain).string());
}

std::string fileWithSuffix(const fs::path& folder, const std::string& stem, const std::string& suffix) {
  std::error_code error;
  const fs::path named = folder / (stem + suffix);
  if (fs::is_regular_file(named, error)) {
    return named.string();
  }
  std::string found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == suffix) {
      if (!found.empty()) {
        return {};
      }
      found = entry.path().string();
    }
  }
  return found;
}

std::string asEnvironmentList(const std::string& configuration) {
  const std::size_t first = configuration.find_first_not_of(" \t\r\n");
  return first != std::string::npos && configuration[first] == '{' ? "[" + configuration + "]" : configuration;
}

}  // namespace espalier::server
