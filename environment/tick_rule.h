#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "engine/turtle/environment_process.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

inline constexpr std::array<std::string_view, 2> kTickRules{"always", "queries"};
/// A key of every process.
inline constexpr ConfigurationKey kTickKey{.name = "tick",
                                           .kind = KeyKind::Choice,
                                           .description =
                                               "steps in which time passes: all, or only those with queries, "
                                               "as in the published programs",
                                           .defaultText = "always",
                                           .choices = kTickRules};

/// The process, whose time stands still in steps without queries.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> tickingWithQueries(
    std::unique_ptr<turtle::EnvironmentProcess> process);

}  // namespace espalier::environment
