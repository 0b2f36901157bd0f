#include "engine/turtle/export/picture/raster_pen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/export/picture/bitmap_font.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kThinnestRadius = 0.3;  // pixels; thinner lines are drawn so that they stay visible
constexpr double kThinRadius = 0.6;      // pixels, below which a round line has one shade across
constexpr int kMostColumns = 12;         // of the half of a round line
constexpr float kRimShade = 0.72F;       // of a disc that faces the viewer
constexpr int kMostRings = 12;           // of the half of a ball
constexpr double kTextPixel = 1.5;       // side of one point of a letter, in pixels of the page

// subdivisions of a quarter circle of so many pixels that is to look round
int roundness(double radius, int least, int most) {
  return std::clamp(static_cast<int>(std::ceil(1.4 * std::sqrt(radius))), least, most);
}

// the unit vector across `axis` and `towardViewer`; any across the axis when both agree
Vec3 across(const Vec3& axis, const Vec3& towardViewer) {
  const Vec3 side = core::cross(axis, towardViewer);
  if (core::length(side) > 1e-9) {
    return core::normalised(side);
  }
  const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  return core::normalised(core::cross(axis, other));
}

}  // namespace

RasterPen::RasterPen(const RasterCamera& camera, const RasterShading& shading, const Look& look, std::uint32_t organ,
                     std::vector<RasterTriangle>& triangles)
    : camera_(camera), shading_(shading), look_(look), organ_(organ), triangles_(triangles) {}

RasterVertex RasterPen::vertex(const Vec3& place, const Vec3& normal) const {
  const PagePoint p = camera_.onPage(place);
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.nearness),
          shading_.lit(look_, place, normal, p.depth)};
}

RasterVertex RasterPen::plainVertex(const Vec3& place) const {
  const PagePoint p = camera_.onPage(place);
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.nearness),
          shading_.plain(look_, p.depth)};
}

void RasterPen::triangle(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c) {
  triangles_.push_back({{a, b, c}, static_cast<float>(look_.opacity), nullptr, organ_});
}

RasterVertex RasterPen::wornVertex(RasterVertex vertex, const Vec3& place, const std::array<double, 2>& uv) const {
  // on the page of a perspective a texture is linear only in what is divided by the depth
  const double depth = camera_.onPage(place).depth;
  const double share = camera_.projection().isPerspective() && depth > 0.0 ? 1.0 / depth : 1.0;
  vertex.u = static_cast<float>(uv[0] * share);
  vertex.v = static_cast<float>(uv[1] * share);
  vertex.share = static_cast<float>(share);
  return vertex;
}

void RasterPen::quad(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c, const RasterVertex& d) {
  triangle(a, b, c);
  triangle(a, c, d);
}

double RasterPen::leastRadius(const Vec3& place, double radius) const {
  return std::max(radius, kThinnestRadius / camera_.onPage(place).pixelsPerUnit);
}

void RasterPen::mesh(const Mesh& mesh) {
  for (const auto& face : mesh.faces) {
    const std::size_t corners = face[3] == Mesh::kNoVertex ? 3 : 4;
    if (shading_.isWireframe()) {
      for (std::size_t i = 0; i < corners; ++i) {
        edge(mesh.positions[face[i]], mesh.positions[face[(i + 1) % corners]]);
      }
      continue;
    }
    const Vec3 faceNormal = core::normalised(core::cross(mesh.positions[face[1]] - mesh.positions[face[0]],
                                                         mesh.positions[face[2]] - mesh.positions[face[0]]));
    std::array<RasterVertex, 4> v;
    for (std::size_t i = 0; i < corners; ++i) {
      const std::uint32_t at = face[i];
      v[i] = vertex(mesh.positions[at], shading_.isFlat() ? faceNormal : mesh.normals[at]);
      if (look_.texture != nullptr) {
        v[i] = wornVertex(v[i], mesh.positions[at], mesh.coordinates[at]);
      }
    }
    triangle(v[0], v[1], v[2]);
    triangles_.back().texture = look_.texture;
    if (corners == 4) {
      triangle(v[0], v[2], v[3]);
      triangles_.back().texture = look_.texture;
    }
  }
}

