#include "clients/espalier/validation/canopy_fluxes.h"

#include "clients/espalier/validation/process_run.h"
#include "environment/base/number_text.h"

namespace espalier::validation {

using core::Vec3;
using environment::numberText;

Light lightOf(const std::string& zenith) {
  Light light;
  if (zenith == "uniform" || zenith == "overcast") {
    light.sky = zenith;
  } else {
    light.zenith = std::stod(zenith);
  }
  return light;
}

std::string listOf(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) {
    list += (list.empty() ? "" : ",") + numberText(number);
  }
  return "[" + list + "]";
}

namespace {

/// The keys of bands, with a comma at the end.
std::string bandKeys(const std::vector<Band>& bands) {
  std::vector<double> ones;
  std::vector<double> rho;
  std::vector<double> tau;
  std::vector<double> ground;
  for (const Band& band : bands) {
    ones.push_back(1.0);
    rho.push_back(band.rho);
    tau.push_back(band.tau);
    ground.push_back(band.ground);
  }
  return R"("bands":)" + listOf(ones) + R"(,"reflectance":)" + listOf(rho) + R"(,"transmittance":)" + listOf(tau) +
         R"(,"groundReflectance":)" + listOf(ground) + ",";
}

/// The keys of a light that gives a horizontal plane 1.
std::string sunKeys(const Light& light) {
  const Vec3 sun = light.direction();
  return R"("diffuseIrradiance":0,"sun":"direction","directIrradiance":)" + numberText(1.0 / sun.y) +
         R"(,"sunAzimuths":)" + std::to_string(light.azimuths) + R"(,"sunDirection":)" + listOf({sun.x, sun.y, sun.z});
}

std::string voxelKeys(const Voxels& voxels) {
  const auto& [x, y, z] = voxels.cells;
  return R"({"position":[0,0,0],"periodic":true,"voxelSize":)" + numberText(voxels.side) + R"(,"gridSize":)" +
         listOf({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}) + R"(,"leafAngles":")" +
         voxels.leafAngles + R"(","leafAreaDensity":)" + listOf(voxels.densities) + ",";
}

/// Answers of a sensor of so many fluxes for each band.
std::vector<Fluxes> fluxesIn(const std::vector<double>& values, std::size_t width) {
  std::vector<Fluxes> fluxes;
  for (std::size_t k = 0; k < values.size(); k += width) {
    fluxes.push_back({values[k], values[k + 1], values[k + 2], values[k + 3]});
  }
  return fluxes;
}

}  // namespace

std::vector<Fluxes> rayFluxes(const environment::Canopy& canopy, double side, const std::vector<Band>& bands,
                              const Light& light, int directions, int groundCells, int threads) {
  const std::string text =
      R"({"sensor":"fluxes","remainder":1e-4,"threads":)" + std::to_string(threads) + R"(,"ground":true,"plot":[0,)" +
      numberText(side) + ",0," + numberText(side) + R"(],"directions":)" + std::to_string(directions) +
      R"(,"groundCells":)" + std::to_string(groundCells) + "," + bandKeys(bands) +
      (light.zenith >= 0.0 ? sunKeys(light) : R"("diffuseIrradiance":1,"sky":")" + light.sky + "\"") + "}";
  // a sensor: a query before no organ
  turtle::QueryBatch queries = queriesAt({{}}, std::vector<double>(4 * bands.size(), 0.0));
  queries.module.front() = 2 * canopy.count() + 8;
  queries.geometry = canopy.geometry();
  return fluxesIn(runProcess("light", text, queries).replies.values, 4);
}

std::vector<Fluxes> voxelFluxes(const Voxels& voxels, const std::vector<Band>& bands, const Light& light) {
  const std::string text = voxelKeys(voxels) + R"("scattering":true,"sensor":"fluxes",)" + bandKeys(bands) +
                           (light.zenith >= 0.0 ? sunKeys(light) : R"("sky":")" + light.sky + "\"") + "}";
  // a sensor: a query without leaves
  return fluxesIn(
      runProcess("light-voxels", text, queriesAt({{}}, std::vector<double>(5 * bands.size(), 0.0))).replies.values, 5);
}

double passedVoxels(const Voxels& voxels, const Light& light) {
  // sensors on the ground, not in step with the voxels
  constexpr int kSensors = 251;  // along each side
  const double width = voxels.cells[0] * voxels.side;
  const double depth = voxels.cells[2] * voxels.side;
  std::vector<Vec3> places;
  for (int i = 0; i < kSensors; ++i) {
    for (int k = 0; k < kSensors; ++k) {
      places.push_back({width * (i + 0.5) / kSensors, 0.0, depth * (k + 0.5) / kSensors});
    }
  }
  const std::string text = voxelKeys(voxels) +
                           (light.zenith >= 0.0 ? R"("zenithAngles":1,"azimuthAngles":1,)" + sunKeys(light)
                                                : R"("zenithAngles":8,"azimuthAngles":12,"sky":")" + light.sky + "\"") +
                           "}";
  double sum = 0.0;
  for (const double passed : runProcess("light-voxels", text, queriesAt(places, {0.0})).replies.values) {
    sum += passed;
  }
  return sum / static_cast<double>(places.size());
}

}  // namespace espalier::validation
