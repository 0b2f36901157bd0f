#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::protocol {

/// Appends one JSON value to a string, without a tree in between: bulk messages (100,000 queries) are written in one
/// pass. Numbers are the shortest decimal that reads back as the same double; -0 is written -0.0, because readers take
/// -0 for the integer 0. Text that is not UTF-8 gets U+FFFD for each bad byte. Commas are placed by the writer.
///
///     JsonWriter w;
///     w.beginObject().key("step").integer(3).key("radius").number(0.5).endObject();
class JsonWriter {
 public:
  JsonWriter& beginObject();
  JsonWriter& endObject();
  JsonWriter& beginArray();
  JsonWriter& endArray();
  /// `name` must be plain ASCII without quotes and backslashes.
  JsonWriter& key(std::string_view name);
  JsonWriter& text(std::string_view value);
  /// Throws NonFiniteNumber for NaN and infinities: they are not JSON.
  JsonWriter& number(double value);
  JsonWriter& integer(std::uint64_t value);
  JsonWriter& integer(std::int64_t value);
  JsonWriter& integer(std::uint32_t value) { return integer(std::uint64_t{value}); }
  JsonWriter& integer(std::int32_t value) { return integer(std::int64_t{value}); }
  JsonWriter& boolean(bool value);
  JsonWriter& null();
  /// Text that is JSON already.
  JsonWriter& raw(std::string_view json);

  JsonWriter& numbers(std::span<const double> values);
  JsonWriter& texts(const std::vector<std::string>& values);

  /// From now on numbers are rounded to single precision: fewer digits, the shortest that read back as the same float.
  void useSinglePrecision(bool isUsed) { isSinglePrecision_ = isUsed; }
  [[nodiscard]] const std::string& view() const { return text_; }
  [[nodiscard]] std::string take() { return std::move(text_); }
  void reserve(std::size_t bytes) { text_.reserve(bytes); }

 private:
  void separate();

  std::string text_;
  bool needsComma_ = false;
  bool isSinglePrecision_ = false;
};

/// A number that cannot be written. `what()` is the whole sentence.
class NonFiniteNumber : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override {
    return "a number is NaN or infinite, which JSON cannot carry";
  }
};

}  // namespace espalier::protocol
