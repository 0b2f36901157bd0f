#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/errors.h"
#include "protocol/version.h"

namespace espalier::protocol {

/// Thrown by a decoder about a wrong member. decodePayload catches it; it never leaves protocol/.
struct MemberFailure {
  Error error;
};

/// The names that a decoder asked of each object of a message, to find members that it does not know.
struct AskedMembers {
  std::map<const nlohmann::json*, std::set<std::string, std::less<>>> names;
  std::set<const nlohmann::json*> wholes;  // values that were taken as they are, with any members

  /// A sentence about each member of `value` that was not asked for, with the nearest name that was.
  void listUnknown(const nlohmann::json& value, const std::string& path, std::vector<std::string>& unknown) const;
};

/// A value of a message with its place, while the message is decoded. It lives on the decoder's stack, and a child
/// refers to its parent. The path is made only for errors, because bulk messages have millions of members.
class Member {
 public:
  Member(const nlohmann::json* value, std::string_view name, AskedMembers* asked = nullptr)
      : value_(value), asked_(asked), name_(name) {}
  Member(const nlohmann::json* value, const Member& parent, std::string_view name)
      : value_(value), parent_(&parent), asked_(parent.asked_), name_(name) {}
  Member(const nlohmann::json* value, const Member& parent, std::size_t index)
      : value_(value), parent_(&parent), asked_(parent.asked_), index_(index), isElement_(true) {}

  /// `params.environment[0].radius`
  [[nodiscard]] std::string path() const;
  /// Absent, or null: an optional member that was not given.
  [[nodiscard]] bool isAbsent() const { return value_ == nullptr || value_->is_null(); }
  [[nodiscard]] bool isNull() const { return value_ != nullptr && value_->is_null(); }
  [[nodiscard]] bool isObject() const { return value_ != nullptr && value_->is_object(); }
  [[nodiscard]] bool isArray() const { return value_ != nullptr && value_->is_array(); }
  [[nodiscard]] bool isText() const { return value_ != nullptr && value_->is_string(); }
  /// The value, for a reader that takes any members.
  [[nodiscard]] const nlohmann::json& json() const {
    takeWhole();
    return *value_;
  }
  /// All members of this value are known to somebody else.
  void takeWhole() const {
    if (asked_ != nullptr && value_ != nullptr) {
      asked_->wholes.insert(value_);
    }
  }

  /// The member of that name, or an absent one. This must be an object (`requireObject`).
  [[nodiscard]] Member operator[](std::string_view name) const;
  [[nodiscard]] Member element(std::size_t index) const { return {&(*value_)[index], *this, index}; }
  /// Number of elements; fails unless this is an array.
  [[nodiscard]] std::size_t arraySize() const;

  void requireObject() const;
  [[nodiscard]] const std::string& text() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::int64_t integer(std::int64_t least, std::int64_t most) const;
  [[nodiscard]] std::uint64_t count() const { return static_cast<std::uint64_t>(integer(0, kMaximumExactInteger)); }
  /// A whole number of 64 bits. Only seeds are so large: no program computes with them.
  [[nodiscard]] std::uint64_t wide() const;
  /// Compact JSON of the value.
  [[nodiscard]] std::string dump() const;

  /// Its text; empty when it is absent.
  [[nodiscard]] std::string textOrEmpty() const { return isAbsent() ? std::string() : text(); }

  [[noreturn]] void fail(const std::string& what) const;
  /// "expected WHAT, found 'x'".
  [[noreturn]] void failExpected(std::string_view what) const;

 private:
  const nlohmann::json* value_;
  const Member* parent_ = nullptr;
  AskedMembers* asked_ = nullptr;
  std::string_view name_;
  std::size_t index_ = 0;
  bool isElement_ = false;
};

/// The member `bounds` of `object`, which may be absent: two corners of three numbers, no coordinate of the first
/// beyond that of the second.
[[nodiscard]] inline std::optional<std::array<std::array<double, 3>, 2>> readBounds(const Member& object) {
  const Member bounds = object["bounds"];
  if (bounds.isAbsent()) {
    return std::nullopt;
  }
  if (bounds.arraySize() != 2 || bounds.element(0).arraySize() != 3 || bounds.element(1).arraySize() != 3) {
    bounds.failExpected("two corners of three numbers");
  }
  std::array<std::array<double, 3>, 2> box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box[0][axis] = bounds.element(0).element(axis).number();
    box[1][axis] = bounds.element(1).element(axis).number();
    if (box[0][axis] > box[1][axis]) {
      bounds.fail("the first corner has the smaller coordinates");
    }
  }
  return box;
}

}  // namespace espalier::protocol
