#pragma once

#include <memory>
#include <string>
#include <utility>

#include "engine/core/streams.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/picture/png.h"

namespace espalier::turtle {

/// A texture of 2 by 2 points: red and green above, blue and white below.
inline files::Texture fourColours(files::Texture::Use use = files::Texture::Use::Modulate) {
  files::Image image{2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}};
  core::StringSink sink;
  static_cast<void>(writePng(image, sink));
  files::Texture texture;
  texture.file = "four.png";
  texture.bytes = std::make_shared<const std::string>(sink.take());
  texture.image = std::make_shared<const files::Image>(std::move(image));
  texture.use = use;
  return texture;
}

/// A flat surface `p`, a unit square in the plane of L and H, in front of the turtle; its own texture is the turtle's.
inline files::Surface unitSquare() {
  files::Surface surface;
  surface.id = 'p';
  files::SurfacePatch patch;
  for (std::size_t i = 0; i < 16; ++i) {
    patch.points[i] = {static_cast<double>(i / 4) / 3.0, static_cast<double>(i % 4) / 3.0, 0.0};
  }
  surface.patches.push_back(patch);
  return surface;
}

/// Cylinders, the surface `p` and texture 1.
inline files::ViewSettings texturedView() {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  view.surfaces.push_back(unitSquare());
  view.textures.push_back(fourColours());
  return view;
}

}  // namespace espalier::turtle
