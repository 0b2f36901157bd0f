#include "clients/espalier/validation/canopy_fluxes.h"

#include "clients/espalier/validation/process_run.h"
#include "environment/base/number_text.h"

namespace espalier::validation {

using core::Vec3;
using environment::numberText;

Light lightOf(const std::string& zenith) {
  return zenith == "uniform" ? Light{} : Light{std::stod(zenith)};
}

std::string listOf(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) {
    list += (list.empty() ? "" : ",") + numberText(number);
  }
  return "[" + list + "]";
}

std::vector<Fluxes> rayFluxes(const environment::Canopy& canopy, double side, const std::vector<Band>& bands,
                              const Light& light, int directions, int groundCells) {
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
  std::string text = R"({"sensor":"fluxes","remainder":1e-4,"ground":true,"plot":[0,)" + numberText(side) + ",0," +
                     numberText(side) + R"(],"directions":)" + std::to_string(directions) + R"(,"groundCells":)" +
                     std::to_string(groundCells) + R"(,"bands":)" + listOf(ones) + R"(,"reflectance":)" + listOf(rho) +
                     R"(,"transmittance":)" + listOf(tau) + R"(,"groundReflectance":)" + listOf(ground);
  if (light.zenith > 0.0) {
    const Vec3 sun = light.direction();
    text += R"(,"diffuseIrradiance":0,"sun":"direction","directIrradiance":)" + numberText(1.0 / sun.y) +
            R"(,"sunAzimuths":)" + std::to_string(light.azimuths) + R"(,"sunDirection":)" +
            listOf({sun.x, sun.y, sun.z}) + "}";
  } else {
    text += R"(,"sky":"uniform","diffuseIrradiance":1})";
  }
  // a sensor: a query before no organ
  turtle::QueryBatch queries = queriesAt({{}}, std::vector<double>(4 * bands.size(), 0.0));
  queries.module.front() = 2 * canopy.count() + 8;
  queries.geometry = canopy.geometry();
  const auto values = runProcess("light", text, queries).replies.values;
  std::vector<Fluxes> fluxes;
  for (std::size_t k = 0; k < values.size(); k += 4) {
    fluxes.push_back({values[k], values[k + 1], values[k + 2], values[k + 3]});
  }
  return fluxes;
}

Fluxes voxelFluxes(const std::array<int, 3>& cells, const std::vector<double>& densities, const std::string& leafAngles,
                   const Band& band, const Light& light) {
  std::string text =
      R"({"voxelSize":1,"position":[0,0,0],"periodic":true,"scattering":true,"sensor":"fluxes","gridSize":)" +
      listOf({static_cast<double>(cells[0]), static_cast<double>(cells[1]), static_cast<double>(cells[2])}) +
      R"(,"leafAngles":")" + leafAngles + R"(","reflectance":)" + numberText(band.rho) + R"(,"transmittance":)" +
      numberText(band.tau) + R"(,"groundReflectance":)" + numberText(band.ground) + R"(,"leafAreaDensity":)" +
      listOf(densities);
  if (light.zenith > 0.0) {
    const Vec3 sun = light.direction();
    text += R"(,"directions":[)" + listOf({sun.x, sun.y, sun.z, 1.0}) + "]}";
  } else {
    text += R"(,"sky":"uniform"})";
  }
  // a sensor: a query without leaves
  const auto values = runProcess("light-voxels", text, queriesAt({{}}, std::vector<double>(4, 0.0))).replies.values;
  return {values[0], values[1], values[2], values[3]};
}

}  // namespace espalier::validation
