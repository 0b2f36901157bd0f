#include "server/remote/remote_settings.h"

#include <gtest/gtest.h>

namespace espalier::server::remote_settings_test {
namespace {

std::string problemOf(const std::string& json) {
  const auto read = readRemoteSettings(json);
  return read ? "(accepted)" : read.error().key + ": " + read.error().message;
}

TEST(RemoteSettings, AnEntryMaySayNothing) {
  const auto read = readRemoteSettings(R"({"type":"tcp","address":"127.0.0.1:1"})");
  const auto& settings = read.value();
  EXPECT_FALSE(settings.policy.isTolerant);
  EXPECT_FALSE(settings.stepTimeout.has_value());
  EXPECT_EQ(settings.configurationJson, "");
}

TEST(RemoteSettings, PolicyTimeoutAndConfigurationAreRead) {
  const auto read =
      readRemoteSettings(R"({"policy":"fallback:height","timeoutMilliseconds":250,"configuration":{"a":1}})");
  const auto& settings = read.value();
  EXPECT_TRUE(settings.policy.isTolerant);
  ASSERT_NE(settings.policy.fallback, nullptr);
  EXPECT_EQ(settings.policy.fallback->describe().name, "height");
  EXPECT_EQ(settings.stepTimeout, std::chrono::milliseconds(250));
  EXPECT_EQ(settings.configurationJson, R"({"a":1})");
}

TEST(RemoteSettings, ThePolicyOfTheCallerCountsWhenTheEntryHasNone) {
  EXPECT_TRUE(readRemoteSettings("{}", "keep").value().policy.isTolerant);
  EXPECT_FALSE(readRemoteSettings(R"({"policy":"fail"})", "keep").value().policy.isTolerant);
}

TEST(RemoteSettings, WhatIsWrongIsNamed) {
  EXPECT_EQ(problemOf(R"({"policy":"hope"})"),
            "policy: expected fail, keep or fallback:NAME of a built-in, found \"hope\"");
  EXPECT_EQ(problemOf(R"({"policy":"fallback:nothing"})").substr(0, 8), "policy: ");
  for (const std::string value : {"0", "-5", "1.5", "\"soon\"", "86400001"}) {
    const std::string shown = value == "\"soon\"" ? "soon" : value;
    EXPECT_EQ(problemOf("{\"timeoutMilliseconds\":" + value + "}"),
              "timeoutMilliseconds: expected a whole number of milliseconds from 1 to 86400000, found " + shown);
  }
}

}  // namespace
}  // namespace espalier::server::remote_settings_test
