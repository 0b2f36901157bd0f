#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "clients/espalier/evolution/fitness.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/scene/geometry.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// Names of the measures of a drawn plant. y is up, lengths are in the unit of the model.
///
/// height, lowest: of the highest and lowest point; extentX, extentY, extentZ: spans; spread: greatest distance from
/// the vertical through the origin; length, segments: of lines; woodArea, woodVolume: of lines as truncated cones
/// without their ends; organs, leafArea: number, and area of one side, of all other shapes; silhouetteTop,
/// silhouetteFront, silhouetteSide: area of the shade along y, z and x; sky, symmetry, stability, branching as in
/// evolution/fitness.h.
[[nodiscard]] const std::vector<std::string_view>& shapeMeasureNames();

/// Names of the quantities of a profile: length, woodArea, woodVolume, leafArea, organs.
[[nodiscard]] const std::vector<std::string_view>& profileNames();

/// The measures of one drawing. Each is computed when it is asked for.
class ShapeMeasures {
 public:
  ShapeMeasures(turtle::Scene&& scene, const files::ViewSettings& view);

  /// The measure of that place in shapeMeasureNames(). Not a number: the measure has no value, as the volume of lines
  /// that are some pixels wide.
  [[nodiscard]] double value(std::size_t name);
  /// The quantity of that place in profileNames() in `bins` equal bins from 0 to `to`, by height or by the distance
  /// from the vertical axis. Lines count in 16 equal pieces, other shapes by triangles, each at its centre; organs by
  /// their first vertex.
  [[nodiscard]] std::vector<double> profile(std::size_t name, bool isAlongRadius, std::uint64_t bins, double to) const;

 private:
  const PlantMeasures& fitness();

  std::optional<turtle::Scene> scene_;  // for fitness(), until it is computed
  const files::ViewSettings& view_;
  turtle::Geometry geometry_;
  std::optional<PlantMeasures> fitness_;
};

}  // namespace espalier::command
