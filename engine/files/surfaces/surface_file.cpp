#include "engine/files/surfaces/surface_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::files {
namespace {

using core::Vec3;

constexpr int kDefaultSubdivision = 5;
constexpr int kMostSubdivision = 10;

/// The eight neighbours of a patch, in the order of the file, and the index of the patch in that neighbour's own list:
/// a neighbour above left names the patch as below right, and so on.
constexpr std::array<std::string_view, 8> kNeighbourKeywords = {
    "AL: ", "A: ", "AR: ", "L: ", "R: ", "BL: ", "B: ", "BR: "};
constexpr std::array<std::size_t, 8> kOpposite = {7, 6, 5, 4, 3, 2, 1, 0};

struct NamedPatch {
  SurfacePatch patch;
  std::string_view name;
  core::SourceRange range;
  std::array<std::string_view, 8> neighbours;
};

/// The head of the file: the placement of the surface in its own coordinates.
struct Placement {
  int precision = kDefaultSubdivision;
  Vec3 contact, end, heading, up;
  core::SourceRange headingRange;  // of its keyword
  double size = 1.0;
};

/// Reads the keywords and numbers of a `.s` file; a newline is a blank there.
class SurfaceReader {
 public:
  explicit SurfaceReader(const DataFile& file) : file_(file), cursor_(file.cursor()) {}

  bool readHead(Placement& placement) {
    if (cursor_.rest().starts_with("VERSION stedit")) {
      file_.warn({0, 14},
                 "the surface is in the format of the editor stedit, which the reference program does not read",
                 "save it in the format of surfaces; until then it is undefined; --compat cpfg draws nothing for it");
      return false;
    }
    // the bounding box is not used
    for (int i = 0; i < 6; ++i) {
      double ignored = 0.0;
      if (!number(ignored, "the six numbers of the bounding box")) {
        return false;
      }
    }
    cursor_.skipSpace();
    if (cursor_.takeKeywords("PRECISION S: ")) {
      int ignored = 0;
      if (!integer(placement.precision, "an integer after 'PRECISION S:'") || !keywords("T: ") ||
          !integer(ignored, "an integer after 'T:'")) {
        return false;
      }
    }
    if (!keywords("CONTACT POINT ") || !vector(placement.contact) || !keywords("END POINT ") ||
        !vector(placement.end)) {
      return false;
    }
    cursor_.skipSpace();
    const auto begin = static_cast<std::uint32_t>(cursor_.position());
    placement.headingRange = {begin, begin + 7};
    return keywords("HEADING ") && vector(placement.heading) && keywords("UP ") && vector(placement.up) &&
           keywords("SIZE: ") && number(placement.size, "a number after 'SIZE:'");
  }

  bool atEnd() {
    cursor_.skipSpace();
    return cursor_.atEnd();
  }

  bool readPatch(NamedPatch& patch) {
    cursor_.skipSpace();
    const std::size_t begin = cursor_.position();
    patch.name = cursor_.word();
    patch.range = cursor_.rangeFrom(begin);
    double ignored = 0.0;
    if (!keywords("TOP COLOR: ") || !integer(patch.patch.topColour, "a colour index") || !keywords("DIFFUSE: ") ||
        !number(ignored, "a diffuse factor") || !keywords("BOTTOM COLOR: ") ||
        !integer(patch.patch.bottomColour, "a colour index") || !keywords("DIFFUSE: ") ||
        !number(ignored, "a diffuse factor")) {
      return false;
    }
    for (std::size_t i = 0; i < kNeighbourKeywords.size(); ++i) {
      if (!keywords(kNeighbourKeywords[i])) {
        return false;
      }
      patch.neighbours[i] = cursor_.word();
    }
    for (Vec3& point : patch.patch.points) {
      if (!number(point.x, kPoints) || !number(point.y, kPoints) || !number(point.z, kPoints)) {
        return false;
      }
    }
    return true;
  }

 private:
  static constexpr std::string_view kPoints = "the 48 numbers of a patch";
  static constexpr std::string_view kContext = "a surface";

  bool keywords(std::string_view text) {
    cursor_.skipSpace();
    if (cursor_.takeKeywords(text)) {
      return true;
    }
    std::string_view shown = text;
    while (shown.ends_with(' ')) {
      shown.remove_suffix(1);
    }
    return fail("'" + std::string(shown) + "'");
  }
  bool number(double& value, std::string_view expected) {
    cursor_.skipSpace();
    const std::optional<double> read = cursor_.number();
    value = read.value_or(0.0);
    return read.has_value() || fail(std::string(expected));
  }
  bool integer(int& value, std::string_view expected) {
    cursor_.skipSpace();
    const std::optional<int> read = cursor_.integer();
    value = read.value_or(0);
    return read.has_value() || fail(std::string(expected));
  }
  bool vector(Vec3& value) {
    return keywords("X: ") && number(value.x, "a number after 'X:'") && keywords("Y: ") &&
           number(value.y, "a number after 'Y:'") && keywords("Z: ") && number(value.z, "a number after 'Z:'");
  }
  bool fail(const std::string& expected) {
    file_.warnExpected(cursor_, expected, std::string(kContext),
                       "the surface is undefined; --compat cpfg draws nothing for it");
    return false;
  }

