#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

/// A table that is not as it must be: a sentence with its file, line and column.
class TableError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A table of reference values: fields separated by tabs, comments from `#`, a header line with the names of the
/// columns.
class ReferenceTable {
 public:
  /// Nothing when the file is missing; its name is added to `missing` then. Throws TableError for a table without rows.
  [[nodiscard]] static std::optional<ReferenceTable> read(const Data& data, const std::string& name,
                                                          std::vector<std::string>& missing);

  /// A table of rows that another file says, whose rows are called `rowWord`: messages name them by it and by their
  /// number from 0.
  [[nodiscard]] static ReferenceTable of(const std::string& name, const std::string& rowWord,
                                         const std::vector<std::string>& columns,
                                         std::vector<std::vector<std::string>> rows);

  [[nodiscard]] std::size_t rowCount() const { return rows_.size(); }
  /// The text in a field. Throws TableError without that column.
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  /// The number in a field. Throws TableError when there is none, or no such column.
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  /// The numbers of a column.
  [[nodiscard]] std::vector<double> column(const std::string& column) const;
  /// Throws TableError about a row.
  [[noreturn]] void refuse(std::size_t row, const std::string& sentences) const;

 private:
  std::string name_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::vector<std::string>> rows_;
  std::string rowWord_ = "line";
  std::vector<std::size_t> lines_;  // in the file, from 1 (rows)
};

/// √mean((y − ŷ)²)/|mean y| of the reference y and the result ŷ.
[[nodiscard]] double normalisedError(const std::vector<double>& reference, const std::vector<double>& result);

/// Linear between points that ascend, constant beyond.
[[nodiscard]] double interpolate(const std::vector<std::pair<double, double>>& points, double x);

}  // namespace espalier::validation
