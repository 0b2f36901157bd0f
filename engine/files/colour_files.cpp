#include "engine/files/colour_files.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace espalier::files {
namespace {

constexpr std::size_t kMapBytes = 768;
constexpr std::size_t kRecordBytes = 15;

double component(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]) / 255.0;
}

std::array<double, 3> triple(std::string_view bytes, std::size_t i) {
  return {component(bytes, i), component(bytes, i + 1), component(bytes, i + 2)};
}

std::uint8_t toByte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255.0));
}

void warn(const std::string& file, std::string message, core::DiagnosticList& diagnostics) {
  core::Diagnostic diagnostic;
  diagnostic.severity = core::Severity::Warning;
  diagnostic.message = std::move(message);
  diagnostic.location.file = file;
  diagnostics.add(std::move(diagnostic));
}

/// Block and place in the block of a turtle colour.
std::pair<int, std::size_t> place(int turtleColour, int base) {
  const std::int64_t index = static_cast<std::int64_t>(turtleColour) + std::int64_t{Palette::kBlockSize} * base;
  const std::int64_t block = index >= 0 ? index / Palette::kBlockSize : (index + 1) / Palette::kBlockSize - 1;
  return {static_cast<int>(block), static_cast<std::size_t>(index - block * Palette::kBlockSize)};
}

PaletteColour shown(const Material& material) {
  return {toByte(material.diffuse[0] + material.emission[0]), toByte(material.diffuse[1] + material.emission[1]),
          toByte(material.diffuse[2] + material.emission[2])};
}

}  // namespace

Material Palette::material(int turtleColour) const {
  const auto [block, entry] = place(turtleColour, base);
  const auto found = materials.find(block);
  return found == materials.end() ? Material{} : found->second[entry];
}

PaletteColour Palette::colour(int turtleColour) const {
  if (usesMaterials) {
    return shown(material(turtleColour));
  }
  const auto [block, entry] = place(turtleColour, base);
  const auto found = maps.find(block);
  return found == maps.end() ? PaletteColour{} : found->second[entry];
}

PaletteColour Palette::background() const {
  if (!usesMaterials) {
    return colour(0);
  }
  const Material first = material(0);
  return {toByte(first.emission[0]), toByte(first.emission[1]), toByte(first.emission[2])};
}

void readColourMap(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics) {
  if (bytes.size() < kMapBytes) {
    warn(file,
         "the colour map has " + std::to_string(bytes.size()) + " bytes instead of 768; the missing colours are grey",
         diagnostics);
  }
  std::array<PaletteColour, Palette::kBlockSize> map{};
  for (std::size_t i = 0; i < map.size() && 3 * i + 2 < bytes.size(); ++i) {
    map[i] = {static_cast<std::uint8_t>(bytes[3 * i]), static_cast<std::uint8_t>(bytes[3 * i + 1]),
              static_cast<std::uint8_t>(bytes[3 * i + 2])};
  }
  palette.maps[block] = map;
  palette.usesMaterials = false;
}

void readMaterials(std::string_view bytes, const std::string& file, int block, Palette& palette,
                   core::DiagnosticList& diagnostics) {
  if (bytes.size() % kRecordBytes != 0) {
    warn(file,
         "a material file has records of 15 bytes; the last " + std::to_string(bytes.size() % kRecordBytes) +
             " of its " + std::to_string(bytes.size()) + " bytes are left out",
         diagnostics);
  }
  std::array<Material, Palette::kBlockSize> set{};
  for (std::size_t i = 0; i + kRecordBytes <= bytes.size(); i += kRecordBytes) {
    const std::string_view record = bytes.substr(i, kRecordBytes);
    Material& material = set[static_cast<unsigned char>(record[0])];
    material.opacity = 1.0 - component(record, 1);
    material.ambient = triple(record, 2);
    material.diffuse = triple(record, 5);
    material.emission = triple(record, 8);
    material.specular = triple(record, 11);
    material.shininess = static_cast<unsigned char>(record[14]);
  }
  palette.materials[block] = set;
  palette.usesMaterials = true;
}

}  // namespace espalier::files
