#include "engine/turtle/export/mesh/mesh_material.h"

#include <algorithm>
#include <array>

#include "engine/core/elementary.h"
#include "engine/core/streams.h"
#include "engine/files/images/image_file.h"
#include "engine/turtle/export/picture/png.h"

namespace espalier::turtle {

namespace {

bool isEqual(const Colour& a, const Colour& b) {
  return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

}  // namespace

std::string MeshTexture::fileBytes() const {
  if (files::isPng(*texture->bytes) || files::isJpeg(*texture->bytes)) {
    return *texture->bytes;
  }
  core::StringSink sink;
  static_cast<void>(writePng(*texture->image, sink));
  return sink.take();
}

std::string MeshTexture::suffix() const {
  return files::isJpeg(*texture->bytes) ? ".jpg" : ".png";
}

bool MeshTexture::hasHoles() const {
  const std::vector<std::uint8_t>& pixels = texture->image->pixels;
  for (std::size_t at = 3; at < pixels.size(); at += 4) {
    if (pixels[at] < 255) {
      return true;
    }
  }
  return false;
}

std::array<double, 3> MeshMaterial::diffuse() const {
  return folder ? folder->diffuse : std::array{colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0};
}

std::string MaterialTable::UniqueNames::of(const std::string& name) {
  std::string unique = name;
  while (!numbers_.try_emplace(unique, 1).second) {
    unique = name + "_" + std::to_string(++numbers_[name]);
  }
  return unique;
}

std::uint32_t MaterialTable::addTexture(const files::Texture& texture, std::int32_t number) {
  const auto found = std::ranges::find_if(textures_, [&](const MeshTexture& other) {
    return (other.texture->bytes == texture.bytes || *other.texture->bytes == *texture.bytes) &&
           other.texture->use == texture.use && other.texture->isSmoothNear == texture.isSmoothNear &&
           other.texture->minification == texture.minification;
  });
  if (found == textures_.end()) {
    textures_.push_back({textureNames_.of("texture_" + std::to_string(number)), &texture});
    return static_cast<std::uint32_t>(textures_.size() - 1);
  }
  return static_cast<std::uint32_t>(found - textures_.begin());
}

std::uint32_t MaterialTable::add(const Palette& palette, MaterialUse use, std::int32_t number,
                                 const files::ViewSettings& view, std::int32_t texture) {
  MeshMaterial material{.name = {},
                        .use = use,
                        .number = number,
                        .colour = palette.ofMaterial(number),
                        .folder = palette.folderMaterial(number)};
  if (texture > 0) {
    material.texture = addTexture(view.textures[static_cast<std::size_t>(texture) - 1], texture);
  }
  std::vector<std::uint32_t>& places = places_[{use, number, material.texture}];
  for (const std::uint32_t place : places) {
    if (isEqual(materials_[place].colour, material.colour) && materials_[place].folder == material.folder) {
      return place;
    }
  }
  constexpr std::array<std::string_view, 3> kNames{"bark", "leaf", "fruit"};
  material.name = kNames[static_cast<std::size_t>(use)];
  if (!uses_.insert(use).second) {
    // branches of default colours are numbered by their order
    material.name += "_" + std::to_string(number % 256);
  }
  material.name = materialNames_.of(material.name);
  places.push_back(static_cast<std::uint32_t>(materials_.size()));
  materials_.push_back(std::move(material));
  return places.back();
}

double linearComponent(double component) {
  return component <= 0.04045 ? component / 12.92 : core::pow((component + 0.055) / 1.055, 2.4);
}

}  // namespace espalier::turtle
