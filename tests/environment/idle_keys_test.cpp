// Keys of environments that another key switches off.

#include "environment/idle_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
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

TEST(IdleKeys, NameOneReasonForEachKey) {
  struct Case {
    std::string process;
    std::string configuration;
    std::string key;
    std::string reason;
  };
  for (const auto& [process, configuration, key, reason] : {
           Case{"wind", R"({"heights":[1,9]})", "heights", "'profile' is constant"},
           {"wind", R"({"profile":"table","heights":[1],"speeds":[2],"speed":3})", "speed", "'profile' is table"},
           {"wind", R"({"roughness":0.2,"profile":"power"})", "roughness", "'profile' is power"},
           {"soil-water", R"({"initialPh":5})", "initialPh", "'acidity' is false"},
           {"soil-water", R"({"solutesEnter":"concentration"})", "solutesEnter",
            "'solutes' and 'acidity' are not given"},
           {"soil-water", R"({"weatherPeriod":3,"rain":[]})", "weatherPeriod",
            "'rain' and 'evaporation' and 'groundLight' are not given"},
           {"light", R"({"remainder":1e-4,"bounces":5})", "bounces", "'remainder' is given"},
           {"light", R"({"groundHeight":1})", "groundHeight", "'ground' is false"},
           {"light-voxels", R"({"fullLight":2})", "fullLight", "'method' is turbid"},
           {"light-voxels", R"({"method":"shadow","sky":"uniform","directions":[[0,1,0,1]]})", "sky",
            "'method' is shadow"},
           {"light-voxels", R"({"directions":[[0,1,0,1]],"zenithAngles":9})", "zenithAngles", "'directions' is given"},
           {"light-voxels", R"({"remainder":1e-3})", "remainder", "'scattering' is false"},
           {"xylem", R"({"stomataShape":2})", "stomataShape", "'leaves' is demand"},
           {"xylem", R"({"vulnerabilityShape":2})", "vulnerabilityShape", "'vulnerabilityHead' is not given"},
           {"chiba", R"({"sources":[[0,1,0,1]],"sampleCount":64})", "sampleCount", "'sources' is given"},
           {"chiba", R"({"gridSize":[4,4,4]})", "gridSize", "'compatible' is false"},
           {"density3d", R"({"gridSize":[2,2,2],"octreeLevel":0})", "gridSize", "'octreeLevel' is given"},
           {"honda", R"({"plane":"xy","threeDimensional":true})", "plane", "'threeDimensional' is true"},
       }) {
    const Messages messages = messagesOf(process, configuration);
    ASSERT_FALSE(messages.empty()) << process << " " << configuration;
    EXPECT_EQ(messages.front(),
              "environment process '" + process + "': '" + key + "' has no effect, because " + reason);
    EXPECT_EQ(std::ranges::count(messages, messages.front()), 1);
  }
}

TEST(IdleKeys, AreNoneWhereTheKeyActs) {
  for (const auto& [process, configuration] :
       {std::pair{"wind", R"({"profile":"logarithmic","roughness":0.2,"displacement":1,"referenceHeight":10})"},
        {"soil-water", R"({"acidity":true,"initialPh":5,"solutesEnter":"concentration"})"},
        {"soil-water", R"({"rain":[[0,0.01]],"weatherPeriod":3})"},
        {"light", R"({"remainder":0,"bounces":5})"},
        {"density3d", R"({"gridSize":[2,2,2],"octreeLevel":-1})"},
        {"xylem", R"({"vulnerabilityHead":-100,"vulnerabilityShape":2,"leaves":"stomata","temperature":30})"},
        {"chiba", R"({"gridSize":[4,4,4],"compatible":true,"sampleCount":64})"}}) {
    EXPECT_EQ(messagesOf(process, configuration), Messages{}) << process << " " << configuration;
  }
}

TEST(IdleKeys, BandsWithMoreLightThanThereIsAreAWarning) {
  for (const std::string process : {"light", "light-voxels"}) {
    EXPECT_EQ(messagesOf(process, R"({"bands":[0.6,0.6]})"),
              Messages{"environment process '" + process + "': 'bands' are parts of the irradiance and add up to 1.2"});
    EXPECT_EQ(messagesOf(process, R"({"bands":[0.45,0.55]})"), Messages{});
    // several kinds of leaves in all of the light
    EXPECT_EQ(messagesOf(process, R"({"bands":[1,1,1]})"), Messages{});
  }
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
