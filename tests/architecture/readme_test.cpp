// The things that the front page names are in the repository.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::test::readme_test {
namespace {

std::string file(const std::string& name) {
  return readFile(sourceFolder() + "/" + name).value_or("");
}

TEST(Readme, ShowsTheExampleAsItIs) {
  const std::string example = file("clients/python/examples/ceiling.py");
  ASSERT_FALSE(example.empty());
  EXPECT_NE(file("README.md").find("```python\n" + example + "```\n"), std::string::npos);
}

TEST(Readme, LinksAndPicturesExist) {
  const std::string text = file("README.md");
  static const std::regex kTarget(R"re(\]\(([^)#:]+)\)|src="([^"]+)")re");
  int count = 0;
  for (auto match = std::sregex_iterator(text.begin(), text.end(), kTarget); match != std::sregex_iterator(); ++match) {
    const std::string target = (*match)[1].matched ? (*match)[1].str() : (*match)[2].str();
    EXPECT_TRUE(std::filesystem::exists(sourceFolder() + "/" + target)) << target;
    ++count;
  }
  EXPECT_GT(count, 10);
}

TEST(Readme, NamesTheTwoCommands) {
  const std::string text = file("README.md");
  EXPECT_NE(text.find("\n./dev demo"), std::string::npos);
  EXPECT_NE(text.find("\n./dev test"), std::string::npos);
  EXPECT_NE(file(".ci/run").find("./dev test"), std::string::npos);
}

}  // namespace
}  // namespace espalier::test::readme_test
