#include "protocol/decoding/member.h"

#include <algorithm>
#include <cmath>

#include "protocol/decoding/near_name.h"

namespace espalier::protocol {
namespace {

/// A value as an error message shows it: short, on one line.
std::string shown(const nlohmann::json* value) {
  if (value == nullptr) {
    return "nothing";
  }
  if (value->is_object()) {
    return "an object";
  }
  if (value->is_array()) {
    return "an array";
  }
  constexpr std::size_t kLongest = 60;
  std::string text = value->dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  if (text.size() > kLongest) {
    text.resize(kLongest);
    text += "...";
  }
  return text;
}

}  // namespace

void AskedMembers::listUnknown(const nlohmann::json& value, const std::string& path,
                               std::vector<std::string>& unknown) const {
  if (wholes.contains(&value)) {
    return;
  }
  if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      listUnknown(value[i], path + "[" + std::to_string(i) + "]", unknown);
    }
    return;
  }
  const auto known = names.find(&value);
  if (!value.is_object() || known == names.end()) {
    return;
  }
  for (const auto& [name, member] : value.items()) {
    if (known->second.contains(name)) {
      listUnknown(member, path + "." + name, unknown);
      continue;
    }
    std::string list;
    for (const std::string& other : known->second) {
      list += (list.empty() ? "" : ", ") + other;
    }
    const std::vector<std::string_view> candidates(known->second.begin(), known->second.end());
    const std::string_view nearest = nearName(name, candidates);
    unknown.push_back(path + "." + name + ": there is no such member. " +
                      (nearest.empty() ? "Known: " + list + "." : "Did you mean '" + std::string(nearest) + "'?"));
  }
}

std::string Member::path() const {
  std::string text = parent_ == nullptr ? std::string() : parent_->path();
  if (isElement_) {
    return text + "[" + std::to_string(index_) + "]";
  }
  return text.empty() ? std::string(name_) : text + "." + std::string(name_);
}

void Member::fail(const std::string& what) const {
  throw MemberFailure{memberError(path(), what)};
}

void Member::failExpected(std::string_view what) const {
  fail("expected " + std::string(what) + ", found " + shown(value_));
}

void Member::requireObject() const {
  if (!isObject()) {
    failExpected("an object");
  }
}

Member Member::operator[](std::string_view name) const {
  if (asked_ != nullptr) {
    asked_->names[value_].emplace(name);
  }
  const auto found = value_->find(name);
  return {found == value_->end() ? nullptr : &*found, *this, name};
}

std::size_t Member::arraySize() const {
  if (!isArray()) {
    failExpected("an array");
  }
  return value_->size();
}

const std::string& Member::text() const {
  if (!isText()) {
    failExpected("a text");
  }
  return value_->get_ref<const std::string&>();
}

double Member::number() const {
  if (value_ == nullptr || !value_->is_number()) {
    failExpected("a number");
  }
  const auto number = value_->get<double>();
  if (!std::isfinite(number)) {
    failExpected("a finite number");
  }
  return number;
}

bool Member::boolean() const {
  if (value_ == nullptr || !value_->is_boolean()) {
    failExpected("true or false");
  }
  return value_->get<bool>();
}

std::int64_t Member::integer(std::int64_t least, std::int64_t most) const {
  const auto failRange = [&] {
    failExpected("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  };
  if (value_ == nullptr || !value_->is_number()) {
    failRange();
  }
  std::int64_t number = 0;
  if (value_->is_number_float()) {
    // some languages have only doubles and write 3.0
    const auto real = value_->get<double>();
    if (!(std::fabs(real) <= static_cast<double>(kMaximumExactInteger)) || real != std::floor(real)) {
      failRange();
    }
    number = static_cast<std::int64_t>(real);
  } else if (value_->is_number_unsigned() && value_->get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX)) {
    failRange();
  } else {
    number = value_->get<std::int64_t>();
  }
  if (number < least || number > most) {
    failRange();
  }
  return number;
}

std::uint64_t Member::wide() const {
  if (value_ == nullptr || !value_->is_number_unsigned()) {
    failExpected("a whole number from 0 to 18446744073709551615");
  }
  return value_->get<std::uint64_t>();
}

std::string Member::dump() const {
  takeWhole();
  return value_->dump();
}

}  // namespace espalier::protocol
