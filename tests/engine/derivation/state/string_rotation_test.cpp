#include "engine/derivation/state/string_rotation.h"

#include <gtest/gtest.h>

#include <array>
#include <optional>

namespace espalier::derivation::string_rotation_test {
namespace {

ModuleString stringOf(std::size_t modules) {
  ModuleString string;
  for (std::size_t i = 0; i < modules; ++i) {
    string.append(1, std::array{0.5});
  }
  return string;
}

const double* memoryOf(const ModuleString& string) {
  return string.parameters().data();
}

TEST(StringRotation, AStringThatNobodyReadsStaysWhereItIs) {
  StringRotation rotation;
  ModuleString string = stringOf(100);
  const double* const memory = memoryOf(string);
  rotation.ownParameters(string);
  EXPECT_EQ(memoryOf(string), memory);
  rotation.clear(string);
  EXPECT_TRUE(string.empty());
  string.append(1, std::array{2.0});
  EXPECT_EQ(memoryOf(string), memory);
}

TEST(StringRotation, ReadersKeepTheirStringAndTheirMemoryComesBack) {
  StringRotation rotation;
  ModuleString string = stringOf(100);
  const double* const first = memoryOf(string);
  std::optional<ModuleString> reader = string.share();
  // the reader goes on; the string is elsewhere
  rotation.ownParameters(string);
  EXPECT_NE(memoryOf(string), first);
  EXPECT_EQ(string.parameters()[99], 0.5);
  string.setParameter(0, 7.0);
  EXPECT_EQ(reader->parameters()[0], 0.5);
  EXPECT_EQ(memoryOf(*reader), first);
  // the types were not written and are still in one place
  EXPECT_EQ(string.types().data(), reader->types().data());

  // another reader, while the first is done: its memory is used again
  const ModuleString next = string.share();
  reader.reset();
  rotation.ownParameters(string);
  EXPECT_EQ(memoryOf(string), first);
  EXPECT_EQ(string.parameters()[0], 7.0);
  EXPECT_EQ(next.parameters()[0], 7.0);
}

TEST(StringRotation, ClearingLeavesWhatIsRead) {
  StringRotation rotation;
  ModuleString string = stringOf(100);
  const ModuleString reader = string.share();
  rotation.clear(string);
  string.append(2, {});
  EXPECT_EQ(reader.size(), 100U);
  EXPECT_EQ(reader.types()[0], 1);
  EXPECT_EQ(string.size(), 1U);
}

}  // namespace
}  // namespace espalier::derivation::string_rotation_test
