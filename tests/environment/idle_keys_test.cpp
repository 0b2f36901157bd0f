// Keys of environments that another key switches off.

#include "environment/idle_keys.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "environment/registry.h"

namespace espalier::environment::idle_keys_test {
namespace {

std::vector<std::string> messagesOf(std::string_view process, std::string_view configuration) {
  std::vector<std::string> messages;
  for (const core::Diagnostic& warning : idleKeys(process, configuration)) {
    EXPECT_EQ(warning.severity, core::Severity::Warning);
    messages.push_back(warning.message);
  }
  return messages;
}

using Messages = std::vector<std::string>;

TEST(IdleKeys, AreNamedWithTheKeyThatSwitchesThemOff) {
  EXPECT_EQ(messagesOf("soil-water", R"({"topHead":-10})"),
            Messages{"environment process 'soil-water': 'topHead' has no effect, because 'surface' is weather"});
  EXPECT_EQ(messagesOf("soil-water", R"({"topHead":-10,"surface":"head"})"), Messages{});
  EXPECT_EQ(messagesOf("xylem", R"({"soilHead":-1,"soilHeads":[[0,-2],[1,-3]]})"),
            Messages{"environment process 'xylem': 'soilHead' has no effect, because 'soilHeads' is given"});
  EXPECT_EQ(messagesOf("xylem", R"({"soilHead":-1,"soilHeads":[],"soil":[]})"), Messages{});
  EXPECT_EQ(messagesOf("xylem", R"({"rhizosphere":true})"),
            Messages{"environment process 'xylem': 'rhizosphere' has no effect, because 'soil' is not given"});
  EXPECT_EQ(messagesOf("light", R"({"diffuseIrradiance":100,"sun":"direction"})"), Messages{});
  EXPECT_EQ(messagesOf("light", R"({"diffuseIrradiance":100,"sun":"position","latitude":1,"start":"2026-06-21"})"),
            Messages{"environment process 'light': 'diffuseIrradiance' has no effect, because 'sun' is position"});
  EXPECT_EQ(messagesOf("light-voxels", R"({"reflectance":0.1})"),
            Messages{"environment process 'light-voxels': 'reflectance' has no effect, because 'scattering' is false"});
  EXPECT_EQ(messagesOf("light-voxels", R"({"irradiance":5,"sun":"direction","sunDirection":[1,1,0]})"),
            Messages{"environment process 'light-voxels': 'irradiance' has no effect, because 'sun' is direction"});
  EXPECT_EQ(messagesOf("light-voxels", R"({"unit":"umol","method":"shadow"})"),
            Messages{"environment process 'light-voxels': 'unit' has no effect, because 'method' is shadow"});
}

TEST(IdleKeys, AreFoundInsideOtherEnvironments) {
  EXPECT_EQ(messagesOf("xylem", R"({"soil":[{"type":"soil-water","bottomHead":-1}]})"),
            Messages{"environment process 'soil-water': 'bottomHead' has no effect, because 'bottom' is free"});
}

TEST(IdleKeys, AreNoneWhenNothingIsGivenOrTheConfigurationIsWrong) {
  for (const std::string& name : processNames()) {
    EXPECT_EQ(messagesOf(name, ""), Messages{}) << name;
  }
  EXPECT_EQ(messagesOf("xylem", R"({"collarHead":"deep"})"), Messages{});
  EXPECT_EQ(messagesOf("no-such-process", "{}"), Messages{});
}

TEST(IdleKeys, EveryRuleIsAboutKeysThatTheProcessHas) {
  // a rule with a wrong name would stay silent: the descriptions of all keys are there
  EXPECT_TRUE(problemsOfIdleKeys().empty()) << problemsOfIdleKeys().front();
}

}  // namespace
}  // namespace espalier::environment::idle_keys_test
