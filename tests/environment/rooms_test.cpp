// The rooms of environment/ include each other in one direction only, as environment/README.md says.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::environment::rooms_test {
namespace {

const std::map<std::string, std::set<std::string>>& allowedRooms() {
  static const std::map<std::string, std::set<std::string>> kAllowed{
      {"base", {}},
      {"geometry", {"base"}},
      {"obstacles", {"base", "geometry"}},
      {"light", {"base", "geometry", "obstacles"}},
      {"soil", {"base", "geometry", "obstacles"}},
      {"hydraulics", {"base", "geometry", "obstacles", "soil"}},
      {"competition", {"base", "geometry", "obstacles"}},
      {"directions", {"base", "geometry"}},
      {"", {"base"}},  // the root: it knows the processes by processes.def only
      {"published", {"base", ""}},
      {"output", {"base", "obstacles", ""}},
  };
  return kAllowed;
}

/// The first folder below environment/ of a path relative to it; empty for a file of the root.
std::string roomOf(const std::string& path) {
  const std::size_t slash = path.find('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash);
}

TEST(EnvironmentRooms, IncludeEachOtherInOneDirection) {
  namespace fs = std::filesystem;
  const fs::path folder = sourceFolder() + "/environment";
  static const std::regex kInclude(R"re(#include "environment/([^"]+)")re");
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).generic_string();
    if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") {
      continue;
    }
    const auto allowed = allowedRooms().find(roomOf(name));
    if (allowed == allowedRooms().end()) {
      EXPECT_EQ(name, "plugin_example") << "a new room: add it to this test and to environment/README.md";
      continue;
    }
    const std::string text = test::readFile(entry.path().string()).value_or("");
    for (auto match = std::sregex_iterator(text.begin(), text.end(), kInclude); match != std::sregex_iterator();
         ++match) {
      const std::string included = (*match)[1].str();
      const bool isAllowed = roomOf(included) == allowed->first || allowed->second.contains(roomOf(included));
      EXPECT_TRUE(isAllowed) << "environment/" << name << " includes environment/" << included;
      ++count;
    }
  }
  EXPECT_GT(count, 100);
}

}  // namespace
}  // namespace espalier::environment::rooms_test
