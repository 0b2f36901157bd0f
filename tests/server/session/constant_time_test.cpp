#include "server/session/constant_time.h"

#include <gtest/gtest.h>

namespace espalier::server {
namespace {

TEST(ConstantTime, OnlyTheSecretItselfIsEqual) {
  EXPECT_TRUE(isEqualInConstantTime("secret", "secret"));
  EXPECT_TRUE(isEqualInConstantTime("", ""));
  for (const std::string_view said : {"", "s", "secre", "secret ", "Secret", "secretsecret", "tecret", "secres"}) {
    EXPECT_FALSE(isEqualInConstantTime(said, "secret")) << said;
  }
  EXPECT_FALSE(isEqualInConstantTime("x", ""));
}

}  // namespace
}  // namespace espalier::server