void RasterPen::roundLine(const LineEnd& a, const LineEnd& b) {
  if (shading_.isWireframe()) {
    return edge(a.place, b.place);
  }
  const std::array<const LineEnd*, 2> ends{&a, &b};
  std::array<double, 2> radii{};
  double pixels = 0.0;
  for (std::size_t e = 0; e < 2; ++e) {
    radii[e] = leastRadius(ends[e]->place, ends[e]->radius);
    pixels = std::max(pixels, radii[e] * camera_.onPage(ends[e]->place).pixelsPerUnit);
  }
  const bool isThin = pixels < kThinRadius;
  const int columns = isThin ? 1 : 2 * roundness(pixels, 1, kMostColumns / 2);
  // the half rings from one silhouette over the front to the other
  std::array<std::array<RasterVertex, kMostColumns + 1>, 2> rings;
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3 side = across(ends[e]->tangent, camera_.projection().towardViewer(ends[e]->place));
    const Vec3 front = core::cross(side, ends[e]->tangent);
    for (int k = 0; k <= columns; ++k) {
      const double angle = std::numbers::pi * k / columns;
      const Vec3 radial = core::cos(angle) * side + core::sin(angle) * front;
      rings[e][static_cast<std::size_t>(k)] =
          vertex(ends[e]->place + radii[e] * radial, isThin || shading_.isFlat() ? front : radial);
    }
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(columns); ++k) {
    quad(rings[0][k], rings[1][k], rings[1][k + 1], rings[0][k + 1]);
  }
  for (std::size_t e = 0; e < 2; ++e) {
    if (ends[e]->shape == LineEnd::Shape::Round && !isThin) {
      ball(ends[e]->place, radii[e]);
    } else if (ends[e]->shape == LineEnd::Shape::Flat && !isThin) {
      flatEnd(*ends[e], radii[e], e == 0 ? -ends[e]->tangent : ends[e]->tangent);
    }
  }
}

void RasterPen::strip(const LineEnd& a, const LineEnd& b) {
  if (shading_.isWireframe()) {
    return edge(a.place, b.place);
  }
  const std::array<const LineEnd*, 2> ends{&a, &b};
  std::array<std::array<RasterVertex, 2>, 2> sides;
  for (std::size_t e = 0; e < 2; ++e) {
    const LineEnd& end = *ends[e];
    const Vec3 normal = core::normalised(core::cross(end.tangent, end.left));
    Vec3 half = end.radius * core::normalised(core::cross(normal, end.tangent));
    // seen from its edge a strip would vanish
    const Vec3 toward = camera_.projection().towardViewer(end.place);
    const Vec3 side = across(end.tangent, toward);
    const double least = leastRadius(end.place, 0.0);
    const double seen = core::dot(half, side);
    if (std::abs(seen) < least) {
      half = half + ((seen < 0.0 ? -least : least) - seen) * side;
    }
    sides[e] = {vertex(end.place - half, normal), vertex(end.place + half, normal)};
  }
  quad(sides[0][0], sides[1][0], sides[1][1], sides[0][1]);
}

void RasterPen::pixelLine(const LineEnd& a, const LineEnd& b) {
  if (shading_.isWireframe()) {
    return edge(a.place, b.place);
  }
  RasterVertex from = plainVertex(a.place);
  RasterVertex to = plainVertex(b.place);
  const double dx = static_cast<double>(to.x) - static_cast<double>(from.x);
  const double dy = static_cast<double>(to.y) - static_cast<double>(from.y);
  const double length = core::hypot(dx, dy);
  const double nx = length > 0.0 ? dy / length : 1.0;
  const double ny = length > 0.0 ? -dx / length : 0.0;
  const auto shifted = [nx, ny](RasterVertex v, double radius) {
    v.x = static_cast<float>(static_cast<double>(v.x) + radius * nx);
    v.y = static_cast<float>(static_cast<double>(v.y) + radius * ny);
    return v;
  };
  const double r0 = std::max(a.radius, kThinnestRadius);
  const double r1 = std::max(b.radius, kThinnestRadius);
  quad(shifted(from, -r0), shifted(to, -r1), shifted(to, r1), shifted(from, r0));
  // round joints and ends, where they can be seen
  if (r0 > 1.0 && a.shape != LineEnd::Shape::Joint) {
    pageDisc(from, r0);
  }
  if (r1 > 1.0) {
    pageDisc(to, r1);
  }
}

