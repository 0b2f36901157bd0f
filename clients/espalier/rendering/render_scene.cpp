#include "clients/espalier/rendering/render_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/turtle/export/mesh/placed_meshes.h"

namespace espalier::command {

using core::Vec3;

namespace {

constexpr int kMostHoles = 64;  // surfaces that a ray may pass through
// shares of a leaf's colour that it throws back and lets through; light that comes through is yellower
constexpr double kLeafThrownBack = 0.78;
constexpr Light kLeafLetThrough{0.50, 0.48, 0.22};
constexpr double kMostThrownBack = 0.9;  // of all light that arrives
constexpr double kLeafShine = 0.06;
constexpr double kLeafShininess = 24.0;

Light linear(const std::array<double, 3>& colour) {
  return {turtle::linearComponent(colour[0]), turtle::linearComponent(colour[1]), turtle::linearComponent(colour[2])};
}

// as much of a colour as a real surface throws back, and of a leaf's what it lets through
void setDiffuse(Paint& paint, const Light& colour, bool isLeaf) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double c = std::clamp(colour[k], 0.0, 1.0);
    paint.thrownBack[k] = (isLeaf ? kLeafThrownBack : kMostThrownBack) * c;
    paint.letThrough[k] = isLeaf ? std::min(kLeafLetThrough[k] * c, kMostThrownBack - paint.thrownBack[k]) : 0.0;
  }
}

Paint paintOf(const turtle::MeshMaterial& material) {
  Paint paint;
  const bool isLeaf = material.use == turtle::MaterialUse::Leaf;
  setDiffuse(paint, linear(material.diffuse()), isLeaf);
  paint.opacity = material.opacity();
  if (material.folder) {
    paint.emitted = linear(material.folder->emission);
    paint.shine = linear(material.folder->specular);
    paint.shininess = std::max(1.0, material.folder->shininess);
  } else if (isLeaf) {
    paint.shine = {kLeafShine, kLeafShine, kLeafShine};
    paint.shininess = kLeafShininess;
  }
  return paint;
}

}  // namespace

RenderScene::RenderScene(const turtle::PlacedScenes& placed) {
  turtle::PlacedMeshes meshes(placed);
  for (const turtle::MeshMaterial& material : meshes.materials()) {
    Material made{.paint = paintOf(material)};
    if (material.texture != turtle::MeshMaterial::kNoTexture) {
      const turtle::MeshTexture& texture = meshes.textures()[material.texture];
      made.texture = static_cast<std::uint32_t>(textures_.size());
      textures_.emplace_back(*texture.texture, material.colour);
      made.isWhiteBelow = textures_.back().hidesColour();
      hasHoles_ = hasHoles_ || texture.hasHoles();
    }
    made.isLeaf = material.use == turtle::MaterialUse::Leaf;
    hasHoles_ = hasHoles_ || made.paint.opacity < 1.0;
    materials_.push_back(std::move(made));
  }
  double lowest = std::numeric_limits<double>::infinity();
  problem_ = meshes.forEach([&](const turtle::PlacedMeshes::Item& item,
                                const turtle::Mesh& mesh) -> std::optional<std::string> {
    const auto first = static_cast<std::uint32_t>(places_.size());
    if (places_.size() + mesh.positions.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
      return std::string("the scene has too many corners to be rendered: use a smaller --detail");
    }
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      places_.push_back(mesh.positions[i]);
      lowest = std::min(lowest, mesh.positions[i].y);
      const Vec3& normal = mesh.normals[i];
      normals_.push_back({static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)});
      coordinates_.push_back({static_cast<float>(mesh.coordinates[i][0]), static_cast<float>(mesh.coordinates[i][1])});
    }
    for (const auto& face : mesh.faces) {
      corners_.push_back({first + face[0], first + face[1], first + face[2]});
      materialOf_.push_back(item.part.material);
      if (face[3] != turtle::Mesh::kNoVertex) {
        corners_.push_back({first + face[0], first + face[2], first + face[3]});
        materialOf_.push_back(item.part.material);
      }
    }
    return std::nullopt;
  });
  if (problem_) {
    corners_.clear();
  }
  lowest_ = corners_.empty() ? 0.0 : lowest;
  rays_.emplace(places_, corners_, std::nullopt, environment::RayCaster::middleOf(places_), meshes.team().size());
}

