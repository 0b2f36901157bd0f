#include "engine/files/source_map.h"

#include <gtest/gtest.h>

namespace espalier::files::source_map_test {
namespace {

SourceMap twoSegments() {
  SourceMap map;
  map.files = {{"a.l", "first\nsecond line\r\nlast"}};
  map.expansions = {{"R", 0, 0, 4}};
  // output "cond" copied from offset 8, then 6 bytes made by a macro used at offset 13
  map.segments = {{0, 0, 8, SourceMap::kNoExpansion}, {4, 0, 13, 0}};
  return map;
}

TEST(SourceMap, CopiedBytesMapOneByOne) {
  const core::SourceLocation place = twoSegments().locate({1, 3});
  EXPECT_EQ(place.file, "a.l");
  EXPECT_EQ(place.line, 2U);
  EXPECT_EQ(place.column, 4U);
  EXPECT_EQ(place.length, 2U);
  EXPECT_EQ(place.lineText, "second line");
  EXPECT_EQ(place.expansion, "");
}

TEST(SourceMap, RangeIsUnderlinedOnlyToTheEndOfItsSegment) {
  EXPECT_EQ(twoSegments().locate({2, 9}).length, 2U);
}

TEST(SourceMap, ExpansionMapsToTheUseOfTheMacro) {
  const core::SourceLocation place = twoSegments().locate({7, 8});
  EXPECT_EQ(place.line, 2U);
  EXPECT_EQ(place.column, 8U);
  EXPECT_EQ(place.length, 4U);
  EXPECT_EQ(place.expansion, "in the expansion of R (a.l:1:1)");
}

TEST(SourceMap, ExpansionOfACallersMacroSaysSo) {
  SourceMap map = twoSegments();
  map.expansions[0].file = SourceMap::kNoExpansion;
  EXPECT_EQ(map.locate({7, 8}).expansion, "in the expansion of R (defined by the caller)");
}

TEST(SourceMap, EmptyTextMapsToTheStartOfTheFile) {
  SourceMap map;
  map.files = {{"a.l", ""}};
  const core::SourceLocation place = map.locate({0, 0});
  EXPECT_EQ(place.line, 1U);
  EXPECT_EQ(place.column, 1U);
}

TEST(SourceMap, WithoutFilesNoPlaceIsKnown) {
  EXPECT_EQ(SourceMap().locate({0, 1}).file, "");
}

TEST(SourceMap, LocateInFileClampsToTheFileAndTheLine) {
  const SourceMap::File file{"a.l", "ab\ncd"};
  EXPECT_EQ(locateInFile(file, 99, 1).line, 2U);
  EXPECT_EQ(locateInFile(file, 99, 1).column, 3U);
  EXPECT_EQ(locateInFile(file, 0, 99).length, 2U);
}

}  // namespace
}  // namespace espalier::files::source_map_test
