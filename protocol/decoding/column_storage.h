#pragma once

#include <array>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

#include "protocol/messages.h"

namespace espalier::protocol {

/// The numbers behind QueryColumns that were read.
struct QueryStorage {
  std::vector<std::uint32_t> plant, symbol, following;
  std::vector<std::uint64_t> module, offset{0}, followingOffset{0};
  std::vector<std::uint8_t> isTransient;
  std::vector<double> parameters, position, heading, left, up, width, scale, followingParameters;
};

/// The numbers behind ReplyColumns that were read.
struct ReplyStorage {
  std::vector<std::uint32_t> id;
  std::vector<std::uint64_t> offset{0};
  std::vector<double> values;
  std::vector<std::uint8_t> isSet;
};

/// Collects queries one by one, as text has them. A query that lacks a value of the others gets its default.
class QueryCollector {
 public:
  QueryCollector() : storage_(std::make_shared<QueryStorage>()) {}

  /// Begins the next query.
  void begin(std::uint32_t plant, std::uint64_t module, bool isTransient, std::string_view symbol);
  void parameter(double value) { storage_->parameters.push_back(value); }
  void endParameters() { storage_->offset.push_back(storage_->parameters.size()); }
  void position(const std::array<double, 3>& v) { addVector(storage_->position, v); }
  void heading(const std::array<double, 3>& v) { addVector(storage_->heading, v); }
  void left(const std::array<double, 3>& v) { addVector(storage_->left, v); }
  void up(const std::array<double, 3>& v) { addVector(storage_->up, v); }
  void width(double value) { addNumber(storage_->width, value); }
  void scale(double value) { addNumber(storage_->scale, value); }
  void following(std::string_view symbol);
  void followingParameter(double value) { storage_->followingParameters.push_back(value); }
  [[nodiscard]] std::size_t count() const { return storage_->plant.size(); }
  [[nodiscard]] QueryColumns take();

 private:
  void addVector(std::vector<double>& column, const std::array<double, 3>& v);
  void addNumber(std::vector<double>& column, double value);
  [[nodiscard]] std::uint32_t symbolOf(std::string_view name);

  std::shared_ptr<QueryStorage> storage_;
  std::vector<std::string> symbols_;
  std::map<std::string, std::uint32_t, std::less<>> symbolIds_;
  std::uint32_t lastSymbol_ = 0;
};

/// Adds a note of a reply. A list of 50 takes no more, and the end of a note of more than 1,000 bytes is cut off.
void addNote(std::string_view note, std::vector<std::string>& notes);

/// Collects replies one by one.
class ReplyCollector {
 public:
  ReplyCollector() : storage_(std::make_shared<ReplyStorage>()) {}

  void begin(std::uint32_t id) { storage_->id.push_back(id); }
  void value(double number);
  void keep();  // the next value stays as it was sent
  void end() { storage_->offset.push_back(storage_->values.size()); }
  [[nodiscard]] ReplyColumns take();

 private:
  std::shared_ptr<ReplyStorage> storage_;
};

}  // namespace espalier::protocol
