#include "protocol/roles.h"

#include <array>

namespace espalier::protocol {
namespace {

constexpr std::array kNamedRoles{Role::Viewer, Role::Environment, Role::Controller};

}  // namespace

std::string_view nameOf(Role role) {
  switch (role) {
    case Role::Viewer:
      return "viewer";
    case Role::Environment:
      return "environment";
    case Role::Controller:
      return "controller";
    case Role::Anyone:
      break;
  }
  return "anyone";
}

std::optional<Role> roleOf(std::string_view name) {
  for (const Role role : kNamedRoles) {
    if (nameOf(role) == name) {
      return role;
    }
  }
  return std::nullopt;
}

Roles Roles::granted(const std::vector<std::string>& names) const {
  if (names.empty()) {
    return *this;
  }
  Roles result;
  for (const std::string& name : names) {
    if (const auto role = roleOf(name); role && allows(*role)) {
      result.add(*role);
    }
  }
  return result;
}

std::vector<std::string> Roles::names() const {
  std::vector<std::string> result;
  for (const Role role : kNamedRoles) {
    if ((bits_ & bitOf(role)) != 0) {
      result.emplace_back(nameOf(role));
    }
  }
  return result;
}

std::string Roles::text() const {
  std::string result;
  for (const std::string& name : names()) {
    result += (result.empty() ? "" : ", ") + name;
  }
  return result;
}

}  // namespace espalier::protocol
