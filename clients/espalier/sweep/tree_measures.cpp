#include "clients/espalier/sweep/tree_measures.h"

#include <algorithm>
#include <limits>

#include "engine/turtle/export/text/mtg.h"

namespace espalier::command {
namespace {

enum Name : std::size_t { Vertices, Axes, Tips, VerticesPerAxis, MaximumOrder, Depth, Strahler };

}  // namespace

const std::vector<std::string_view>& treeMeasureNames() {
  static const std::vector<std::string_view> kNames{"vertices",     "axes",  "tips",    "verticesPerAxis",
                                                    "maximumOrder", "depth", "strahler"};
  return kNames;
}

TreeMeasures::TreeMeasures(const language::Program& program, const derivation::ModuleString& string,
                           const std::vector<bool>& isVertex) {
  std::vector<bool> counts = isVertex;
  if (counts.empty()) {
    for (std::size_t type = 0; type < program.moduleTypeCount(); ++type) {
      counts.push_back(turtle::isLetter(program.nameOf(static_cast<core::ModuleTypeId>(type)).front()));
    }
  }
  struct Place {
    std::uint32_t last = kNone;  // the last vertex of the branch, or the one that bears it
    bool isBranch = false;       // no vertex yet since the bracket
  };
  Place place;
  std::vector<Place> stack;
  for (const core::ModuleTypeId type : string.types()) {
    if (type == program.openBranch) {
      stack.push_back(place);
      place.isBranch = true;
    } else if (type == program.closeBranch) {
      if (!stack.empty()) {
        place = stack.back();
        stack.pop_back();
      }
    } else if (counts[type]) {
      Vertex vertex{.parent = place.last, .order = 0};
      if (place.last != kNone) {
        Vertex& parent = vertices_[place.last];
        vertex.startsAxis = place.isBranch;
        vertex.order = parent.order + (place.isBranch ? 1 : 0);
        vertex.depth = parent.depth + 1;
        parent.isTip = false;
      }
      place = {.last = static_cast<std::uint32_t>(vertices_.size()), .isBranch = false};
      vertices_.push_back(vertex);
    }
  }
  // children stand behind their parents
  for (std::size_t i = vertices_.size(); i-- > 0;) {
    if (vertices_[i].parent == kNone) {
      continue;
    }
    Vertex& parent = vertices_[vertices_[i].parent];
    if (vertices_[i].strahler > parent.strongest) {
      parent.strongest = vertices_[i].strahler;
      parent.strahler = std::max(parent.strahler, parent.strongest);
    } else if (vertices_[i].strahler == parent.strongest) {
      parent.strahler = parent.strongest + 1;
    }
  }
}

double TreeMeasures::value(std::size_t name, std::optional<std::uint64_t> order) const {
  double vertices = 0.0;
  double axes = 0.0;
  double tips = 0.0;
  double highestOrder = 0.0;
  double depth = 0.0;
  double strahler = 0.0;
  for (const Vertex& vertex : vertices_) {
    if (order && vertex.order != *order) {
      continue;
    }
    vertices += 1.0;
    axes += vertex.startsAxis ? 1.0 : 0.0;
    tips += vertex.isTip ? 1.0 : 0.0;
    highestOrder = std::max(highestOrder, static_cast<double>(vertex.order));
    depth = std::max(depth, static_cast<double>(vertex.depth));
    strahler = std::max(strahler, static_cast<double>(vertex.strahler));
  }
  const double none = std::numeric_limits<double>::quiet_NaN();
  switch (name) {
    case Vertices:
      return vertices;
    case Axes:
      return axes;
    case Tips:
      return tips;
    case VerticesPerAxis:
      return axes > 0.0 ? vertices / axes : none;
    case MaximumOrder:
      return vertices > 0.0 ? highestOrder : none;
    case Depth:
      return depth;
    default:
      return strahler;
  }
}

}  // namespace espalier::command