  const DataFile& file_;
  TextCursor cursor_;
};

/// Warns when HEADING and UP span no plane, so that the surface has no area.
void checkFrame(const DataFile& file, const Placement& placement) {
  constexpr double kLeastSine = 1e-9;
  const Vec3 heading = core::normalised(placement.heading);
  const Vec3 left = core::cross(heading, core::normalised(placement.up));
  if (core::dot(left, left) < kLeastSine * kLeastSine) {
    file.warn(placement.headingRange,
              core::dot(heading, heading) > 0.0
                  ? "UP of the surface has the direction of HEADING, or is 0: it is a line"
                  : "HEADING of the surface is 0: it is a point",
              "write UP perpendicular to HEADING, as HEADING X: 0 Y: 1 Z: 0 and UP X: 0 Y: 0 Z: 1");
  }
}

/// Transforms points of a surface file to the turtle's local coordinates.
class LocalFrame {
 public:
  LocalFrame(const Placement& placement, double scale) : contact_(placement.contact), factor_(scale / placement.size) {
    heading_ = core::normalised(placement.heading);
    left_ = core::cross(heading_, core::normalised(placement.up));
    up_ = core::cross(left_, heading_);
  }
  /// Components along the turtle's L, H, U: the file's axes are sent to l, h, u'.
  [[nodiscard]] Vec3 operator()(const Vec3& point) const {
    const Vec3 d = (point - contact_) * factor_;
    return left_ * d.x + heading_ * d.y + up_ * d.z;
  }

 private:
  Vec3 contact_;
  double factor_;
  Vec3 heading_, left_, up_;
};

/// Whether every neighbour exists and names the patch back.
bool areNeighboursMutual(const DataFile& file, const std::vector<NamedPatch>& patches) {
  std::map<std::string_view, const NamedPatch*> byName;
  for (const NamedPatch& patch : patches) {
    byName.emplace(patch.name, &patch);
  }
  for (const NamedPatch& patch : patches) {
    for (std::size_t i = 0; i < patch.neighbours.size(); ++i) {
      if (patch.neighbours[i] == "~") {
        continue;
      }
      const auto neighbour = byName.find(patch.neighbours[i]);
      const std::string keyword(kNeighbourKeywords[i].substr(0, kNeighbourKeywords[i].size() - 1));
      const std::string place = "'" + keyword + "' of patch '" + std::string(patch.name) + "' names '" +
                                std::string(patch.neighbours[i]) + "'";
      if (neighbour == byName.end()) {
        file.warn(patch.range, place + ", which is not a patch of this surface",
                  "the surface is undefined; --compat cpfg draws nothing for it; write ~ for no neighbour");
        return false;
      }
      if (neighbour->second->neighbours[kOpposite[i]] != patch.name) {
        const std::string back(kNeighbourKeywords[kOpposite[i]].substr(0, kNeighbourKeywords[kOpposite[i]].size() - 1));
        file.warn(patch.range, place + ", whose '" + back + "' does not name it back",
                  "the surface is undefined; --compat cpfg draws nothing for it; neighbours must be mutual");
        return false;
      }
    }
  }
  return true;
}

}  // namespace

std::optional<Surface> readSurfaceFile(const DataFile& file, char id, double scale, int subdivisionS,
                                       int subdivisionT) {
  SurfaceReader reader(file);
  Placement placement;
  if (!reader.readHead(placement)) {
    return std::nullopt;
  }
  std::vector<NamedPatch> patches;
  while (!reader.atEnd()) {
    if (!reader.readPatch(patches.emplace_back())) {
      return std::nullopt;
    }
  }
  if (!areNeighboursMutual(file, patches)) {
    return std::nullopt;
  }
  checkFrame(file, placement);
  const LocalFrame local(placement, scale);
  Surface surface;
  surface.id = id;
  surface.file = file.name();
  surface.endPoint = local(placement.end);
  bool isPlaced = isFinite(surface.endPoint);
  for (NamedPatch& named : patches) {
    for (Vec3& point : named.patch.points) {
      point = local(point);
      isPlaced = isPlaced && isFinite(point);
    }
    surface.patches.push_back(named.patch);
  }
  if (!isPlaced) {
    file.warn({0, 1},
              "the size " + std::string(placement.size == 0.0 ? "0" : "or a point") +
                  " of the surface gives points that are not finite",
              "the surface is undefined; --compat cpfg draws nothing for it");
    return std::nullopt;
  }
  // the file has one precision for both directions
  const int fromFile = placement.precision;
  surface.subdivisionS = std::clamp(subdivisionS != 0 ? subdivisionS : fromFile, 1, kMostSubdivision);
  surface.subdivisionT = std::clamp(subdivisionT != 0 ? subdivisionT : fromFile, 1, kMostSubdivision);
  return surface;
}

}  // namespace espalier::files
