#include "engine/turtle/export/picture/raster_shading.h"

#include <algorithm>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kStrongestFade = 0.25;  // share of the page's colour in the farthest part
constexpr std::size_t kMostLights = 8;

// Espalier's own light, as shares of a surface's colour
constexpr double kSkyLight = 0.58;
constexpr double kGroundLight = 0.36;
constexpr double kKeyLight = 0.66;
constexpr double kFillLight = 0.16;
constexpr double kSheen = 0.10;  // white, around the mirrored key light
// the light through a leaf on its side away from a light, as a part of the light that it throws back; and, with the
// sky's light from above, its share of the light on a side that looks down
constexpr double kThroughLeaf = 0.6;
constexpr double kBelowLeaf = 0.54;
// the share of light where no light of the view file comes
constexpr double kLeastLight = 0.22;

Vec3 fraction(const Colour& colour) {
  return {colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0};
}

Vec3 vector(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

Vec3 product(const Vec3& a, const Vec3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

double highlight(const Vec3& normal, const Vec3& towardLight, const Vec3& towardViewer, double exponent) {
  const Vec3 half = core::normalised(towardLight + towardViewer);
  return core::pow(std::max(0.0, core::dot(normal, half)), exponent);
}

// how much of a point light or spot arrives, and its direction
double arrival(const files::Light& light, const Vec3& point, Vec3& towardLight) {
  if (light.isDirectional) {
    towardLight = core::normalised(light.place);
    return 1.0;
  }
  const double distance = core::length(light.place - point);
  towardLight = core::normalised(light.place - point);
  const Vec3& a = light.attenuation;
  const double weakening = a.x + a.y * distance + a.z * distance * distance;
  double strength = weakening > 0.0 ? 1.0 / weakening : 1.0;
  if (light.spotCutoffDegrees < 180.0) {
    const double along = -core::dot(towardLight, core::normalised(light.spotDirection));
    const bool isInside = along >= core::cos(light.spotCutoffDegrees * std::numbers::pi / 180.0);
    strength *= isInside ? core::pow(std::max(0.0, along), light.spotExponent) : 0.0;
  }
  return strength;
}

}  // namespace

const RasterTexture* RasterTextures::find(std::int32_t texture, const Colour& below) {
  if (texture <= 0) {
    return nullptr;
  }
  const files::Texture& picture = view_.textures[static_cast<std::size_t>(texture) - 1];
  const bool isForAll = picture.use == files::Texture::Use::Modulate;
  const std::pair key(texture, isForAll ? -1 : below.red << 16 | below.green << 8 | below.blue);
  const std::lock_guard lock(mutex_);
  return &textures_.try_emplace(key, picture, below).first->second;
}

RasterShading::RasterShading(const files::ViewSettings& view, const Projection& projection, const Palette& palette,
                             RasterTextures& textures, const PictureBounds& bounds, const Colour& background)
    : view_(view), projection_(projection), palette_(palette), textures_(textures), background_(fraction(background)) {
  const Vec3& right = projection.right();
  const Vec3& up = projection.up();
  const Vec3& toward = projection.towardViewer();
  key_ = view.lightDirection.value_or(core::normalised(-0.5 * right + 0.75 * up + 0.65 * toward));
  fill_ = core::normalised(0.85 * right + 0.1 * up + 0.5 * toward);
  sky_ = up;
  using files::RenderMode;
  isWireframe_ = view.renderMode == RenderMode::Wireframe;
  isLit_ = !isWireframe_ && view.renderMode != RenderMode::Filled;
  isFlat_ = view.renderMode == RenderMode::Flat;

  // a flat scene has no depth worth showing
  const double range = bounds.empty() ? 0.0 : bounds.farthest - bounds.nearest;
  const double extent = bounds.empty() ? 0.0 : std::max(bounds.right - bounds.left, bounds.top - bounds.bottom);
  if (range > 0.0 && extent > 0.0) {
    nearest_ = bounds.nearest;
    fadePerUnit_ = kStrongestFade * std::min(1.0, range / extent) / range;
  }
}

Look RasterShading::worn(Look look, std::int32_t texture) const {
  look.texture = isWireframe_ ? nullptr : textures_.find(texture, look.colour);
  if (look.texture != nullptr && look.texture->hidesColour()) {
    look.colour = {255, 255, 255};
    if (look.material) {
      look.material->diffuse = {1.0, 1.0, 1.0};
    }
  }
  return look;
}

Look RasterShading::lookOfIndex(std::int32_t index, std::int32_t texture) const {
  return worn({palette_.ofIndex(index), palette_.folderMaterial(index), palette_.opacityOfIndex(index)}, texture);
}

Look RasterShading::lookOf(const Segment& segment) const {
  return worn(
      {palette_.ofSegment(segment), palette_.folderMaterial(segment.colour), palette_.opacityOfIndex(segment.colour)},
      segment.texture);
}

Vec3 RasterShading::litByOwnLights(const Look& look, const Vec3& normal, const Vec3& towardViewer) const {
  const double height = 0.5 + 0.5 * core::dot(normal, sky_);
  const auto arriving = [&](const Vec3& towardLight) {
    const double facing = core::dot(normal, towardLight);
    return facing >= 0.0 ? facing : look.isThin ? -kThroughLeaf * facing : 0.0;
  };
  const double ground = look.isThin ? kBelowLeaf : kGroundLight;
  const double diffuse =
      ground + (kSkyLight - ground) * height + kKeyLight * arriving(key_) + kFillLight * arriving(fill_);
  // the 24th power
  const double mirrored = std::max(0.0, core::dot(normal, core::normalised(key_ + towardViewer)));
  const double eighth = mirrored * mirrored * mirrored * mirrored * mirrored * mirrored * mirrored * mirrored;
  const double sheen = kSheen * eighth * eighth * eighth;
  return fraction(look.colour) * diffuse + Vec3{sheen, sheen, sheen};
}

Vec3 RasterShading::litByViewLights(const Look& look, const Vec3& point, const Vec3& normal,
                                    const Vec3& towardViewer) const {
  const files::Material own;
  const bool hasMaterial = look.material.has_value();
  const files::Material& material = hasMaterial ? *look.material : own;
  const Vec3 diffuse = hasMaterial ? vector(material.diffuse) : fraction(look.colour);
  Vec3 colour = vector(material.emission) + kLeastLight * diffuse;
  for (std::size_t i = 0; i < std::min(view_.lights.size(), kMostLights); ++i) {
    const files::Light& light = view_.lights[i];
    Vec3 towardLight;
    const double strength = arrival(light, point, towardLight);
    const double incidence = std::max(0.0, core::dot(normal, towardLight));
    colour = colour + strength * (product(light.ambient, vector(material.ambient)) +
                                  incidence * product(light.diffuse, diffuse));
    if (incidence > 0.0) {
      const double shine = strength * highlight(normal, towardLight, towardViewer, material.shininess);
      colour = colour + shine * product(light.specular, vector(material.specular));
    }
  }
  return colour;
}

std::array<float, 3> RasterShading::faded(const Vec3& colour, double depth) const {
  const double t = std::clamp(fadePerUnit_ * (depth - nearest_), 0.0, kStrongestFade);
  const auto channel = [t](double value, double page) {
    const double seen = std::clamp(value, 0.0, 1.0);
    return static_cast<float>(255.0 * (seen + t * (page - seen)));
  };
  return {channel(colour.x, background_.x), channel(colour.y, background_.y), channel(colour.z, background_.z)};
}

std::array<float, 3> RasterShading::plain(const Look& look, double depth) const {
  return faded(fraction(look.colour), depth);
}

std::array<float, 3> RasterShading::lit(const Look& look, const Vec3& point, Vec3 normal, double depth) const {
  if (!isLit_) {
    return plain(look, depth);
  }
  const Vec3 towardViewer = projection_.towardViewer(point);
  if (core::dot(normal, towardViewer) < 0.0) {
    normal = -normal;
  }
  return faded(view_.lights.empty() ? litByOwnLights(look, normal, towardViewer)
                                    : litByViewLights(look, point, normal, towardViewer),
               depth);
}

}  // namespace espalier::turtle
