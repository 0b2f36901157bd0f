// Every model of the conformance suite compiles without errors in the reference's mode.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "engine/language/compiler.h"
#include "tests/engine/language/compile_text.h"
#include "tests/support/places.h"

namespace espalier::language::conformance_models_test {
namespace {

class FolderFiles final : public core::FileProvider {
 public:
  std::optional<std::string> read(const std::string& name) override {
    std::ifstream stream(name, std::ios::binary);
    if (!stream) {
      return std::nullopt;
    }
    return std::string(std::istreambuf_iterator<char>(stream), {});
  }
};

TEST(ConformanceModels, AllCompileInTheReferencesMode) {
  std::vector<std::filesystem::path> models;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/tests/conformance/cases")) {
    if (std::filesystem::exists(entry.path() / "model.l")) {
      models.push_back(entry.path());
    }
  }
  std::sort(models.begin(), models.end());
  ASSERT_GE(models.size(), 200U);
  FolderFiles files;
  for (const std::filesystem::path& folder : models) {
    CompileInput input;
    input.modelFile = (folder / "model.l").string();
    input.viewFile = std::filesystem::exists(folder / "model.v") ? (folder / "model.v").string() : "";
    input.compatibility = core::Compatibility::Cpfg;
    const CompileResult result = compile(input, files);
    EXPECT_TRUE(result.program != nullptr) << folder << "\n"
                                           << core::formatDiagnostic(result.diagnostics.entries().at(0));
  }
}

// the suite is full of odd models, yet few of them look like mistakes: warnings must stay rare to be read
TEST(ConformanceModels, FewGiveWarnings) {
  FolderFiles files;
  std::size_t count = 0;
  std::string all;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/tests/conformance/cases")) {
    CompileInput input;
    input.modelFile = (entry.path() / "model.l").string();
    input.viewFile = std::filesystem::exists(entry.path() / "model.v") ? (entry.path() / "model.v").string() : "";
    input.compatibility = core::Compatibility::Cpfg;
    const CompileResult result = compile(input, files);
    for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
      // two cases are about characters that are skipped
      const bool isSkip = diagnostic.message.find("no meaning in expressions") != std::string::npos;
      count += diagnostic.location.file == input.modelFile && !isSkip ? 1U : 0U;
      all += core::formatDiagnostic(diagnostic) + "\n";
    }
  }
  // two of them: 011-arity-mismatch-copies makes V(x) and V(x,y,z) where only V(x,y) is rewritten; one: the surface ~!
  // of 007-symbols-odd-characters has no file; three: 165-turtle-wrong-at-symbol
  EXPECT_LE(count, 18U) << all;
}

// authors copy models of the gallery
TEST(GalleryModels, GiveNoWarnings) {
  FolderFiles files;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(sourceFolder() + "/clients/gallery")) {
    if (entry.path().extension() == ".l") {
      CompileInput input;
      input.modelFile = entry.path().string();
      const std::filesystem::path view = std::filesystem::path(entry.path()).replace_extension(".v");
      input.viewFile = std::filesystem::exists(view) ? view.string() : "";
      const CompileResult result = compile(input, files);
      // a note says which model of a file is meant
      for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
        EXPECT_EQ(diagnostic.severity, core::Severity::Note) << core::formatDiagnostic(diagnostic);
      }
      ++count;
    }
  }
  EXPECT_GT(count, 10U);
}

}  // namespace
}  // namespace espalier::language::conformance_models_test
