#include "tests/fuzz/model_bundles.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "tests/fuzz/bundle.h"

namespace espalier::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = 50'000;

/// The main file, and behind it every other file.
std::string bundleOf(const std::vector<fs::path>& files, const fs::path& mainFile) {
  std::string text = contentOf(mainFile);
  for (const fs::path& file : files) {
    if (file != mainFile) {
      if (!text.empty() && text.back() != '\n') {
        text += '\n';
      }
      // the view file is found under one name, whatever it is called here
      const std::string name = file.extension() == ".v" ? "model.v" : file.filename().string();
      text += bundleHead(name) + contentOf(file);
    }
  }
  return text;
}

/// The files of a folder that a bundle may have, by name.
std::vector<fs::path> filesOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && entry.file_size() <= kLargestFile && !name.starts_with("expected") &&
        entry.path().extension() != ".md") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

ModelBundle bundleOf(const fs::path& folder) {
  const std::vector<fs::path> files = filesOf(folder);
  const auto withSuffix = [&](const char* suffix) {
    const auto isIt = [&](const fs::path& file) { return file.extension() == suffix; };
    const auto found = std::find_if(files.begin(), files.end(), isIt);
    return found == files.end() ? std::string() : bundleOf(files, *found);
  };
  return {folder.filename().string(), withSuffix(".l"), withSuffix(".v")};
}

}  // namespace

std::string contentOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<ModelBundle> modelBundles(const fs::path& below) {
  std::vector<ModelBundle> bundles;
  if (fs::exists(below)) {
    for (const auto& entry : fs::directory_iterator(below)) {
      if (entry.is_directory()) {
        bundles.push_back(bundleOf(entry.path()));
      }
    }
  }
  std::sort(bundles.begin(), bundles.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return bundles;
}

std::vector<NamedText> foreignModels(const fs::path& below) {
  std::vector<NamedText> models;
  for (const auto& folder : fs::directory_iterator(below)) {
    if (!folder.is_directory()) {
      continue;
    }
    for (const fs::path& file : filesOf(folder.path())) {
      core::MemoryFileProvider provider;
      provider.add(file.filename().string(), contentOf(file));
      language::CompileInput input;
      input.modelFile = file.filename().string();
      const bool isText = file.extension() == ".txt" || file.extension() == ".lsv" || file.extension() == ".l";
      if (isText && language::translateForeign(input, provider)) {
        models.push_back({folder.path().filename().string() + "-" + file.filename().string(), contentOf(file)});
      }
    }
  }
  std::sort(models.begin(), models.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return models;
}

std::vector<NamedText> forestBundles(const fs::path& below) {
  std::vector<NamedText> forests;
  for (const auto& folder : fs::directory_iterator(below)) {
    const fs::path forest = folder.path() / "forest.json";
    if (fs::exists(forest)) {
      forests.push_back({folder.path().filename().string(), bundleOf(filesOf(folder.path()), forest)});
    }
  }
  std::sort(forests.begin(), forests.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return forests;
}

}  // namespace espalier::fuzz
