#include <algorithm>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/turtle_motion.h"
#include "server/remote/translation/translate.h"

namespace espalier::server {
namespace {

// the turtle's frame turned by the shortest way to the heading, then about it
core::Frame frameOf(const protocol::PlantParams& plant) {
  core::Frame frame;
  if (plant.heading) {
    const core::Vec3 heading = normalised(toVec3(*plant.heading));
    const core::Vec3 axis = cross(frame.heading, heading);
    const double sine = length(axis);
    const double radians = core::atan2(sine, dot(frame.heading, heading));
    // straight down: about the left side
    const core::Vec3 about = sine > 0.0 ? axis * (1.0 / sine) : frame.left;
    frame.left = turtle::rotatedAbout(frame.left, about, radians);
    frame.up = turtle::rotatedAbout(frame.up, about, radians);
    frame.heading = heading;
  }
  if (plant.turnDegrees != 0.0) {
    const double radians = plant.turnDegrees * std::numbers::pi / 180.0;
    frame.left = turtle::rotatedAbout(frame.left, frame.heading, radians);
    frame.up = turtle::rotatedAbout(frame.up, frame.heading, radians);
  }
  return frame;
}

}  // namespace

std::vector<simulation::PlantOrigin> plantOrigins(const std::vector<protocol::NamedModel>& models,
                                                  const std::vector<protocol::PlantParams>& plants) {
  std::vector<simulation::PlantOrigin> origins;
  for (const protocol::PlantParams& plant : plants) {
    simulation::PlantOrigin& origin = origins.emplace_back();
    const auto named = [&plant](const protocol::NamedModel& model) { return model.name == plant.model; };
    const auto model = plant.model.empty() ? models.begin() : std::find_if(models.begin(), models.end(), named);
    origin.model = model == models.end() ? 0 : static_cast<std::uint32_t>(model - models.begin());
    origin.placement = {toVec3(plant.position), frameOf(plant)};
    origin.name = plant.name;
    origin.colourShift = static_cast<std::int32_t>(plant.colour + (model == models.end() ? 0 : model->colour));
  }
  return origins;
}

simulation::SeedRules seedRules(const protocol::SeedParams& seeds) {
  simulation::SeedRules rules;
  rules.maximumPlants = seeds.maximumPlants.value_or(rules.maximumPlants);
  rules.spacing = seeds.spacing;
  rules.ground = seeds.ground;
  if (seeds.area) {
    rules.area = std::array{toVec3((*seeds.area)[0]), toVec3((*seeds.area)[1])};
  }
  return rules;
}

}  // namespace espalier::server
