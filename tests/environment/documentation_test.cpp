// docs/environments.md has a section for every process, which names its keys.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "environment/obstacles/obstacle_scene.h"
#include "environment/registry.h"
#include "environment/tick_rule.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::environment::documentation_test {
namespace {

const std::string& page() {
  static const std::string kPage = test::readFile(sourceFolder() + "/docs/environments.md").value_or("");
  return kPage;
}

/// The text below a heading of the third level, up to the next heading of the second or third level.
std::string sectionOf(const std::string& name) {
  const std::string heading = "\n### " + name + "\n";
  const std::size_t begin = page().find(heading);
  if (begin == std::string::npos) {
    return {};
  }
  const std::size_t end = std::min(page().find("\n### ", begin + 1), page().find("\n## ", begin + 1));
  return page().substr(begin, end - begin);
}

bool isObstacleKey(const std::string& key) {
  return std::any_of(kObstacleKeys.begin(), kObstacleKeys.end(), [&](const auto& one) { return one.name == key; });
}

TEST(EnvironmentsPage, HasASectionForEveryProcess) {
  for (const std::string& name : processNames()) {
    EXPECT_NE(sectionOf(name), "") << name;
    EXPECT_NE(page().find("\n| `" + name + "` |"), std::string::npos) << name << " is not in the first table";
  }
}

TEST(EnvironmentsPage, NamesEveryKeyAliasAndPublishedKeyword) {
  for (const std::string& name : processNames()) {
    const std::string section = sectionOf(name);
    const auto schema = nlohmann::json::parse(configurationSchema(name));
    for (const auto& [key, property] : schema["properties"].items()) {
      const bool isNamed = section.find("`" + key + "`") != std::string::npos;
      // the keys of obstacles are on one place for all processes
      const bool isShared =
          key == kTickKey.name || (isObstacleKey(key) && section.find("(#keys-of-obstacles)") != std::string::npos);
      EXPECT_TRUE(isNamed || isShared) << name << " " << key;
    }
    for (const std::string& alias : aliasesOf(name)) {
      EXPECT_NE(section.find("`" + alias + "`"), std::string::npos) << name << " " << alias;
    }
    const bool isLikeClover = name == "ornament";
    for (const PublishedKeyword& keyword : findProcess(name)->publishedKeywords) {
      EXPECT_TRUE(isLikeClover || section.find("`" + std::string(keyword.keyword)) != std::string::npos)
          << name << " " << keyword.keyword;
    }
  }
}

TEST(EnvironmentsPage, NamesEverySharedKeyOfObstacles) {
  const std::string section = sectionOf("obstacles");
  for (const ConfigurationKey& key : kObstacleKeys) {
    EXPECT_NE(section.find("`" + std::string(key.name) + "`"), std::string::npos) << key.name;
  }
}

}  // namespace
}  // namespace espalier::environment::documentation_test