void RasterPen::ball(const Vec3& centre, double givenRadius) {
  const double radius = leastRadius(centre, givenRadius);
  const double pixels = radius * camera_.onPage(centre).pixelsPerUnit;
  const Vec3 toward = camera_.projection().towardViewer(centre);
  const Vec3 side = across(core::normalised(camera_.projection().up()), toward);
  const Vec3 up = core::cross(toward, side);
  const auto rings = static_cast<std::size_t>(roundness(pixels, 1, kMostRings));
  const auto sides = static_cast<std::size_t>(4 * roundness(pixels, 1, kMostRings));
  std::array<Vec3, 4 * kMostRings> radials;
  for (std::size_t k = 0; k < sides; ++k) {
    const double longitude = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(sides);
    radials[k] = core::cos(longitude) * side + core::sin(longitude) * up;
  }
  if (shading_.isWireframe()) {
    for (std::size_t k = 0; k < sides; ++k) {
      edge(centre + radius * radials[k], centre + radius * radials[(k + 1) % sides]);
    }
    return;
  }
  // rings from the pole outward, each joined to the one before
  const RasterVertex pole = vertex(centre + radius * toward, toward);
  std::array<RasterVertex, 4 * kMostRings> inner;
  std::array<RasterVertex, 4 * kMostRings> outer;
  inner.fill(pole);
  for (std::size_t ring = 1; ring <= rings; ++ring) {
    const double latitude = 0.5 * std::numbers::pi * static_cast<double>(ring) / static_cast<double>(rings);
    for (std::size_t k = 0; k < sides; ++k) {
      const Vec3 normal = core::cos(latitude) * toward + core::sin(latitude) * radials[k];
      outer[k] = vertex(centre + radius * normal, shading_.isFlat() ? toward : normal);
    }
    for (std::size_t k = 0; k < sides; ++k) {
      const std::size_t next = (k + 1) % sides;
      triangle(inner[k], outer[k], outer[next]);
      if (ring > 1) {
        triangle(inner[k], outer[next], inner[next]);
      }
    }
    inner = outer;
  }
}

void RasterPen::flatEnd(const LineEnd& end, double radius, const Vec3& outward) {
  const Vec3 toward = camera_.projection().towardViewer(end.place);
  if (core::dot(outward, toward) <= 0.0) {
    return;
  }
  const Vec3 side = across(outward, toward);
  const Vec3 up = core::cross(side, outward);
  const int sides = 4 * roundness(radius * camera_.onPage(end.place).pixelsPerUnit, 2, 12);
  const auto rim = [&](int k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    return vertex(end.place + radius * (core::cos(angle) * side + core::sin(angle) * up), outward);
  };
  const RasterVertex centre = vertex(end.place, outward);
  for (int k = 0; k < sides; ++k) {
    triangle(centre, rim(k), rim(k + 1));
  }
}

void RasterPen::screenDisc(const Vec3& centre, double radius) {
  // the line that ends in it is behind it
  const Vec3 front = centre + radius * camera_.projection().towardViewer(centre);
  pageDisc(plainVertex(front), std::max(radius * camera_.onPage(centre).pixelsPerUnit, kThinnestRadius),
           shading_.isLit() ? kRimShade : 1.0F);
}

void RasterPen::pageDisc(const RasterVertex& centre, double radius, float rimShade) {
  const int sides = 4 * roundness(radius, 2, 12);
  const auto rim = [&](int k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    RasterVertex v = centre;
    v.x = static_cast<float>(static_cast<double>(v.x) + radius * core::cos(angle));
    v.y = static_cast<float>(static_cast<double>(v.y) + radius * core::sin(angle));
    for (float& channel : v.colour) {
      channel *= rimShade;
    }
    return v;
  };
  for (int k = 0; k < sides; ++k) {
    triangle(centre, rim(k), rim(k + 1));
  }
}

void RasterPen::edge(const Vec3& a, const Vec3& b) {
  const RasterVertex from = plainVertex(a);
  const RasterVertex to = plainVertex(b);
  const double dx = static_cast<double>(to.x) - static_cast<double>(from.x);
  const double dy = static_cast<double>(to.y) - static_cast<double>(from.y);
  const double length = core::hypot(dx, dy);
  if (!(length > 0.0)) {
    return;
  }
  const auto shifted = [&](RasterVertex v, double side) {
    v.x = static_cast<float>(static_cast<double>(v.x) + side * 0.5 * dy / length);
    v.y = static_cast<float>(static_cast<double>(v.y) - side * 0.5 * dx / length);
    return v;
  };
  quad(shifted(from, -1.0), shifted(to, -1.0), shifted(to, 1.0), shifted(from, 1.0));
}

void RasterPen::text(const Vec3& place, std::string_view text) {
  RasterVertex pen = plainVertex(place);
  pen.nearness = std::numeric_limits<float>::max();
  const auto point = [&](double column, double row) {
    RasterVertex v = pen;
    v.x = static_cast<float>(static_cast<double>(pen.x) + kTextPixel * column);
    v.y = static_cast<float>(static_cast<double>(pen.y) + kTextPixel * (row - kLetterRows));
    return v;
  };
  double left = 0.0;
  for (const char letter : text) {
    const auto columns = letterColumns(letter);
    for (std::size_t column = 0; column < columns.size(); ++column) {
      for (int row = 0; row < kLetterRows; ++row) {
        if ((columns[column] >> row & 1) != 0) {
          const double x = left + static_cast<double>(column);
          quad(point(x, row), point(x + 1, row), point(x + 1, row + 1), point(x, row + 1));
        }
      }
    }
    left += static_cast<double>(columns.size()) + 1.0;
  }
}

}  // namespace espalier::turtle
