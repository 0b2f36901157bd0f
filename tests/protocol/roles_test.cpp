#include "protocol/roles.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace espalier::protocol::roles_test {
namespace {

using Names = std::vector<std::string>;

TEST(Roles, OnlyTheRolesThatATokenHasAreGranted) {
  const Roles controller{Role::Controller};
  const Roles viewer{Role::Viewer};
  EXPECT_EQ(viewer.granted({"controller", "viewer"}).names(), Names{"viewer"});
  EXPECT_TRUE(viewer.granted({"controller", "environment"}).isEmpty());
  // a controller may view and offer
  EXPECT_EQ(controller.granted({"viewer", "environment"}).names(), (Names{"viewer", "environment"}));
  EXPECT_EQ(controller.granted({"emperor", "viewer"}).names(), Names{"viewer"});
  // without a wish all
  EXPECT_EQ(viewer.granted({}).names(), Names{"viewer"});
}

TEST(Roles, WhatIsGrantedAllowsNoMore) {
  const Roles granted = Roles{Role::Controller}.granted({"viewer"});
  EXPECT_TRUE(granted.allows(Role::Anyone));
  EXPECT_TRUE(granted.allows(Role::Viewer));
  EXPECT_FALSE(granted.allows(Role::Environment));
  EXPECT_FALSE(granted.allows(Role::Controller));
}

}  // namespace
}  // namespace espalier::protocol::roles_test
