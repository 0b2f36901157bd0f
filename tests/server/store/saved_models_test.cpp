#include "server/store/saved_models.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/places.h"

namespace espalier::server::saved_models_test {
namespace {

namespace fs = std::filesystem;
using protocol::ErrorCode;
using Files = std::map<std::string, std::string>;

class SavedModelsTest : public testing::Test {
 protected:
  SavedModelsTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "models");
  }
  ~SavedModelsTest() override { fs::remove_all(folder_); }
  SavedModelsTest(const SavedModelsTest&) = delete;
  SavedModelsTest& operator=(const SavedModelsTest&) = delete;

  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  ErrorCode codeOf(const std::string& name, const Files& files, const std::string& revision = {}) {
    const auto saved = models_.save({.name = name, .files = files, .remove = {}, .revision = revision});
    return saved ? ErrorCode::Parse : saved.error().code;
  }

  const fs::path folder_ =
      fs::temp_directory_path() /
      ("espalier-saved-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  SavedModels models_{(folder_ / "models").string(), 100'000};
};

TEST_F(SavedModelsTest, AModelComesBackAsItWasSaved) {
  const Files files{{"tree.l", "Lsystem: 1\n"}, {"bark.png", std::string("\x89PNG\0\r", 6)}};
  const auto revision = models_.save({.name = "my tree", .files = files, .remove = {}, .revision = {}});
  ASSERT_TRUE(revision) << revision.error().message;
  EXPECT_EQ(models_.names(), std::vector<std::string>{"my tree"});
  EXPECT_EQ(models_.read("my tree")->files, files);
  EXPECT_EQ(models_.read("my tree")->revision, *revision);
}

TEST_F(SavedModelsTest, ASaveKnowsTheStateThatItReplaces) {
  const std::string first =
      *models_.save({.name = "a", .files = {{"a.l", "one"}, {"b.v", "view"}}, .remove = {}, .revision = {}});
  EXPECT_EQ(codeOf("a", {{"a.l", "two"}}), ErrorCode::ModelChanged);
  const auto second = models_.save({.name = "a", .files = {{"a.l", "two"}}, .remove = {}, .revision = first});
  ASSERT_TRUE(second);
  // a file that the save does not name stays
  EXPECT_EQ(models_.read("a")->files, (Files{{"a.l", "two"}, {"b.v", "view"}}));
  EXPECT_EQ(codeOf("a", {{"a.l", "three"}}, first), ErrorCode::ModelChanged);
  write(folder_ / "models" / "a" / "a.l", "by another program");
  const auto refused = models_.save({.name = "a", .files = {{"a.l", "three"}}, .remove = {}, .revision = *second});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().data, R"({"revision":")" + models_.read("a")->revision + "\"}");
}

TEST_F(SavedModelsTest, ASaveTakesAwayTheFilesThatItNames) {
  const std::string revision =
      *models_.save({.name = "a", .files = {{"a.l", "one"}, {"a.json", "{}"}}, .remove = {}, .revision = {}});
  write(folder_ / "models" / "keep.txt", "outside");
  EXPECT_EQ(codeOf("a", {{"a.l", "two"}}), ErrorCode::ModelChanged);
  const auto saved = models_.save({.name = "a",
                                   .files = {{"a.l", "one"}},
                                   .remove = {"a.json", "a.l", "none", "../keep.txt"},
                                   .revision = revision});
  ASSERT_TRUE(saved);
  EXPECT_EQ(models_.read("a")->files, (Files{{"a.l", "one"}}));
  EXPECT_EQ(models_.read("a")->revision, *saved);
  EXPECT_TRUE(fs::exists(folder_ / "models" / "keep.txt"));
}

TEST_F(SavedModelsTest, NamesThatNoMessageCanCarryAreLeftOut) {
  ASSERT_TRUE(models_.save({.name = "a", .files = {{"a.l", "x"}}, .remove = {}, .revision = {}}));
  fs::create_directory(folder_ / "models" / "b\xf8");
  write(folder_ / "models" / "a" / "\xff.l", "x");
  EXPECT_EQ(models_.names(), std::vector<std::string>{"a"});
  EXPECT_EQ(models_.read("a")->files.size(), 1U);
}

