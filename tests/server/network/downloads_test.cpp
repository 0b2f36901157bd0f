#include "server/network/downloads.h"

#include <gtest/gtest.h>

namespace espalier::server::downloads_test {
namespace {

std::string described(std::string_view target) {
  const auto path = downloadPathOf(target);
  if (!path) {
    return "(none)";
  }
  const char* const kinds[] = {"list", "export", "snapshot", "checkpoint", "trace", "picture", "fields", "field"};
  return std::string(kinds[static_cast<int>(path->kind)]) + " " + path->simulation + " " + path->name;
}

TEST(Downloads, ThePathSaysWhatIsAskedFor) {
  EXPECT_EQ(described("/simulations"), "list  ");
  EXPECT_EQ(described("/simulations?x=/"), "list  ");
  EXPECT_EQ(described("/simulations/sim-1/plant.glb"), "export sim-1 plant.glb");
  EXPECT_EQ(described("/simulations/sim-1/state.snapshot"), "snapshot sim-1 state.snapshot");
  EXPECT_EQ(described("/simulations/sim-1/checkpoints/before%20pruning"), "checkpoint sim-1 before pruning");
  EXPECT_EQ(described("/simulations/sim-1/checkpoints/a%2Fb"), "checkpoint sim-1 a/b");
  EXPECT_EQ(described("/simulations/sim-1/traces/12"), "trace sim-1 12");
  EXPECT_EQ(described("/simulations/sim-1/fields"), "fields sim-1 ");
  EXPECT_EQ(described("/simulations/sim-1/fields/soil.waterContent.vti"), "field sim-1 soil.waterContent.vti");
  EXPECT_EQ(described("/gallery/light-tree/light-tree.png"), "picture light-tree light-tree.png");
}

TEST(Downloads, OtherPathsAreNotDownloads) {
  for (const std::string_view target : {"/",
                                        "/simulations/sim-1/fields/a.png",
                                        "/simulations/sim-1/fields/.vti",
                                        "/simulationsX",
                                        "/simulations/",
                                        "/simulations/sim-1",
                                        "/simulations/sim-1/",
                                        "/simulations//a.glb",
                                        "/simulations/sim-1/traces/..%2F..%2Fsecret",
                                        "/simulations/sim-1/traces/-1",
                                        "/simulations/sim-1/traces/1e9",
                                        "/simulations/sim-1/traces/99999999999",
                                        "/simulations/sim-1/files/a.glb",
                                        "/simulations/a/b/c/d",
                                        "/simulations/sim-1/plant.glb/",
                                        "/simulations/sim-1/%zz.glb",
                                        "/simulations/sim-1/x%2",
                                        "/gallery/",
                                        "/gallery/a",
                                        "/gallery/a/b/c.png",
                                        "/gallery//x.png"}) {
    EXPECT_EQ(described(target), "(none)") << target;
  }
}

TEST(Downloads, AServerWithATokenWantsIt) {
  EXPECT_TRUE(downloadGrant("", Access({})));
  const Access access(
      {tokenOf("screen", "secret", {protocol::Role::Viewer}), tokenOf("light", "lamp", {protocol::Role::Environment})});
  EXPECT_TRUE(downloadGrant("Bearer secret", access));
  for (const char* wrong : {"", "Bearer ", "Bearer secre", "Bearer secret2", "secret", "Bearer lamp"}) {
    EXPECT_FALSE(downloadGrant(wrong, access)) << wrong;
  }
}

}  // namespace
}  // namespace espalier::server::downloads_test
