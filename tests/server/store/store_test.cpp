#include "server/store/store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "server/store/compression.h"
#include "server/store/database.h"
#include "server/store/schema.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::store_test {
namespace {

/// Bytes that do not compress.
std::string noise(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::string bytes(size, '\0');
  for (char& byte : bytes) {
    byte = static_cast<char>(random());
  }
  return bytes;
}

std::unique_ptr<Store> openStore(const std::string& folder, std::uint64_t maximumBytes = 0) {
  auto store = std::make_unique<Store>(folder, maximumBytes);
  EXPECT_EQ(store->open().value_or(""), "");
  return store;
}

std::vector<Store::Entry> entriesOf(const Store& store) {
  return store.simulations().value();
}

TEST(Compression, GivesTheBytesBackAndSeesDamage) {
  for (const std::string& bytes :
       {std::string(), std::string("leaf"), std::string(3'000'000, 'x'), noise(100'000, 1)}) {
    std::string packed = compress(bytes);
    EXPECT_EQ(decompress(packed), bytes);
    packed.back() = static_cast<char>(packed.back() ^ 1);
    EXPECT_EQ(decompress(packed), std::nullopt);
    packed.pop_back();
    EXPECT_EQ(decompress(packed), std::nullopt);
  }
  EXPECT_EQ(decompress("no frame"), std::nullopt);
  EXPECT_LT(compress(std::string(3'000'000, 'x')).size(), 1'000U);
}

TEST(Store, IsUsedByOneServerAtATime) {
  const TemporaryFolder folder;
  auto first = openStore(folder.path());
  Store second(folder.path());
  EXPECT_EQ(second.open().value_or(""), "the data folder '" + folder.path() +
                                            "' is used by another server. Stop it, or give --data another folder.");
  // the lock goes with its owner
  first.reset();
  EXPECT_EQ(second.open(), std::nullopt);
}

TEST(Store, AFolderThatCannotBeUsedIsAnErrorThatSaysWhatToDo) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/taken";
  std::ofstream(file) << "no folder";
  const std::string problem = Store(file).open().value_or("");
  EXPECT_EQ(problem.find("cannot use the data folder '" + file + "': "), 0U) << problem;
  EXPECT_NE(problem.find("Give --data a folder that this user may read and write."), std::string::npos) << problem;
}

TEST(Store, ADamagedDatabaseIsNotUsedAndTheErrorNamesTheWayBack) {
  const auto problemOf = [](const TemporaryFolder& folder, const std::string& reason) {
    return "the database '" + folder.path() + "/espalier.sqlite' is damaged, or it is no database: " + reason +
           ". Make a new data folder of a backup (espalier restore FILE NEW-FOLDER), or give --data another folder.";
  };
  // a text in its place
  const TemporaryFolder text;
  std::ofstream(text.path() + "/espalier.sqlite") << std::string(5'000, 'x');
  EXPECT_EQ(Store(text.path()).open().value_or(""), problemOf(text, "file is not a database"));

  // the first half of a database
  const TemporaryFolder half;
  const std::string file = half.path() + "/espalier.sqlite";
  EXPECT_EQ(openStore(half.path())->save({"sim-1", "record", 3}, noise(100'000, 1)), std::nullopt);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_EQ(Store(half.path()).open().value_or(""), problemOf(half, "database disk image is malformed"));
}

TEST(Store, ADatabaseOfAnotherProgramIsLeftAlone) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/espalier.sqlite";
  {
    Database other;
    other.open(file);
    other.execute("CREATE TABLE birds(name TEXT)");
  }
  EXPECT_EQ(Store(folder.path()).open().value_or(""),
            "the database '" + file + "' was made by another program. Give --data another folder.");
  Database other;
  other.open(file);
  EXPECT_EQ(versionOf(other), 0);
}

TEST(Store, WithoutAFolderNothingIsKeptAndNothingFails) {
  Store store("");
  EXPECT_FALSE(store.isKept());
  EXPECT_EQ(store.open(), std::nullopt);
  EXPECT_EQ(store.save({"sim-1", "record", 3}, "state"), std::nullopt);
  EXPECT_TRUE(entriesOf(store).empty());
  EXPECT_EQ(store.bytes(), 0U);
  EXPECT_EQ(store.readCheckpoint("sim-1", "spring").problem,
            "this server keeps no checkpoints. Start it with --data DIR, or restore a snapshot");
}

TEST(Store, KeepsRecordAndStateAcrossRestartsUntilRemoved) {
  const TemporaryFolder folder;
  const std::string big = noise(3'500'000, 2);
  {
    const auto store = openStore(folder.path());
    ASSERT_EQ(store->save({"sim-2", "two", 0}, "first"), std::nullopt);
    ASSERT_EQ(store->save({"sim-1", "one", 0}, "first"), std::nullopt);
    ASSERT_EQ(store->saveState("sim-1", 7, big), std::nullopt);
  }
  const auto store = openStore(folder.path());
  const auto entries = entriesOf(*store);
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].id, "sim-1");
  EXPECT_EQ(entries[0].record, "one");
  EXPECT_EQ(entries[0].step, 7U);
  EXPECT_TRUE(store->readState("sim-1").bytes == big);
  EXPECT_EQ(store->readState("sim-2").bytes, "first");
  ASSERT_EQ(store->remove("sim-1"), std::nullopt);
  EXPECT_EQ(entriesOf(*store).size(), 1U);
  EXPECT_EQ(store->readState("sim-1").problem, "it has no state in the data folder");
}

TEST(Store, SpaceOfReplacedStatesIsUsedAgain) {
  const TemporaryFolder folder;
  const auto store = openStore(folder.path());
  ASSERT_EQ(store->save({"sim-1", "one", 0}, "first"), std::nullopt);
  for (std::uint32_t step = 1; step <= 20; ++step) {
    ASSERT_EQ(store->saveState("sim-1", step, noise(2'500'000, step)), std::nullopt);
  }
  // twenty states of 2.5 MB, of which one is kept; the log has a few megabytes of its own
  EXPECT_LT(std::filesystem::file_size(folder.path() + "/espalier.sqlite"), 10'000'000U);
  EXPECT_LT(store->bytes(), 30'000'000U);
}

TEST(Store, ADamagedStateIsSeen) {
  const TemporaryFolder folder;
  {
    const auto store = openStore(folder.path());
    ASSERT_EQ(store->save({"sim-1", "one", 0}, noise(50'000, 3)), std::nullopt);
  }
  // one byte in the middle of the state
  std::fstream file(folder.path() + "/espalier.sqlite", std::ios::in | std::ios::out | std::ios::binary);
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(folder.path() + "/espalier.sqlite"));
  const std::string part = compress(noise(50'000, 3)).substr(20'000, 64);
  std::string all(static_cast<std::size_t>(size), '\0');
  file.read(all.data(), size);
  const std::size_t at = all.find(part);
  ASSERT_NE(at, std::string::npos);
  file.seekp(static_cast<std::streamoff>(at));
  file.put(static_cast<char>(part[0] ^ 1));
  file.close();
  EXPECT_EQ(openStore(folder.path())->readState("sim-1").problem, "its state in the data folder is damaged");
}

TEST(Store, AFullDiskFailsTheWriteAndKeepsWhatWasThere) {
  const TemporaryFolder folder;
  const auto store = openStore(folder.path(), 3'000'000);
  ASSERT_EQ(store->save({"sim-1", "one", 0}, "first"), std::nullopt);
  const std::string problem = store->saveState("sim-1", 1, noise(5'000'000, 4)).value_or("");
  EXPECT_EQ(problem, "the data folder '" + folder.path() +
                         "' cannot be written: database or disk is full. Check that its disk has room and can be "
                         "written, then ask again.");
  EXPECT_EQ(store->readState("sim-1").bytes, "first");
  // the written part of it is given back
  EXPECT_EQ(store->saveState("sim-1", 1, noise(1'500'000, 5)), std::nullopt);
  EXPECT_TRUE(store->readState("sim-1").bytes == noise(1'500'000, 5));
}

TEST(Store, CheckpointsAreKeptByNameAndGoWithTheirSimulation) {
  const TemporaryFolder folder;
  const auto store = openStore(folder.path());
  ASSERT_EQ(store->save({"sim-1", "one", 0}, "now"), std::nullopt);
  ASSERT_EQ(store->saveCheckpoint("sim-1", "spring", 3, "third"), std::nullopt);
  ASSERT_EQ(store->saveCheckpoint("sim-1", "autumn", 9, "ninth"), std::nullopt);
  ASSERT_EQ(store->saveCheckpoint("sim-1", "spring", 4, "fourth"), std::nullopt);
  const auto all = store->checkpoints("sim-1");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].name, "spring");
  EXPECT_EQ(all[1].step, 4U);
  EXPECT_EQ(all[1].bytes, 6U);
  EXPECT_EQ(store->readCheckpoint("sim-1", "spring").bytes, "fourth");
  EXPECT_EQ(store->readCheckpoint("sim-1", "summer").problem,
            "there is no checkpoint 'summer'; simulation.get with \"what\":\"checkpoints\" lists them");
  ASSERT_EQ(store->remove("sim-1"), std::nullopt);
  EXPECT_TRUE(store->checkpoints("sim-1").empty());
}

TEST(Store, CheckpointsOfASimulationThatWasNeverSavedGoWithTheServer) {
  const TemporaryFolder folder;
  {
    const auto store = openStore(folder.path());
    ASSERT_EQ(store->save({"sim-1", "one", 0}, "now"), std::nullopt);
    ASSERT_EQ(store->saveCheckpoint("sim-1", "spring", 3, "third"), std::nullopt);
    ASSERT_EQ(store->saveCheckpoint("sim-2", "spring", 3, "third"), std::nullopt);
    EXPECT_EQ(store->checkpoints("sim-2").size(), 1U);
  }
  const auto store = openStore(folder.path());
  EXPECT_EQ(store->readCheckpoint("sim-1", "spring").bytes, "third");
  EXPECT_TRUE(store->checkpoints("sim-2").empty());
}

TEST(Store, KeepsModels) {
  const TemporaryFolder folder;
  {
    const auto store = openStore(folder.path());
    ASSERT_EQ(store->saveModel("model-1", "text"), std::nullopt);
  }
  const auto models = openStore(folder.path())->models();
  ASSERT_EQ(models.size(), 1U);
  EXPECT_EQ(models[0], (std::pair<std::string, std::string>("model-1", "text")));
}

TEST(Store, ManyWriteAtATime) {
  const TemporaryFolder folder;
  const auto store = openStore(folder.path());
  std::vector<std::thread> threads;
  for (std::uint32_t i = 0; i < 4; ++i) {
    threads.emplace_back([&store, i] {
      const std::string id = "sim-" + std::to_string(i);
      EXPECT_EQ(store->save({id, "record", 0}, "first"), std::nullopt);
      for (std::uint32_t step = 1; step <= 10; ++step) {
        EXPECT_EQ(store->saveState(id, step, noise(i == 0 ? 2'000'000 : 2'000, step + i)), std::nullopt);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(store->readState("sim-" + std::to_string(i)).bytes == noise(i == 0 ? 2'000'000 : 2'000, 10 + i)) << i;
  }
}

TEST(Store, TheDatabaseHasABoundOfItsMemory) {
  const TemporaryFolder folder;
  Database database;
  database.open(folder.path() + "/a.sqlite");
  database.execute("CREATE TABLE texts(text TEXT)");
  ASSERT_EQ(database.problem(), std::nullopt);
  EXPECT_GT(Database::memoryBytes(), 10'000U);
  const auto insert = [&] { database.execute("INSERT INTO texts VALUES(hex(zeroblob(200000000)))"); };
  // 200 million bytes and their 400 million digits
  insert();
  EXPECT_EQ(database.problem(), "out of memory");
  database.clearProblem();
  EXPECT_LE(Database::memoryBytes(), static_cast<std::uint64_t>(Database::kMostMemoryBytes));
  database.execute("INSERT INTO texts VALUES('short')");
  EXPECT_EQ(database.problem(), std::nullopt);
}

}  // namespace
}  // namespace espalier::server::store_test