TEST_F(SavedModelsTest, NoNameLeadsOutOfTheFolder) {
  write(folder_ / "secret.l", "secret");
  for (const std::string name :
       {"", ".", "..", "../models", "a/b", "/etc", "a\\b", "a:b", ".hidden", "a\nb", " a", "a ", "x.part"}) {
    EXPECT_EQ(codeOf(name, {{"a.l", "x"}}), ErrorCode::InvalidParams) << name;
    EXPECT_EQ(codeOf("m", {{name, "x"}}), ErrorCode::InvalidParams) << name;
    EXPECT_EQ(models_.read(name).error().code, ErrorCode::NotFound) << name;
  }
  EXPECT_EQ(codeOf(std::string(121, 'a'), {{"a.l", "x"}}), ErrorCode::InvalidParams);
  EXPECT_EQ(codeOf("m", {}), ErrorCode::InvalidParams);
  EXPECT_TRUE(models_.names().empty());
  EXPECT_TRUE(fs::is_empty(folder_ / "models"));
}

TEST_F(SavedModelsTest, LinksAreNotFollowed) {
  fs::create_directory(folder_ / "outside");
  write(folder_ / "outside" / "secret.l", "secret");
  fs::create_directory_symlink(folder_ / "outside", folder_ / "models" / "link");
  EXPECT_TRUE(models_.names().empty());
  EXPECT_EQ(models_.read("link").error().code, ErrorCode::NotFound);
  EXPECT_EQ(codeOf("link", {{"a.l", "x"}}), ErrorCode::Storage);
  const std::string revision = *models_.save({.name = "m", .files = {{"a.l", "x"}}, .remove = {}, .revision = {}});
  fs::create_symlink(folder_ / "outside" / "secret.l", folder_ / "models" / "m" / "b.l");
  EXPECT_EQ(models_.read("m")->files, (Files{{"a.l", "x"}}));
  EXPECT_EQ(codeOf("m", {{"b.l", "mine"}}, revision), ErrorCode::Storage);
  EXPECT_EQ(fs::file_size(folder_ / "outside" / "secret.l"), 6U);
}

TEST_F(SavedModelsTest, AllModelsTogetherAreBounded) {
  const std::string text(30'000, ' ');
  const std::string revision = *models_.save({.name = "a", .files = {{"a.l", text}}, .remove = {}, .revision = {}});
  ASSERT_TRUE(models_.save({.name = "b", .files = {{"b.l", text}}, .remove = {}, .revision = {}}));
  EXPECT_EQ(codeOf("c", {{"c.l", text}}), ErrorCode::Limit);
  EXPECT_EQ(models_.names(), (std::vector<std::string>{"a", "b"}));
  // many empty models take room too
  SavedModels small((folder_ / "models").string(), 80'000);
  EXPECT_EQ(small.save({.name = "d", .files = {{"d.l", ""}}, .remove = {}, .revision = {}}).error().code,
            ErrorCode::Limit);
}

TEST_F(SavedModelsTest, AModelStaysSmallEnoughToBeRead) {
  Files many;
  for (int i = 0; i < 1000; ++i) {
    many.emplace("f" + std::to_string(i) + ".l", "");
  }
  fs::create_directories(folder_ / "roomy");
  SavedModels roomy((folder_ / "roomy").string(), 0);
  const auto first = roomy.save({.name = "m", .files = many, .remove = {}, .revision = {}});
  ASSERT_TRUE(first) << first.error().message;
  const auto refused = roomy.save({.name = "m", .files = {{"g.l", ""}}, .remove = {}, .revision = *first});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("the model would have 1001 files"), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(roomy.read("m")->files.size(), 1000U);
  const auto exchanged = roomy.save({.name = "m", .files = {{"g.l", ""}}, .remove = {"f0.l"}, .revision = *first});
  ASSERT_TRUE(exchanged) << exchanged.error().message;
  EXPECT_EQ(roomy.read("m")->files.size(), 1000U);
  // the bytes of all files, not of the new ones alone
  const auto large =
      roomy.save({.name = "n", .files = {{"a.png", std::string(30'000'000, 'a')}}, .remove = {}, .revision = {}});
  ASSERT_TRUE(large);
  EXPECT_FALSE(
      roomy.save({.name = "n", .files = {{"b.png", std::string(30'000'000, 'b')}}, .remove = {}, .revision = *large}));
  EXPECT_TRUE(roomy.read("n"));
}

TEST_F(SavedModelsTest, AServerWithoutTheFolderKeepsNone) {
  SavedModels none("", 0);
  EXPECT_FALSE(none.isOn());
  EXPECT_TRUE(none.names().empty());
  EXPECT_EQ(none.save({.name = "a", .files = {{"a.l", "x"}}, .remove = {}, .revision = {}}).error().code,
            ErrorCode::Storage);
  EXPECT_EQ(none.read("a").error().code, ErrorCode::NotFound);
}

}  // namespace
}  // namespace espalier::server::saved_models_test
