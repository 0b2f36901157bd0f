#include "clients/espalier/validation/reference_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <utility>

namespace espalier::validation {

namespace {

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char letter : line) {
    if (letter == '\t') {
      fields.emplace_back();
    } else if (letter != '\r') {
      fields.back().push_back(letter);
    }
  }
  return fields;
}

}  // namespace

std::optional<ReferenceTable> ReferenceTable::read(const Data& data, const std::string& name,
                                                   std::vector<std::string>& missing) {
  const auto text = data(name);
  if (!text) {
    missing.push_back(name);
    return std::nullopt;
  }
  ReferenceTable table;
  table.name_ = name;
  std::istringstream lines(*text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    std::vector<std::string> fields = fieldsOf(line);
    if (table.columns_.empty()) {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        table.columns_[fields[i]] = i;
      }
    } else {
      fields.resize(std::max(fields.size(), table.columns_.size()));
      table.rows_.push_back(std::move(fields));
      table.lines_.push_back(number);
    }
  }
  if (table.rows_.empty()) {
    throw TableError(name + " has no rows. Give a table with a header and a row for each value");
  }
  return table;
}

ReferenceTable ReferenceTable::of(const std::string& name, const std::string& rowWord,
                                  const std::vector<std::string>& columns, std::vector<std::vector<std::string>> rows) {
  ReferenceTable table;
  table.name_ = name;
  table.rowWord_ = rowWord;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    table.columns_[columns[i]] = i;
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    table.lines_.push_back(row);
  }
  table.rows_ = std::move(rows);
  return table;
}

void ReferenceTable::refuse(std::size_t row, const std::string& sentences) const {
  throw TableError(name_ + ", " + rowWord_ + " " + std::to_string(lines_[row]) + ": " + sentences);
}

const std::string& ReferenceTable::text(std::size_t row, const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) {
    throw TableError(name_ + " has no column '" + column + "'. Fields are separated by tabs, and a header names them");
  }
  return rows_[row][found->second];
}

double ReferenceTable::number(std::size_t row, const std::string& column) const {
  const std::string& field = text(row, column);
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  if (end == field.c_str() || *end != '\0' || !std::isfinite(value)) {
    refuse(row, "expected a number in the column '" + column + "', found '" + field + "'. Write a number there");
  }
  return value;
}

std::vector<double> ReferenceTable::column(const std::string& column) const {
  std::vector<double> numbers;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    numbers.push_back(number(row, column));
  }
  return numbers;
}

double normalisedError(const std::vector<double>& reference, const std::vector<double>& result) {
  double squares = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    squares += (reference[i] - result[i]) * (reference[i] - result[i]);
    sum += reference[i];
  }
  const auto count = static_cast<double>(reference.size());
  return std::sqrt(squares / count) / std::abs(sum / count);
}

double interpolate(const std::vector<std::pair<double, double>>& points, double x) {
  const auto above = std::find_if(points.begin(), points.end(), [&](const auto& point) { return point.first > x; });
  if (above == points.begin() || above == points.end()) {
    return above == points.begin() ? points.front().second : points.back().second;
  }
  const auto& [fromX, fromY] = *(above - 1);
  return fromY + (x - fromX) / (above->first - fromX) * (above->second - fromY);
}

}  // namespace espalier::validation
