#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/palette.h"

namespace espalier::turtle {

/// A picture that meshes wear.
struct MeshTexture {
  std::string name;  // `texture_1`, unique in a file
  const files::Texture* texture = nullptr;

  /// The bytes of a file that holds the picture, and its suffix: the view file's own when it is PNG or JPEG, else PNG.
  [[nodiscard]] std::string fileBytes() const;
  [[nodiscard]] std::string suffix() const;
  /// Some points of the picture are not opaque: it has holes.
  [[nodiscard]] bool hasHoles() const;
};

/// The organs that a material is for: lines and generalized cylinders; polygons, surfaces and patches; spheres and
/// discs.
enum class MaterialUse : std::uint8_t { Bark, Leaf, Fruit };

/// The paint of a mesh.
struct MeshMaterial {
  static constexpr std::uint32_t kNoTexture = 0xFFFFFFFF;

  std::string name;  // `bark`, `leaf` or `fruit`; of further colours `leaf_12`; unique in a file
  MaterialUse use = MaterialUse::Bark;
  std::int32_t number = 0;  // of its colour: Palette::materialOf
  Colour colour;
  std::optional<files::Material> folder;  // of the model folder
  std::uint32_t texture = kNoTexture;     // index into MaterialTable::textures

  /// Red, green, blue, 0 to 1.
  [[nodiscard]] std::array<double, 3> diffuse() const;
  [[nodiscard]] double opacity() const { return folder ? folder->opacity : 1.0; }
};

/// The materials of a file: each use of a colour with each texture that it wears, once, also when several scenes have
/// it.
class MaterialTable {
 public:
  /// The material of a number of the palette (Palette::materialOf) with a texture of the view file, from 1; 0: none.
  std::uint32_t add(const Palette& palette, MaterialUse use, std::int32_t number, const files::ViewSettings& view,
                    std::int32_t texture);

  [[nodiscard]] std::span<const MeshMaterial> materials() const { return materials_; }
  [[nodiscard]] std::span<const MeshTexture> textures() const { return textures_; }

 private:
  /// Gives each name once; one that was given before gets a number behind it.
  class UniqueNames {
   public:
    [[nodiscard]] std::string of(const std::string& name);

   private:
    std::unordered_map<std::string, int> numbers_;  // by given name: the last number that was tried behind it
  };

  std::uint32_t addTexture(const files::Texture& texture, std::int32_t number);

  std::vector<MeshMaterial> materials_;
  std::vector<MeshTexture> textures_;
  // of materials, by use, number and texture: several only where scenes have other colours
  std::map<std::tuple<MaterialUse, std::int32_t, std::uint32_t>, std::vector<std::uint32_t>> places_;
  std::set<MaterialUse> uses_;
  UniqueNames materialNames_;
  UniqueNames textureNames_;
};

/// A component of a colour as light: files of glTF and USD hold linear numbers.
[[nodiscard]] double linearComponent(double component);

}  // namespace espalier::turtle
