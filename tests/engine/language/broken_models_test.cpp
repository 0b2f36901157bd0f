// Golden tests of messages: every model in broken/ has one mistake or several, and its .expected file the exact
// messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/compiler.h"
#include "tests/support/places.h"

namespace espalier::language::broken_models_test {
namespace {

const std::filesystem::path kFolder(sourceFolder() + "/tests/engine/language/broken");

std::optional<std::string> contentOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    return std::nullopt;
  }
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

// names are relative to the folder, so that messages hold no path
class BrokenFiles final : public core::FileProvider {
 public:
  std::optional<std::string> read(const std::string& name) override { return contentOf(kFolder / name); }
};

std::vector<std::string> modelNames() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".l") {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string messagesOf(const std::string& model) {
  BrokenFiles files;
  CompileInput input;
  input.modelFile = model;
  std::string text;
  const CompileResult result = compile(input, files);
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    text += core::formatDiagnostic(diagnostic) + "\n";
  }
  return text;
}

TEST(BrokenModels, EachGivesExactlyItsMessages) {
  const std::vector<std::string> models = modelNames();
  ASSERT_GE(models.size(), 20U);
  for (const std::string& model : models) {
    const std::string stem = model.substr(0, model.size() - 2);
    const std::optional<std::string> expected = contentOf(kFolder / (stem + ".expected"));
    ASSERT_TRUE(expected.has_value()) << model << " has no .expected file";
    EXPECT_FALSE(expected->empty()) << model;
    EXPECT_EQ(messagesOf(model), *expected) << model;
  }
}

// every message has a real place, and no two messages have the same
TEST(BrokenModels, EveryMessageHasAPlaceAndNoneRepeatsAnother) {
  for (const std::string& model : modelNames()) {
    BrokenFiles files;
    CompileInput input;
    input.modelFile = model;
    const CompileResult result = compile(input, files);
    std::vector<std::string> places;
    for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
      EXPECT_GT(diagnostic.location.line, 0U) << model << ": " << diagnostic.message;
      EXPECT_GT(diagnostic.location.column, 0U) << model << ": " << diagnostic.message;
      places.push_back(diagnostic.location.file + ":" + std::to_string(diagnostic.location.line) + ":" +
                       std::to_string(diagnostic.location.column));
    }
    std::sort(places.begin(), places.end());
    EXPECT_TRUE(std::adjacent_find(places.begin(), places.end()) == places.end())
        << model << ": two messages at one place";
  }
}

}  // namespace
}  // namespace espalier::language::broken_models_test
