#include "environment/base/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace espalier::environment::json_text_test {
namespace {

TEST(JsonText, ManyObjectsInAnArrayTakeNoLongerThanTheirText) {
  // this took minutes: the parser looked at all elements again for each of them
  constexpr std::size_t kCount = 200'000;
  std::string text = "[{}";
  for (std::size_t i = 1; i < kCount; ++i) {
    text += R"(,{"type":"honda"})";
  }
  const auto parsed = parseJson(text + "]", "configuration");
  ASSERT_TRUE(parsed.has_value());
  EXPECT_EQ(parsed->size(), kCount);
  EXPECT_EQ(parsed->back()["type"], "honda");
}

TEST(JsonText, AValueThatIsNestedDeeplyIsRefused) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_TRUE(parseJson(nested(200), "a.json").has_value());
  for (const std::size_t depth : {201U, 500'000U}) {
    const auto parsed = parseJson(nested(depth), "a.json");
    ASSERT_FALSE(parsed.has_value());
    EXPECT_EQ(parsed.error().message, "is nested more than 200 deep");
    EXPECT_EQ(parsed.error().location.file, "a.json");
  }
}

TEST(JsonText, ANameThatAnInnerObjectHasTwiceIsFound) {
  const auto parsed = parseJson(R"({"a":1,"b":{"c":1,"d":[{"a":2}],"c":2}})", "a.json");
  ASSERT_FALSE(parsed.has_value());
  EXPECT_EQ(parsed.error().message, "has the key 'c' twice");
}

}  // namespace
}  // namespace espalier::environment::json_text_test
