#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "engine/core/diagnostic.h"

namespace espalier::language {

/// A colour as a picture shows it, each component 0 to 255.
struct PaletteColour {
  std::uint8_t red = 200;  // the colour of an index without a map
  std::uint8_t green = 200;
  std::uint8_t blue = 200;

  constexpr bool operator==(const PaletteColour&) const = default;
};

/// A material of a `.mat` file; components 0 to 1. The defaults are those of a number that the file does not have.
struct Material {
  std::array<double, 3> ambient{0.0, 0.0, 0.0};
  std::array<double, 3> diffuse{1.0, 1.0, 1.0};
  std::array<double, 3> emission{0.0, 0.0, 0.0};
  std::array<double, 3> specular{0.0, 0.0, 0.0};
  double opacity = 1.0;
  double shininess = 0.0;  // exponent, 0 to 128 in published files

  bool operator==(const Material&) const = default;
};

/// The colours of a model folder: what the turtle's colour indices look like.
struct Palette {
  static constexpr int kBlockSize = 256;
  static constexpr int kLargestBlock = 11;

  /// Colour maps and material sets by block: block b serves the indices 256·b to 256·b + 255.
  std::map<int, std::array<PaletteColour, kBlockSize>> maps;
  std::map<int, std::array<Material, kBlockSize>> materials;
  bool usesMaterials = false;  // of maps and materials, the one that was named last
  int base = 1;                // the turtle's colour n is index 256·base + n

  [[nodiscard]] bool empty() const { return maps.empty() && materials.empty(); }
  /// The material of a turtle colour.
  [[nodiscard]] Material material(int turtleColour) const;
  /// What a turtle colour looks like: its map entry, or the diffuse and emitted colour of its material.
  [[nodiscard]] PaletteColour colour(int turtleColour) const;
  /// Map entry 0, or the emission of material 0.
  [[nodiscard]] PaletteColour background() const;
};

/// Reads a colour map `.map` (768 bytes, 256 times red, green, blue) into a block. A shorter file leaves the other
/// indices grey, with a warning.
void readColourMap(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics);

/// Reads a material set `.mat` (records of 15 bytes) into a block. A later record of a number wins; an incomplete last
/// record is left out, with a warning.
void readMaterials(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics);

}  // namespace espalier::language
