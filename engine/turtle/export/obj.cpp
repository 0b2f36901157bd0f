#include "engine/turtle/export/obj.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/turtle/export/mesh.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/text_output.h"
#include "engine/turtle/export/tubes.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr int kSphereRings = 8;
constexpr int kSphereSides = 12;
constexpr double kPixelsAcross = 800.0;  // a pixel's width is this part of the scene's extent

void writeComponents(std::string_view keyword, const std::array<double, 3>& components, TextOutput& out) {
  out << keyword;
  for (const double component : components) {
    out << ' ';
    out.number(component, 4);
  }
  out << '\n';
}

class ObjWriter {
 public:
  ObjWriter(const Scene& scene, const language::ViewSettings& view, const language::Palette* colours,
            core::ByteSink& sink)
      : scene_(scene), view_(view), palette_(scene, colours), out_(sink) {}

  void write(const std::string& materialFile);
  void writeMaterials(core::ByteSink& sink) const;

 private:
  [[nodiscard]] std::uint32_t plantCount() const;
  [[nodiscard]] double widthUnit() const;
  void writeBranches(std::uint32_t plant);
  void writePolygons(std::uint32_t plant);
  void writeSurfaces(std::uint32_t plant);
  void writeCylinders(std::uint32_t plant);
  void writeBalls(std::uint32_t plant);
  void beginOrgans(std::uint32_t plant, std::string_view kind);
  void writeMesh(std::int32_t material);
  void useMaterial(std::int32_t material);

  const Scene& scene_;
  const language::ViewSettings& view_;
  Palette palette_;
  TextOutput out_;
  Mesh mesh_;
  std::vector<std::int32_t> materials_;  // of each segment
  std::vector<SegmentChain> chains_;
  std::set<std::int32_t> used_;
  std::int32_t current_ = -1;      // material in use; -1: none
  std::uint64_t vertexCount_ = 0;  // written so far: positions, normals and texture coordinates run together
  std::string organs_;             // object that is written once its first mesh is
  int sides_ = 8;
};

std::uint32_t ObjWriter::plantCount() const {
  std::uint32_t last = 0;
  const auto look = [&last](const auto& organs) {
    for (const auto& organ : organs) {
      last = std::max(last, organ.plant);
    }
  };
  look(scene_.segments);
  look(scene_.polygons);
  look(scene_.surfaces);
  look(scene_.patches);
  look(scene_.cylinders);
  look(scene_.balls);
  return last + 1;
}

