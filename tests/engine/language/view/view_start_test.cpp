// View commands for the start of the turtle, and Espalier's own commands about drawing.

#include <gtest/gtest.h>

#include "engine/core/streams.h"
#include "engine/language/view/view_file.h"

namespace espalier::language::view_start_test {
namespace {

ViewFileResult read(const std::string& text) {
  core::MemoryFileProvider files({{"m.v", text}});
  return readViewFile("m.v", files, core::Compatibility::Espalier, core::Limits{});
}

TEST(ViewStart, TheTurtleStartsElsewhereAndLooksElsewhere) {
  const files::ViewSettings settings = read("initial position: 1,2,3\ninitial heading: 0,0,5\n").settings;
  EXPECT_EQ(settings.initialPosition, (core::Vec3{1.0, 2.0, 3.0}));
  EXPECT_EQ(settings.initialHeading, (core::Vec3{0.0, 0.0, 1.0}));
  EXPECT_EQ(read("").settings.initialHeading, (core::Vec3{0.0, 1.0, 0.0}));
}

TEST(ViewStart, AHeadingWithoutLengthIsIgnoredWithAWarning) {
  const ViewFileResult result = read("initial heading: 0,0,0\n");
  EXPECT_EQ(result.settings.initialHeading, (core::Vec3{0.0, 1.0, 0.0}));
  ASSERT_EQ(result.diagnostics.entries().size(), 1U);
  EXPECT_EQ(result.diagnostics.entries().front().message, "the initial heading has no length and is ignored");
  EXPECT_EQ(result.diagnostics.entries().front().location.line, 1U);
}

TEST(ViewStart, DrawingCanBeDisplaced) {
  EXPECT_EQ(read("displacement: 0.5,-1,0\n").settings.displacement, (core::Vec3{0.5, -1.0, 0.0}));
}

TEST(ViewStart, EntriesOfTheColourMapAreColours) {
  const files::ViewSettings settings = read("color map entry: 0 255,255,255\ncolor map entry: 7 1,2,3\n").settings;
  EXPECT_EQ(settings.colourEntries.at(0), (files::PaletteColour{255, 255, 255}));
  EXPECT_EQ(settings.colourEntries.at(7), (files::PaletteColour{1, 2, 3}));
  EXPECT_TRUE(read("").settings.colourEntries.empty());
}

TEST(ViewStart, AnEntryOutOfRangeIsIgnoredWithAWarning) {
  for (const char* const text : {"color map entry: 256 1,2,3\n", "color map entry: 3 1,2,256\n"}) {
    const ViewFileResult result = read(text);
    EXPECT_TRUE(result.settings.colourEntries.empty()) << text;
    ASSERT_EQ(result.diagnostics.entries().size(), 1U) << text;
    EXPECT_EQ(result.diagnostics.entries().front().message,
              "a color map has entries 0 to 255 with red, green and blue from 0 to 255; this one is ignored");
  }
}

}  // namespace
}  // namespace espalier::language::view_start_test
