#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "protocol/json_tree.h"
#include "protocol/messages.h"

namespace espalier::protocol {

/// A text of 1 to 200 bytes.
[[nodiscard]] std::string readName(const Field& field);
[[nodiscard]] std::array<double, 3> readVector(const Field& field);

/// The `models` of a request or a forest file: a list of objects with a `name`, a `colour` and what `readModel` reads.
void readModels(const Field& params, const std::function<void(const Field& entry, ModelParams& model)>& readModel,
                std::vector<NamedModel>& models);
/// `plants`, which choose from `models` by name. Absent: none.
void readPlants(const Field& plants, const std::vector<NamedModel>& models, std::vector<PlantParams>& result);
/// `seeds`. Absent: the defaults.
void readSeeds(const Field& field, SeedParams& seeds);

}  // namespace espalier::protocol
