#include "server/session/gallery_forest.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "server/remote/models/gallery.h"

namespace espalier::server::gallery_forest_test {
namespace {

class GalleryForest : public testing::Test {
 protected:
  // a folder for each test: several run at a time
  GalleryForest()
      : gallery_(std::filesystem::path(testing::TempDir()) /
                 ("espalier-gallery-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    std::filesystem::remove_all(gallery_);
    std::filesystem::create_directories(gallery_ / "stand");
  }
  ~GalleryForest() override { std::filesystem::remove_all(gallery_); }
  GalleryForest(const GalleryForest&) = delete;
  GalleryForest& operator=(const GalleryForest&) = delete;

  void write(const std::string& file, const std::string& text) const {
    std::ofstream(gallery_ / "stand" / file) << text;
  }

  std::optional<protocol::Error> expand(protocol::CreateParams& params) const {
    params.model.model.gallery = "stand";
    return expandForest(gallery_.string(), params);
  }

  std::string problemOf(const std::string& forest) const {
    write("forest.json", forest);
    protocol::CreateParams params;
    const auto error = expand(params);
    return error ? error->message : "nothing";
  }

  std::filesystem::path gallery_;
};

TEST_F(GalleryForest, BringsItsModelsPlantsSeedsAndEnvironment) {
  write("forest.json", R"({"models":[{"name":"oak","file":"oak.l"},{"name":"fern","file":"fern.l","colour":3}],)"
                       R"("plants":[{"position":[1,0,2]},{"position":[5,0,2],"model":"fern"}],"seeds":{"spacing":0.5},)"
                       R"("environment":{"type":"height"},"seed":7,"derivationLength":12})");
  protocol::CreateParams params;
  params.model.defines = {{"N", "3"}};
  EXPECT_FALSE(expand(params).has_value());
  ASSERT_EQ(params.models.size(), 2U);
  EXPECT_EQ(params.models[1].name, "fern");
  EXPECT_EQ(params.models[1].model.model.gallery, "stand");
  EXPECT_EQ(params.models[1].model.model.main, "fern.l");
  EXPECT_EQ(params.models[1].model.defines.size(), 1U);
  EXPECT_EQ(params.plants.size(), 2U);
  EXPECT_EQ(params.seeds.spacing, 0.5);
  EXPECT_EQ(params.environmentJson, R"([{"type":"height"}])");
  EXPECT_EQ(params.seed, 7U);
  EXPECT_EQ(params.derivationLength, 12U);
  EXPECT_EQ(params.name, "stand");
}

TEST_F(GalleryForest, WhatTheCallerSaysWins) {
  write("forest.json", R"({"models":[{"name":"oak","file":"oak.l"}],"plants":[{"position":[1,0,2]}],)"
                       R"("environment":"world.json","seed":7})");
  write("world.json", R"( {"type":"honda"} )");
  protocol::CreateParams params;
  params.seed = 8;
  EXPECT_FALSE(expand(params).has_value());
  EXPECT_EQ(params.seed, 8U);
  EXPECT_EQ(params.environmentJson, R"([ {"type":"honda"} ])");
  protocol::CreateParams own;
  own.environmentTypes = {"height"};
  own.environmentJson = R"([{"type":"height"}])";
  EXPECT_FALSE(expand(own).has_value());
  EXPECT_EQ(own.environmentJson, R"([{"type":"height"}])");
  // plants of one's own are of the folder's one model
  protocol::CreateParams plants;
  plants.plants.emplace_back();
  EXPECT_FALSE(expand(plants).has_value());
  EXPECT_TRUE(plants.models.empty());
}

TEST_F(GalleryForest, AFolderWithoutAForestIsOneModel) {
  protocol::CreateParams params;
  EXPECT_FALSE(expand(params).has_value());
  EXPECT_TRUE(params.models.empty());
  params.model.model.gallery = "elsewhere";
  EXPECT_FALSE(expandForest(gallery_.string(), params).has_value());
}

TEST_F(GalleryForest, WhatIsWrongIsNamedWithTheFile) {
  EXPECT_NE(problemOf("{").find("The gallery's 'stand/forest.json': "), std::string::npos) << problemOf("{");
  EXPECT_NE(problemOf(R"({"models":[]})").find("models: expected at least one model"), std::string::npos);
  EXPECT_NE(problemOf(R"({"models":[{"name":"a","file":"../a.l"}],"plants":[{"position":[0,0,0]}]})")
                .find("the model file '../a.l' is not in the folder of the forest"),
            std::string::npos);
}

TEST(Gallery, AConfigurationOfOneProcessIsAListOfOne) {
  EXPECT_EQ(asEnvironmentList(R"({"type":"honda"})"), R"([{"type":"honda"}])");
  EXPECT_EQ(asEnvironmentList("\n {}"), "[\n {}]");
  EXPECT_EQ(asEnvironmentList("[]"), "[]");
  EXPECT_EQ(asEnvironmentList(""), "");
}

}  // namespace
}  // namespace espalier::server::gallery_forest_test
