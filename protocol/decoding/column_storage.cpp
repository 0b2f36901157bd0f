#include "protocol/decoding/column_storage.h"

#include "protocol/json_text.h"

namespace espalier::protocol {
namespace {

// the value of a member that is left out
constexpr std::array<double, 3> kNoVector{0.0, 0.0, 0.0};
constexpr double kUnit = 1.0;

void fillVectors(std::vector<double>& column, std::size_t count) {
  while (column.size() < 3 * count) {
    column.insert(column.end(), kNoVector.begin(), kNoVector.end());
  }
}

}  // namespace

void QueryCollector::begin(std::uint32_t plant, std::uint64_t module, bool isTransient, std::string_view symbol) {
  QueryStorage& s = *storage_;
  // the columns of following modules are complete up to the query before
  if (!s.following.empty()) {
    s.following.resize(s.plant.size(), QueryColumns::kNoSymbol);
    s.followingOffset.resize(s.plant.size() + 1, s.followingParameters.size());
  }
  if (isTransient) {
    s.isTransient.resize(s.plant.size(), 0);
    s.isTransient.push_back(1);
  }
  s.plant.push_back(plant);
  s.module.push_back(module);
  s.symbol.push_back(symbolOf(symbol));
}

void QueryCollector::addVector(std::vector<double>& column, const std::array<double, 3>& v) {
  const std::size_t before = storage_->plant.size() - 1;
  if (column.size() < 3 * before) {
    fillVectors(column, before);
  }
  column.insert(column.end(), v.begin(), v.end());
}

void QueryCollector::addNumber(std::vector<double>& column, double value) {
  column.resize(storage_->plant.size() - 1, kUnit);
  column.push_back(value);
}

void QueryCollector::following(std::string_view symbol) {
  QueryStorage& s = *storage_;
  const std::size_t before = s.plant.size() - 1;
  s.following.resize(before, QueryColumns::kNoSymbol);
  s.followingOffset.resize(before + 1, s.followingParameters.size());
  s.following.push_back(symbolOf(symbol));
}

std::uint32_t QueryCollector::symbolOf(std::string_view name) {
  // queries of one symbol mostly come together
  if (lastSymbol_ < symbols_.size() && symbols_[lastSymbol_] == name) {
    return lastSymbol_;
  }
  const auto found = symbolIds_.find(name);
  if (found != symbolIds_.end()) {
    lastSymbol_ = found->second;
  } else {
    lastSymbol_ = static_cast<std::uint32_t>(symbols_.size());
    symbolIds_.emplace(name, lastSymbol_);
    symbols_.emplace_back(name);
  }
  return lastSymbol_;
}

QueryColumns QueryCollector::take() {
  QueryStorage& s = *storage_;
  QueryColumns columns;
  columns.count = s.plant.size();
  for (auto* column : {&s.position, &s.heading, &s.left, &s.up}) {
    if (!column->empty()) {
      fillVectors(*column, columns.count);
    }
  }
  for (auto* column : {&s.width, &s.scale}) {
    if (!column->empty()) {
      column->resize(columns.count, kUnit);
    }
  }
  if (!s.isTransient.empty()) {
    s.isTransient.resize(columns.count, 0);
  }
  if (!s.following.empty()) {
    s.following.resize(columns.count, QueryColumns::kNoSymbol);
    s.followingOffset.resize(columns.count + 1, s.followingParameters.size());
  }
  columns.plant = s.plant;
  columns.module = s.module;
  columns.isTransient = s.isTransient;
  columns.symbol = s.symbol;
  columns.offset = s.offset;
  columns.parameters = s.parameters;
  columns.position = s.position;
  columns.heading = s.heading;
  columns.left = s.left;
  columns.up = s.up;
  columns.width = s.width;
  columns.scale = s.scale;
  columns.following = s.following;
  if (!s.following.empty()) {
    columns.followingOffset = s.followingOffset;
    columns.followingParameters = s.followingParameters;
  }
  columns.symbols = std::move(symbols_);
  columns.owner = std::move(storage_);
  return columns;
}

void ReplyCollector::value(double number) {
  storage_->values.push_back(number);
  if (!storage_->isSet.empty()) {
    storage_->isSet.push_back(1);
  }
}

void ReplyCollector::keep() {
  storage_->isSet.resize(storage_->values.size(), 1);
  storage_->isSet.push_back(0);
  storage_->values.push_back(0.0);
}

void addNote(std::string_view note, std::vector<std::string>& notes) {
  constexpr std::size_t kMaximumNotes = 50;
  constexpr std::size_t kMaximumBytes = 1'000;
  if (notes.size() < kMaximumNotes) {
    notes.emplace_back(beginningOf(note, kMaximumBytes));
  }
}

ReplyColumns ReplyCollector::take() {
  ReplyColumns columns;
  columns.count = storage_->id.size();
  columns.id = storage_->id;
  columns.offset = storage_->offset;
  columns.values = storage_->values;
  columns.isSet = storage_->isSet;
  columns.owner = std::move(storage_);
  return columns;
}

}  // namespace espalier::protocol
