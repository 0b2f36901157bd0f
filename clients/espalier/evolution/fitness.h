#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// What is measured of a grown plant whose base is at the origin, y up. Lengths in the model's unit.
struct PlantMeasures {
  double height = 0.0;    // of its highest point above the base
  double light = 0.0;     // the ground it shades from light straight above (unit²); what is thinner than 1/512 of the
                          // plant's extent counts as so wide
  double sky = 0.0;       // the same from the whole sky: mean of the areas that it covers seen from straight above and,
                          // 45 degrees high, from +x, -x, +z and -z (unit²)
  double symmetry = 0.0;  // bilateral, about the plane x = 0: 0 nothing has its mirror image, 1 everything
  double stability = 0.0;  // 1: the centre of its lines is above the base, 0: half its height or more beside it
  double branching = 0.0;  // share of the lines that others grow from, that more than one grows from
  double length = 0.0;     // of all lines
  double extent = 0.0;     // the greatest of its spans along x, y and z, the base included
  double organs = 0.0;     // number of leaves, flowers and other organs
};

/// Names as the command line has them, in the order of the fields.
inline constexpr std::array<std::string_view, 9> kMeasureNames{"height",    "light",  "sky",    "symmetry", "stability",
                                                               "branching", "length", "extent", "organs"};

/// What plants are bred for when nothing is said: symmetry² · (sky / extent²) · (height / extent) · √(extent / length).
/// Bilateral symmetry is preferred, as in plants bred by Ochoa 1998; light caught and height are those of a plant of
/// extent 1, so that to be larger is no merit, and lines have their price.
inline constexpr std::string_view kUsualFitness = "symmetry=2,sky=1,height=1,extent=-2.5,length=-0.5,branching=0.5";

/// The measure of that index.
[[nodiscard]] double measure(const PlantMeasures& measures, std::size_t index);

/// Measures a scene of one plant. After Ochoa 1998 ("On genetic algorithms and Lindenmayer systems"), whose measures
/// are of plane figures on a screen; these are of plants in space. O(segments log segments + triangles).
[[nodiscard]] PlantMeasures measurePlant(turtle::Scene&& scene, const files::ViewSettings& view);

/// A product of measures, each to a power: by this the units do not matter.
struct FitnessFormula {
  std::vector<std::pair<std::size_t, double>> factors;  // index of the measure, exponent

  /// Reads "light", "symmetry=2,light" (symmetry² · light) and the like; an error sentence otherwise.
  [[nodiscard]] static std::optional<std::string> read(std::string_view text, FitnessFormula& formula);
  /// 0 for what is not a finite number.
  [[nodiscard]] double operator()(const PlantMeasures& measures) const;
};

}  // namespace espalier::command
