#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/files/colour_files.h"
#include "engine/language/program.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// The models of a simulation, in their order.
using Programs = std::vector<std::shared_ptr<const language::Program>>;

/// The model and the place of a plant.
struct PlantOrigin {
  std::uint32_t model = 0;  // index into the simulation's Programs
  turtle::PlantPlacement placement;
  std::string name{};            // for people; empty: none
  std::int32_t colourShift = 0;  // added to the colours that the plant is drawn in
};

/// Colour blocks (files::Palette) that each Program of a simulation has for itself when there is a palette: the
/// colours of Program m are drawn kBlocksPerModel * m blocks further on.
inline constexpr int kBlocksPerModel = 16;

/// The colours of all Programs in one palette, each in its own blocks. `palettes` are those of the model folders, one a
/// Program. A model without colours gets the default colours when another model has colours; empty: none has.
[[nodiscard]] files::Palette joinedPalettes(const Programs& programs, std::span<const files::Palette> palettes);

inline constexpr std::uint64_t kStillAlive = std::numeric_limits<std::uint64_t>::max();

/// A plant of a simulation, living or dead. Its number is its place in the simulation's list; no other plant ever has
/// that number.
struct Plant {
  PlantOrigin origin;
  std::uint64_t birthStep = 0;            // completed steps when it began as its axiom
  std::uint64_t deathStep = kStillAlive;  // completed steps when it was gone

  [[nodiscard]] bool isAlive() const { return deathStep == kStillAlive; }
};

/// Where the seeds of a simulation take root.
struct SeedRules {
  std::uint64_t maximumPlants = 10'000;  // that live at once; further seeds are lost
  double spacing = 0.0;  // a seed nearer than this to a living plant or to a seed that took root before it is lost
  double ground = 0.0;   // height along the world's up at which seeds come to lie
  /// Two corners of the box outside which seeds are lost; the axes along which the world's up points do not count.
  std::optional<std::array<core::Vec3, 2>> area{};

  bool operator==(const SeedRules&) const = default;
};

}  // namespace espalier::simulation
