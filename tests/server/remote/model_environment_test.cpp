// The benchmarks and the hashes of the gallery attach the same environment to a model as `espalier run`.

#include "tests/support/model_environment.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "server/remote/models/model_files.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::test::model_environment_test {
namespace {

namespace fs = std::filesystem;

TEST(ModelEnvironment, IsThatOfTheCommandRunForEveryModelOfTheGallery) {
  DiskFiles files;
  int published = 0;
  int configured = 0;
  for (const auto& folder : fs::directory_iterator(sourceFolder() + "/clients/gallery")) {
    const fs::path model = folder.path() / (folder.path().filename().string() + ".l");
    if (!fs::exists(model)) {
      continue;
    }
    const server::FoundModel found = server::findModelFiles(model.string());
    ASSERT_TRUE(found) << model;
    EXPECT_EQ(environmentFileBeside(model.string(), files), found->environment) << model;
    EXPECT_EQ(environmentBeside(model.string(), files) != nullptr, !found->environment.empty()) << model;
    published += found->environment.ends_with(".e") ? 1 : 0;
    configured += found->environment.ends_with(".json") ? 1 : 0;
  }
  EXPECT_GE(published, 10);
  EXPECT_GE(configured, 10);
}

TEST(ModelEnvironment, SaysWhichFileIsWrong) {
  core::MemoryFileProvider files;
  files.add("m.json", R"([{"type":"heigth"}])");
  try {
    const auto made = environmentBeside("m.l", files);
    FAIL() << "an unknown type was made";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).rfind("m.json: ", 0), 0U) << error.what();
  }
}

}  // namespace
}  // namespace espalier::test::model_environment_test
