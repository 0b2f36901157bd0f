#include <gtest/gtest.h>

#include <string>

#include "engine/files/colour_files.h"

namespace espalier::files::colour_files_test {
namespace {

std::string map() {
  std::string bytes;
  for (int i = 0; i < 256; ++i) {
    bytes += static_cast<char>(i);
    bytes += static_cast<char>(255 - i);
    bytes += '\x07';
  }
  return bytes;
}

std::string record(int number, int transparency, int diffuse, int emission) {
  std::string bytes;
  for (const int value : {number, transparency, 1, 2, 3, diffuse, 0, 255, emission, 0, 0, 51, 0, 0, 40}) {
    bytes += static_cast<char>(value);
  }
  return bytes;
}

TEST(ColourMap, ServesTheIndicesOfItsBlock) {
  Palette palette;
  core::DiagnosticList diagnostics;
  readColourMap(map(), "a.map", 1, palette, diagnostics);
  EXPECT_TRUE(diagnostics.entries().empty());
  EXPECT_EQ(palette.colour(0), (PaletteColour{0, 255, 7}));
  EXPECT_EQ(palette.colour(200), (PaletteColour{200, 55, 7}));
  EXPECT_EQ(palette.background(), palette.colour(0));
  // index 256 + 256 belongs to block 2, which has no map
  EXPECT_EQ(palette.colour(256), (PaletteColour{200, 200, 200}));
  EXPECT_EQ(palette.colour(-1), (PaletteColour{200, 200, 200}));
  readColourMap(map(), "b.map", 2, palette, diagnostics);
  EXPECT_EQ(palette.colour(257), (PaletteColour{1, 254, 7}));
}

TEST(ColourMap, ShortFileLeavesTheRestGreyWithAWarning) {
  Palette palette;
  core::DiagnosticList diagnostics;
  readColourMap(map().substr(0, 7), "a.map", 1, palette, diagnostics);
  EXPECT_EQ(palette.colour(1), (PaletteColour{1, 254, 7}));
  EXPECT_EQ(palette.colour(2), (PaletteColour{200, 200, 200}));
  ASSERT_EQ(diagnostics.warningCount(), 1U);
  EXPECT_EQ(core::formatDiagnostic(diagnostics.entries()[0]),
            "a.map: warning: the colour map has 7 bytes instead of 768; the missing colours are grey");
}

TEST(Materials, RecordsAreReadByTheirNumberAndTheLastWins) {
  Palette palette;
  core::DiagnosticList diagnostics;
  readMaterials(record(9, 0, 10, 0) + record(0, 0, 0, 51) + record(9, 51, 102, 0), "a.mat", 1, palette, diagnostics);
  EXPECT_TRUE(diagnostics.entries().empty());
  const Material material = palette.material(9);
  EXPECT_DOUBLE_EQ(material.opacity, 0.8);
  EXPECT_DOUBLE_EQ(material.ambient[1], 2 / 255.0);
  EXPECT_DOUBLE_EQ(material.diffuse[0], 0.4);
  EXPECT_DOUBLE_EQ(material.specular[0], 0.2);
  EXPECT_EQ(material.shininess, 40.0);
  EXPECT_EQ(palette.colour(9), (PaletteColour{102, 0, 255}));
  EXPECT_EQ(palette.background(), (PaletteColour{51, 0, 0}));
  // a material that the file does not have is white
  EXPECT_EQ(palette.material(8), Material{});
  EXPECT_EQ(palette.colour(8), (PaletteColour{255, 255, 255}));
}

TEST(Materials, IncompleteLastRecordIsLeftOutWithAWarning) {
  Palette palette;
  core::DiagnosticList diagnostics;
  readMaterials(record(3, 0, 10, 0) + "xyz", "a.mat", 1, palette, diagnostics);
  ASSERT_EQ(diagnostics.warningCount(), 1U);
  EXPECT_EQ(diagnostics.entries()[0].message,
            "a material file has records of 15 bytes; the last 3 of its 18 bytes are left out");
}

TEST(Palette, TheKindReadLastCounts) {
  Palette palette;
  core::DiagnosticList diagnostics;
  readMaterials(record(1, 0, 10, 0), "a.mat", 1, palette, diagnostics);
  readColourMap(map(), "a.map", 1, palette, diagnostics);
  EXPECT_EQ(palette.colour(1), (PaletteColour{1, 254, 7}));
}

}  // namespace
}  // namespace espalier::files::colour_files_test
