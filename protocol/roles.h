#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::protocol {

/// Rights of a connection. A controller may do everything. A viewer reads and watches. An environment offers itself.
enum class Role : std::uint8_t { Anyone, Viewer, Environment, Controller };

/// The word of hello: viewer, environment or controller.
[[nodiscard]] std::string_view nameOf(Role role);
[[nodiscard]] std::optional<Role> roleOf(std::string_view name);

/// A set of roles.
class Roles {
 public:
  Roles() = default;
  Roles(std::initializer_list<Role> roles) {
    for (const Role role : roles) {
      add(role);
    }
  }
  void add(Role role) { bits_ |= bitOf(role); }
  [[nodiscard]] bool isEmpty() const { return bits_ == 0; }
  /// Whether it has the role, or is a controller.
  [[nodiscard]] bool allows(Role role) const {
    return role == Role::Anyone || (bits_ & (bitOf(role) | bitOf(Role::Controller))) != 0;
  }
  /// Those of the names that it allows; all of it when there are no names. Unknown names are left out.
  [[nodiscard]] Roles granted(const std::vector<std::string>& names) const;
  /// In the order viewer, environment, controller.
  [[nodiscard]] std::vector<std::string> names() const;
  /// `viewer, environment`, for people.
  [[nodiscard]] std::string text() const;
  bool operator==(const Roles&) const = default;

 private:
  [[nodiscard]] static unsigned bitOf(Role role) { return 1U << static_cast<unsigned>(role); }

  unsigned bits_ = 0;
};

}  // namespace espalier::protocol
