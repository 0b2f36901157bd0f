#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "engine/core/diagnostic.h"

namespace espalier::files {

/// A colour as a picture shows it, each component 0 to 255.
struct PaletteColour {
  std::uint8_t red = 200;  // the colour of an index without a map
  std::uint8_t green = 200;
  std::uint8_t blue = 200;

  constexpr bool operator==(const PaletteColour&) const = default;
};

/// A material of a `.mat` file; components 0 to 1. The defaults hold for numbers that the file does not have.
struct Material {
  std::array<double, 3> ambient{0.0, 0.0, 0.0};
  std::array<double, 3> diffuse{1.0, 1.0, 1.0};
  std::array<double, 3> emission{0.0, 0.0, 0.0};
  std::array<double, 3> specular{0.0, 0.0, 0.0};
  double opacity = 1.0;
  double shininess = 0.0;  // exponent, 0 to 128 in published files

  bool operator==(const Material&) const = default;
};

/// The colours of a model folder: the look of each colour index of the turtle.
struct Palette {
  static constexpr int kBlockSize = 256;
  static constexpr int kLargestBlock = 11;

  /// Colour maps and material sets by block: block b serves the indices 256·b to 256·b + 255.
  std::map<int, std::array<PaletteColour, kBlockSize>> maps;
  std::map<int, std::array<Material, kBlockSize>> materials;
  bool usesMaterials = false;  // whether the last file of the command is a material set
  int base = 1;                // the turtle's colour n is index 256·base + n

  [[nodiscard]] bool empty() const { return maps.empty() && materials.empty(); }
  /// The material of a turtle colour.
  [[nodiscard]] Material material(int turtleColour) const;
  /// The shown colour of a turtle colour: its map entry, or the diffuse plus the emitted colour of its material.
  [[nodiscard]] PaletteColour colour(int turtleColour) const;
  /// Map entry 0, or the emission of material 0.
  [[nodiscard]] PaletteColour background() const;
};

/// Reads a colour map `.map` (768 bytes, 256 times red, green, blue) into a block. A shorter file leaves the other
/// indices grey, with a warning.
void readColourMap(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics);

/// Reads a material set `.mat` (records of 15 bytes) into a block. Of two records with one number the later counts.
/// An incomplete last record is ignored, with a warning.
void readMaterials(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics);

}  // namespace espalier::files
