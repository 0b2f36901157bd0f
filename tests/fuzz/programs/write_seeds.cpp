// write_seeds SOURCE OUT: writes what the fuzzers begin with below OUT, one folder for each program, from the models of
// the conformance suite and the gallery below SOURCE, the files of their runs, and the texts in tests/fuzz/seeds.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>

#include "tests/fuzz/bundle.h"
#include "tests/fuzz/model_bundles.h"
#include "tests/fuzz/run_files.h"

namespace {

namespace fs = std::filesystem;
using namespace espalier::fuzz;

constexpr std::size_t kLargestSeed = 100'000;

void writeSeed(const fs::path& out, std::string_view program, const std::string& name, const std::string& text) {
  if (text.size() > kLargestSeed) {
    return;
  }
  const fs::path folder = out / program;
  fs::create_directories(folder);
  std::ofstream(folder / ("seed-" + name), std::ios::binary) << text;
}

void writeSeedsOf(const ModelBundle& bundle, const fs::path& out) {
  if (!bundle.view.empty()) {
    writeSeed(out, "fuzz_view_file", bundle.name, bundle.view);
  }
  if (bundle.text.empty()) {
    return;
  }
  for (const char* program : {"fuzz_preprocessor", "fuzz_compile", "fuzz_derivation"}) {
    writeSeed(out, program, bundle.name, bundle.text);
  }
  if (const auto files = runFilesOf(bundle.text)) {
    writeSeed(out, "fuzz_snapshot", bundle.name, files->snapshot);
    writeSeed(out, "fuzz_trace", bundle.name, files->trace);
    writeSeed(out, "fuzz_string", bundle.name, files->string + "\n" + bundleHead("model.l") + bundle.text);
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
    for (const ModelBundle& bundle : modelBundles(source / models)) {
      writeSeedsOf(bundle, arguments[2]);
    }
  }
  for (const NamedText& model : foreignModels(source / "clients/gallery")) {
    for (const char* program : {"fuzz_compile", "fuzz_derivation"}) {
      writeSeed(arguments[2], program, model.name, model.text);
    }
  }
  for (const NamedText& forest : forestBundles(source / "clients/gallery")) {
    writeSeed(arguments[2], "fuzz_forest", forest.name, forest.text);
  }
  for (const auto& entry : fs::recursive_directory_iterator(source / "tests/fuzz/seeds")) {
    if (entry.is_regular_file()) {
      const std::string program = "fuzz_" + entry.path().parent_path().filename().string();
      writeSeed(arguments[2], program, entry.path().filename().string(), contentOf(entry.path()));
    }
  }
  for (const auto& entry : fs::directory_iterator(source / "tests/engine/turtle/export/text/mtg")) {
    if (entry.path().extension() == ".mtg") {
      writeSeed(arguments[2], "fuzz_mtg", entry.path().filename().string(), contentOf(entry.path()));
    }
  }
  return 0;
}