// world units per unit of line width: pixels have no size in the world, so one is a fixed part of the plant's extent
double ObjWriter::widthUnit() const {
  if (scene_.lineStyle != language::LineStyle::Pixel) {
    return 1.0;
  }
  Vec3 low{1e300, 1e300, 1e300};
  Vec3 high{-1e300, -1e300, -1e300};
  for (const Segment& segment : scene_.segments) {
    for (const Vec3& p : {segment.start, segment.end}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  const double extent = scene_.segments.empty() ? 0.0 : core::length(high - low);
  return extent > 0.0 ? extent / kPixelsAcross : 1.0;
}

void ObjWriter::beginOrgans(std::uint32_t plant, std::string_view kind) {
  organs_ = "o plant_" + std::to_string(plant) + "_" + std::string(kind) + "\ng plant_" + std::to_string(plant) + " " +
            std::string(kind) + "\n";
}

void ObjWriter::useMaterial(std::int32_t material) {
  if (material != current_) {
    out_ << "usemtl colour_";
    out_.integer(material) << '\n';
    current_ = material;
    used_.insert(material);
  }
}

void ObjWriter::writeMesh(std::int32_t material) {
  if (mesh_.faces.empty()) {
    return;
  }
  if (!organs_.empty()) {
    out_ << organs_;
    organs_.clear();
  }
  for (const Vec3& p : mesh_.positions) {
    out_ << "v ";
    out_.number(p.x, 6) << ' ';
    out_.number(p.y, 6) << ' ';
    out_.number(p.z, 6) << '\n';
  }
  for (const auto& uv : mesh_.coordinates) {
    out_ << "vt ";
    out_.number(uv[0], 5) << ' ';
    out_.number(uv[1], 5) << '\n';
  }
  for (const Vec3& n : mesh_.normals) {
    out_ << "vn ";
    out_.number(n.x, 5) << ' ';
    out_.number(n.y, 5) << ' ';
    out_.number(n.z, 5) << '\n';
  }
  useMaterial(material);
  for (const auto& face : mesh_.faces) {
    out_ << 'f';
    for (const std::uint32_t vertex : face) {
      if (vertex == Mesh::kNoVertex) {
        continue;
      }
      const std::string index = std::to_string(vertexCount_ + vertex + 1);
      out_ << ' ' << index << '/' << index << '/' << index;
    }
    out_ << '\n';
  }
  vertexCount_ += mesh_.positions.size();
  mesh_.clear();
}

void ObjWriter::writeBranches(std::uint32_t plant) {
  const double unit = widthUnit();
  beginOrgans(plant, "branches");
  for (const SegmentChain& chain : chains_) {
    if (scene_.segments[chain.front()].plant == plant) {
      appendTube(mesh_, ringsOf(scene_, chain, unit), sides_);
      writeMesh(materials_[chain.front()]);
    }
  }
}

void ObjWriter::writePolygons(std::uint32_t plant) {
  beginOrgans(plant, "polygons");
  for (const Polygon& polygon : scene_.polygons) {
    if (polygon.plant != plant || polygon.vertices.size() < 3) {
      continue;
    }
    Vec3 normal;
    for (std::size_t i = 0; i < polygon.vertices.size(); ++i) {
      normal = normal + core::cross(polygon.vertices[i], polygon.vertices[(i + 1) % polygon.vertices.size()]);
    }
    normal = core::length(normal) > 0.0 ? core::normalised(normal) : Vec3{0.0, 1.0, 0.0};
    const double turn = 6.283185307179586 / static_cast<double>(polygon.vertices.size());
    for (std::size_t i = 0; i < polygon.vertices.size(); ++i) {
      mesh_.positions.push_back(polygon.vertices[i]);
      mesh_.normals.push_back(normal);
      mesh_.coordinates.push_back(
          {0.5 + 0.5 * std::cos(turn * static_cast<double>(i)), 0.5 + 0.5 * std::sin(turn * static_cast<double>(i))});
    }
    // a fan from the first vertex
    for (std::uint32_t i = 1; i + 1 < polygon.vertices.size(); ++i) {
      mesh_.faces.push_back({0, i, i + 1, Mesh::kNoVertex});
    }
    writeMesh(((polygon.colour % 256) + 256) % 256);
  }
}

void ObjWriter::writeSurfaces(std::uint32_t plant) {
  beginOrgans(plant, "surfaces");
  for (const SurfaceInstance& surface : scene_.surfaces) {
    if (surface.plant == plant) {
      appendSurface(mesh_, surface, view_);
      writeMesh(((surface.colour % 256) + 256) % 256);
    }
  }
  for (const Patch& patch : scene_.patches) {
    if (patch.plant == plant) {
      appendPatch(mesh_, patch.points, patch.subdivisionS, patch.subdivisionT);
      writeMesh(((patch.colour % 256) + 256) % 256);
    }
  }
}

void ObjWriter::writeCylinders(std::uint32_t plant) {
  beginOrgans(plant, "cylinders");
  for (const GeneralizedCylinder& cylinder : scene_.cylinders) {
    if (cylinder.plant == plant) {
      appendCylinder(mesh_, cylinder, view_);
      writeMesh(((cylinder.points.front().colour % 256) + 256) % 256);
    }
  }
}

void ObjWriter::writeBalls(std::uint32_t plant) {
  beginOrgans(plant, "balls");
  for (const Ball& ball : scene_.balls) {
    if (ball.plant != plant) {
      continue;
    }
    if (ball.kind == Ball::Kind::Sphere) {
      appendSphere(mesh_, ball.centre, ball.diameter, kSphereRings, kSphereSides);
    } else {
      appendDisc(mesh_, ball, kSphereSides);
    }
    writeMesh(((ball.colour % 256) + 256) % 256);
  }
}

void ObjWriter::write(const std::string& materialFile) {
  sides_ = std::clamp(view_.contourSides, 3, 64);
  for (const Segment& segment : scene_.segments) {
    materials_.push_back(palette_.materialOf(segment));
  }
  chains_ = chainsOf(scene_, materials_);
  out_ << "# Espalier: 1 unit is 1 length unit of the model, y is up\n";
  if (!materialFile.empty()) {
    out_ << "mtllib " << materialFile << '\n';
  }
  const std::uint32_t plants = plantCount();
  for (std::uint32_t plant = 0; plant < plants; ++plant) {
    writeBranches(plant);
    writeCylinders(plant);
    writePolygons(plant);
    writeSurfaces(plant);
    writeBalls(plant);
  }
  out_.flush();
}

void ObjWriter::writeMaterials(core::ByteSink& sink) const {
  TextOutput out(sink);
  for (const std::int32_t material : used_) {
    out << "newmtl colour_";
    out.integer(material) << '\n';
    if (const std::optional<language::Material> own = palette_.folderMaterial(material)) {
      writeComponents("Kd", own->diffuse, out);
      writeComponents("Ka", own->ambient, out);
      writeComponents("Ks", own->specular, out);
      writeComponents("Ke", own->emission, out);
      out << "Ns ";
      out.number(own->shininess, 4) << "\nd ";
      out.number(own->opacity, 4) << "\nillum 2\n";
      continue;
    }
    const Colour colour = palette_.ofMaterial(material);
    writeComponents("Kd", {colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0}, out);
    out << "Ka 0 0 0\nKs 0.04 0.04 0.04\nNs 10\nillum 2\n";
  }
}

}  // namespace

std::optional<std::string> exportObj(const ExportInput& input, const ExportTarget& target) {
  ObjWriter writer(input.scene, input.view, input.palette, target.sink);
  const std::string materialFile = target.openCompanion ? withSuffix(target.fileName, ".mtl") : "";
  writer.write(materialFile);
  if (!materialFile.empty()) {
    writer.writeMaterials(target.openCompanion(materialFile));
  }
  if (target.progress) {
    target.progress(1, 1);
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
