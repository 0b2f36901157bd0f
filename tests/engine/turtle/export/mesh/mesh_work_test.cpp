#include "engine/turtle/export/mesh/mesh_work.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace espalier::turtle {
namespace {

constexpr std::size_t kMeshCount = 1000;

/// Meshes of 0 to 6 vertices; the bytes of each are its number and that of its first vertex.
struct CountedMeshes {
  std::uint64_t vertexCount = 0;
  std::string text;
  std::vector<std::size_t> used;
  MeshWork work;

  CountedMeshes() {
    work.make = [](std::size_t i, Mesh& mesh) -> std::optional<std::string> {
      EXPECT_TRUE(mesh.positions.empty());
      mesh.positions.resize(i % 7);
      return std::nullopt;
    };
    work.number = [this](std::size_t, const Mesh& mesh) {
      const std::uint64_t first = vertexCount;
      vertexCount += mesh.positions.size();
      return first;
    };
    work.spell = [](std::size_t i, const Mesh&, std::uint64_t first, std::string& bytes) {
      bytes += std::to_string(i) + ":" + std::to_string(first) + "\n";
    };
    work.use = [this](std::size_t i, const Mesh& mesh, std::string_view bytes) -> std::optional<std::string> {
      EXPECT_EQ(mesh.positions.size(), i % 7);
      text += bytes;
      used.push_back(i);
      return std::nullopt;
    };
  }
};

std::vector<std::size_t> firstNumbers(std::size_t count) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    numbers.push_back(i);
  }
  return numbers;
}

TEST(MeshWork, BytesAreUsedInOrderByEachNumberOfThreads) {
  std::string expected;
  std::uint64_t first = 0;
  for (std::size_t i = 0; i < kMeshCount; ++i) {
    expected += std::to_string(i) + ":" + std::to_string(first) + "\n";
    first += i % 7;
  }
  for (const unsigned threads : {1U, 2U, 4U, 7U}) {
    core::WorkerTeam team(threads);
    CountedMeshes counted;
    EXPECT_EQ(forMeshes(team, kMeshCount, counted.work), std::nullopt);
    EXPECT_EQ(counted.text, expected) << threads;
    EXPECT_EQ(counted.used, firstNumbers(kMeshCount));
  }
}

TEST(MeshWork, NeitherNumbersNorBytesAreNeeded) {
  for (const unsigned threads : {1U, 4U}) {
    core::WorkerTeam team(threads);
    CountedMeshes counted;
    counted.work.number = nullptr;
    counted.work.spell = nullptr;
    EXPECT_EQ(forMeshes(team, kMeshCount, counted.work), std::nullopt);
    EXPECT_EQ(counted.text, "");
    EXPECT_EQ(counted.used, firstNumbers(kMeshCount));
    EXPECT_EQ(forMeshes(team, 0, counted.work), std::nullopt);
    EXPECT_EQ(counted.used.size(), kMeshCount);
  }
}

TEST(MeshWork, TheFirstMeshThatCannotBeWrittenEndsTheWork) {
  for (const unsigned threads : {1U, 2U, 4U}) {
    core::WorkerTeam team(threads);
    CountedMeshes counted;
    counted.work.make = [](std::size_t i, Mesh& mesh) -> std::optional<std::string> {
      mesh.positions.resize(i % 7);
      return i >= 500 ? std::optional("mesh " + std::to_string(i)) : std::nullopt;
    };
    EXPECT_EQ(forMeshes(team, kMeshCount, counted.work), "mesh 500");
    EXPECT_EQ(counted.used, firstNumbers(500));
  }
}

TEST(MeshWork, UseCanEndTheWork) {
  for (const unsigned threads : {1U, 2U, 4U}) {
    core::WorkerTeam team(threads);
    CountedMeshes counted;
    counted.work.use = [&](std::size_t i, const Mesh&, std::string_view) -> std::optional<std::string> {
      counted.used.push_back(i);
      return i == 300 ? std::optional<std::string>("full") : std::nullopt;
    };
    EXPECT_EQ(forMeshes(team, kMeshCount, counted.work), "full");
    EXPECT_EQ(counted.used, firstNumbers(301));
  }
}

