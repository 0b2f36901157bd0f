#include "server/data_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "server_fixture.h"

namespace espalier::server {
namespace {

TEST(DataFolder, IsUsedByOneServerAtATime) {
  const TemporaryFolder folder;
  std::optional<DataFolder> first(DataFolder(folder.path()));
  EXPECT_EQ(first->prepare(), std::nullopt);
  DataFolder second(folder.path());
  EXPECT_EQ(second.prepare().value_or(""), "the data folder '" + folder.path() +
                                               "' is used by another server. Stop it, or give --data another folder.");
  // the lock goes with its owner
  first.reset();
  EXPECT_EQ(second.prepare(), std::nullopt);
}

TEST(DataFolder, AFileInItsPlaceIsAnErrorThatSaysWhatToDo) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/taken";
  std::ofstream(file) << "no folder";
  const std::string problem = DataFolder(file).prepare().value_or("");
  EXPECT_EQ(problem.find("cannot use the data folder '" + file + "': "), 0U) << problem;
  EXPECT_NE(problem.find("Give --data a folder that can be written."), std::string::npos) << problem;
}

TEST(DataFolder, KeepsRecordAndSnapshotUntilRemoved) {
  const TemporaryFolder folder;
  DataFolder data(folder.path());
  ASSERT_EQ(data.prepare(), std::nullopt);
  SimulationRecord record;
  record.id = "sim-1";
  record.seed = 7;
  record.hasSeed = true;
  record.create.name = "bush";
  ASSERT_EQ(data.saveRecord(record), std::nullopt);
  ASSERT_EQ(data.saveSnapshot("sim-1", "state"), std::nullopt);
  std::vector<std::string> problems;
  const auto loaded = data.loadAll(problems);
  ASSERT_EQ(loaded.size(), 1U);
  EXPECT_EQ(loaded[0].record.id, "sim-1");
  EXPECT_EQ(loaded[0].record.seed, 7U);
  EXPECT_TRUE(loaded[0].record.hasSeed);
  EXPECT_EQ(loaded[0].record.create.name, "bush");
  EXPECT_EQ(loaded[0].snapshot, "state");
  data.remove("sim-1");
  EXPECT_TRUE(data.loadAll(problems).empty());
}

}  // namespace
}  // namespace espalier::server