std::array<double, 3> RenderScene::weightsOf(std::uint32_t triangle, const Vec3& origin, const Vec3& direction,
                                             double& distance) const {
  // Möller & Trumbore 1997
  const auto& [a, b, c] = corners_[triangle];
  const Vec3 ab = places_[b] - places_[a];
  const Vec3 ac = places_[c] - places_[a];
  const Vec3 p = core::cross(direction, ac);
  const double determinant = core::dot(ab, p);
  if (determinant == 0.0) {
    distance = 0.0;
    return {1.0, 0.0, 0.0};
  }
  const Vec3 s = origin - places_[a];
  const double u = std::clamp(core::dot(s, p) / determinant, 0.0, 1.0);
  const Vec3 q = core::cross(s, ab);
  const double v = std::clamp(core::dot(direction, q) / determinant, 0.0, 1.0 - u);
  distance = core::dot(ac, q) / determinant;
  return {1.0 - u - v, u, v};
}

std::array<float, 4> RenderScene::texel(const Material& material, std::uint32_t triangle,
                                        const std::array<double, 3>& weights) const {
  double u = 0.0;
  double v = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    u += weights[k] * coordinates_[corners_[triangle][k]][0];
    v += weights[k] * coordinates_[corners_[triangle][k]][1];
  }
  return textures_[material.texture].at(u, v, 0);
}

double RenderScene::opacityAt(std::uint32_t triangle, const std::array<double, 3>& weights) const {
  const Material& material = materials_[materialOf_[triangle]];
  return material.paint.opacity * (material.texture < textures_.size() ? texel(material, triangle, weights)[3] : 1.0F);
}

Paint RenderScene::paintAt(std::uint32_t triangle, const std::array<double, 3>& weights) const {
  const Material& material = materials_[materialOf_[triangle]];
  Paint paint = material.paint;
  if (material.texture < textures_.size()) {
    const std::array<float, 4> texel = this->texel(material, triangle, weights);
    const Light worn = linear({texel[0], texel[1], texel[2]});
    if (material.isWhiteBelow) {
      setDiffuse(paint, worn, material.isLeaf);
    } else {
      for (std::size_t k = 0; k < 3; ++k) {
        paint.thrownBack[k] *= worn[k];
        paint.letThrough[k] *= worn[k];
      }
    }
    paint.opacity *= texel[3];
  }
  return paint;
}

std::optional<Meeting> RenderScene::meet(const Vec3& origin, const Vec3& direction) const {
  const environment::RayCaster::Hit hit = rays_->firstHit(origin, direction, margin());
  if (hit.triangle == environment::RayCaster::kMiss) {
    return std::nullopt;
  }
  Meeting met;
  double distance = 0.0;
  const std::array<double, 3> weights = weightsOf(hit.triangle, origin, direction, distance);
  const auto& [a, b, c] = corners_[hit.triangle];
  met.place = weights[0] * places_[a] + weights[1] * places_[b] + weights[2] * places_[c];
  met.facing = core::normalised(core::cross(places_[b] - places_[a], places_[c] - places_[a]));
  if (core::dot(met.facing, direction) > 0.0) {
    met.facing = -met.facing;
  }
  Vec3 smooth;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& normal = normals_[corners_[hit.triangle][k]];
    smooth = smooth + weights[k] * Vec3{normal[0], normal[1], normal[2]};
  }
  smooth = core::normalised(smooth);
  // the smooth normal counts on the side of the flat one
  met.normal = core::dot(smooth, met.facing) < 0.0 ? -smooth : smooth;
  if (!(core::dot(met.normal, met.normal) > 0.5)) {
    met.normal = met.facing;
  }
  met.paint = paintAt(hit.triangle, weights);
  return met;
}

double RenderScene::arriving(Vec3 origin, const Vec3& direction) const {
  if (!hasHoles_) {
    return rays_->isFree(origin, direction, margin()) ? 1.0 : 0.0;
  }
  double share = 1.0;
  for (int passed = 0; passed < kMostHoles && share > 0.01; ++passed) {
    const environment::RayCaster::Hit hit = rays_->firstHit(origin, direction, margin());
    if (hit.triangle == environment::RayCaster::kMiss) {
      return share;
    }
    double distance = 0.0;
    const std::array<double, 3> weights = weightsOf(hit.triangle, origin, direction, distance);
    share *= 1.0 - opacityAt(hit.triangle, weights);
    origin = origin + std::max(distance, margin()) * direction;
  }
  return 0.0;
}

}  // namespace espalier::command
