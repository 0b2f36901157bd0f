#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/files/view_settings.h"
#include "engine/turtle/scene/geometry.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// Measures of a grown plant. Its base is at the origin, y is up. Lengths are in the unit of the model.
struct PlantMeasures {
  double height = 0.0;     // of its highest point above the base
  double light = 0.0;      // the ground shaded from light straight above (unit²); parts thinner than 1/512 of the
                           // extent count as 1/512 wide
  double sky = 0.0;        // the same from the whole sky: mean of the covered areas, seen from straight above and
                           // from +x, -x, +z and -z at 45 degrees (unit²)
  double symmetry = 0.0;   // bilateral, about the plane x = 0: 0 nothing has its mirror image, 1 everything
  double stability = 0.0;  // 1: the centre of its lines is above the base, 0: half its height or more beside it
  double branching = 0.0;  // of the lines with successors, the share with more than one successor
  double length = 0.0;     // of all lines
  double extent = 0.0;     // the greatest of its spans along x, y and z, the base included
  double organs = 0.0;     // number of leaves, flowers and other organs
};

/// Names on the command line, in the order of the members.
inline constexpr std::array<std::string_view, 9> kMeasureNames{"height",    "light",  "sky",    "symmetry", "stability",
                                                               "branching", "length", "extent", "organs"};

/// The default fitness: symmetry² · (sky / extent²) · (height / extent) · √(extent / length) · √branching. It prefers
/// bilateral symmetry, as Ochoa 1998 does. Light and height are scaled to a plant of extent 1, so that size is no
/// advantage, and every line has a cost.
inline constexpr std::string_view kUsualFitness = "symmetry=2,sky=1,height=1,extent=-2.5,length=-0.5,branching=0.5";

/// The measure with the index.
[[nodiscard]] double measure(const PlantMeasures& measures, std::size_t index);

/// Measures a scene of one plant. After Ochoa 1998 ("On genetic algorithms and Lindenmayer systems"), whose measures
/// are those of plane figures on a screen; ours are those of plants in space. O(segments log segments + triangles).
[[nodiscard]] PlantMeasures measurePlant(turtle::Scene&& scene, const files::ViewSettings& view);

/// The area of the shade on the ground of light from straight above. PlantMeasures::light is the same without the parts
/// of thick lines beyond the extent of their ends.
[[nodiscard]] double silhouetteArea(const turtle::Geometry& geometry);

/// A product of powers of measures. The choice of units does not change the order of plants.
struct FitnessFormula {
  std::vector<std::pair<std::size_t, double>> factors;  // index of the measure, exponent

  /// Reads a text such as "light" or "symmetry=2,light" (symmetry² · light). Returns an error sentence for any other
  /// text.
  [[nodiscard]] static std::optional<std::string> read(std::string_view text, FitnessFormula& formula);
  /// The fitness; 0 when it is not a finite number.
  [[nodiscard]] double operator()(const PlantMeasures& measures) const;
};

}  // namespace espalier::command