TEST(MeshWork, WhileOneThreadIsSlowToUseTheOthersGoOnAndTheirMeshesAreBounded) {
  // each mesh has 1 MB; while the first is used, the others are made until about 32 MB are held
  constexpr std::size_t kVertices = 20'000;
  core::WorkerTeam team(2);
  std::atomic<std::size_t> made = 0;
  std::size_t used = 0;
  std::size_t mostHeld = 0;
  MeshWork work;
  work.make = [&](std::size_t, Mesh& mesh) -> std::optional<std::string> {
    mesh.positions.resize(kVertices);
    mesh.normals.resize(kVertices);
    ++made;
    return std::nullopt;
  };
  work.use = [&](std::size_t i, const Mesh&, std::string_view) -> std::optional<std::string> {
    if (i == 0) {
      while (made < 24) {
        std::this_thread::yield();
      }
    }
    ++used;
    mostHeld = std::max(mostHeld, made - used);
    return std::nullopt;
  };
  EXPECT_EQ(forMeshes(team, 400, work), std::nullopt);
  EXPECT_EQ(used, 400U);
  // four tasks of eight meshes, and one that is being made
  EXPECT_LE(mostHeld, 40U);
}

TEST(MeshWork, WhileOneThreadIsSlowToMakeAMeshTheMeshesOfTheOthersAreBounded) {
  // 1 MB each; the first takes so long that all others could be made
  constexpr std::size_t kVertices = 20'000;
  core::WorkerTeam team(2);
  std::atomic<std::size_t> made = 0;
  std::size_t madeMeanwhile = 0;
  MeshWork work;
  work.make = [&](std::size_t i, Mesh& mesh) -> std::optional<std::string> {
    if (i == 0) {
      while (made < 24) {
        std::this_thread::yield();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      madeMeanwhile = made;
    }
    mesh.positions.resize(kVertices);
    mesh.normals.resize(kVertices);
    ++made;
    return std::nullopt;
  };
  work.use = [](std::size_t, const Mesh&, std::string_view) -> std::optional<std::string> { return std::nullopt; };
  EXPECT_EQ(forMeshes(team, 400, work), std::nullopt);
  EXPECT_LE(madeMeanwhile, 40U);
}

TEST(MeshWork, AnExceptionOfAnyPieceEndsTheWork) {
  const auto refuse = [](std::size_t i) {
    if (i == 400) {
      throw std::runtime_error("no memory");
    }
  };
  for (const unsigned threads : {1U, 2U, 4U}) {
    core::WorkerTeam team(threads);
    for (const int piece : {0, 1, 2, 3}) {
      CountedMeshes counted;
      MeshWork work = counted.work;
      work.make = [&](std::size_t i, Mesh& mesh) {
        refuse(piece == 0 ? i : 0);
        return counted.work.make(i, mesh);
      };
      work.number = [&](std::size_t i, const Mesh& mesh) {
        refuse(piece == 1 ? i : 0);
        return counted.work.number(i, mesh);
      };
      work.spell = [&](std::size_t i, const Mesh& mesh, std::uint64_t number, std::string& bytes) {
        refuse(piece == 2 ? i : 0);
        counted.work.spell(i, mesh, number, bytes);
      };
      work.use = [&](std::size_t i, const Mesh& mesh, std::string_view bytes) {
        refuse(piece == 3 ? i : 0);
        return counted.work.use(i, mesh, bytes);
      };
      EXPECT_THROW(static_cast<void>(forMeshes(team, kMeshCount, work)), std::runtime_error) << piece;
      EXPECT_LE(counted.used.size(), 400U);
    }
  }
}

}  // namespace
}  // namespace espalier::turtle
