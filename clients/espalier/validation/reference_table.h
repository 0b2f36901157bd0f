#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

/// A table of reference values: fields separated by tabs, comments from `#`, a header line with the names of the
/// columns.
class ReferenceTable {
 public:
  /// Nothing when the file is missing; its name is added to `missing` then.
  [[nodiscard]] static std::optional<ReferenceTable> read(const Data& data, const std::string& name,
                                                          std::vector<std::string>& missing);

  [[nodiscard]] std::size_t rowCount() const { return rows_.size(); }
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  /// The number in a field; not a number when the field has none.
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  /// The numbers of a column.
  [[nodiscard]] std::vector<double> column(const std::string& column) const;

 private:
  std::map<std::string, std::size_t> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// √mean((y − ŷ)²)/|mean y| of the reference y and the result ŷ.
[[nodiscard]] double normalisedError(const std::vector<double>& reference, const std::vector<double>& result);

/// Linear between points that ascend, constant beyond.
[[nodiscard]] double interpolate(const std::vector<std::pair<double, double>>& points, double x);

}  // namespace espalier::validation
