#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "protocol/errors.h"
#include "protocol/payload.h"
#include "protocol/roles.h"

namespace espalier::protocol {

/// The side that answers a method.
enum class Answerer : std::uint8_t { Both, Server, Environment, Nobody };

/// One row of methods.def.
struct Method {
  std::string_view name;
  std::string_view params;  // name of the struct; empty: a notification of the server
  Answerer answerer = Answerer::Nobody;
  Role role = Role::Anyone;  // that a connection to the server needs for it
  std::string_view summary;
  /// The decoder's error about params, or nothing. Null: a notification of the server.
  std::optional<Error> (*problemOf)(const Payload& params) = nullptr;
};

/// All methods and notifications, in the order of methods.def.
[[nodiscard]] std::span<const Method> methods();

}  // namespace espalier::protocol
