#include "tests/fuzz/model_bundles.h"

#include <algorithm>
#include <fstream>
#include <iterator>

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

ModelBundle bundleOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && entry.file_size() <= kLargestFile && !name.starts_with("expected") &&
        entry.path().extension() != ".md") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
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

}  // namespace espalier::fuzz
