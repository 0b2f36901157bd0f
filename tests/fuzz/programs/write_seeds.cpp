// write_seeds SOURCE OUT: writes what the fuzzers begin with below OUT, one folder for each program, from the models of
// the conformance suite and the gallery below SOURCE, and the texts in tests/fuzz/seeds.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/bundle.h"

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = 50'000;

std::string contentOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The main file of a folder, and behind it every other file; the first with the suffix is the main one.
std::string bundleOf(const std::vector<fs::path>& files, const fs::path& mainFile) {
  std::string text = contentOf(mainFile);
  for (const fs::path& file : files) {
    if (file != mainFile) {
      if (!text.empty() && text.back() != '\n') {
        text += '\n';
      }
      // the view file is found under one name, whatever it is called here
      const std::string name = file.extension() == ".v" ? "model.v" : file.filename().string();
      text += espalier::fuzz::bundleHead(name) + contentOf(file);
    }
  }
  return text;
}

void writeSeed(const fs::path& out, std::string_view program, const std::string& name, const std::string& text) {
  const fs::path folder = out / program;
  fs::create_directories(folder);
  std::ofstream(folder / ("seed-" + name), std::ios::binary) << text;
}

void writeSeedsOf(const fs::path& folder, const fs::path& out) {
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
    return std::find_if(files.begin(), files.end(), [&](const fs::path& file) { return file.extension() == suffix; });
  };
  const std::string name = folder.filename().string();
  if (const auto model = withSuffix(".l"); model != files.end()) {
    const std::string bundle = bundleOf(files, *model);
    for (const char* program : {"fuzz_preprocessor", "fuzz_compile", "fuzz_derivation"}) {
      writeSeed(out, program, name, bundle);
    }
  }
  if (const auto view = withSuffix(".v"); view != files.end()) {
    writeSeed(out, "fuzz_view_file", name, bundleOf(files, *view));
  }
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount != 3) {
    std::cerr << "usage: write_seeds SOURCE OUT\n";
    return 2;
  }
  const fs::path source = arguments[1];
  for (const char* models : {"tests/conformance/cases", "clients/gallery"}) {
    if (!fs::exists(source / models)) {
      continue;
    }
    for (const auto& entry : fs::directory_iterator(source / models)) {
      if (entry.is_directory()) {
        writeSeedsOf(entry.path(), arguments[2]);
      }
    }
  }
  for (const auto& entry : fs::recursive_directory_iterator(source / "tests/fuzz/seeds")) {
    if (entry.is_regular_file()) {
      const std::string program = "fuzz_" + entry.path().parent_path().filename().string();
      writeSeed(arguments[2], program, entry.path().filename().string(), contentOf(entry.path()));
    }
  }
  return 0;
}
