#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/decoding/member.h"
#include "protocol/messages.h"

namespace espalier::protocol {

/// A text of 1 to 200 bytes.
[[nodiscard]] std::string readName(const Member& member);
[[nodiscard]] std::array<double, 3> readVector(const Member& member);

/// The `models` of a request or a forest file: a list of objects with `name`, `colour` and the members that
/// `readModel` reads.
void readModels(const Member& params, const std::function<void(const Member& entry, ModelParams& model)>& readModel,
                std::vector<NamedModel>& models);
/// `plants`, which choose from `models` by name. Absent: none.
void readPlants(const Member& plants, const std::vector<NamedModel>& models, std::vector<PlantParams>& result);
/// A member that a person writes has only these members.
void requireKnown(const Member& object, std::span<const std::string_view> known);

/// A world, which is there.
[[nodiscard]] WorldRecord readWorld(const Member& member);
/// The same for a simulation, a forest or a file: unknown members and units are errors.
[[nodiscard]] WorldRecord readOwnWorld(const Member& member);

/// `seeds`. Absent: the defaults.
void readSeeds(const Member& member, SeedParams& seeds);

}  // namespace espalier::protocol
