#include "environment/hydraulics/conductivities.h"

#include <algorithm>
#include <numbers>

#include "environment/base/number_text.h"

namespace espalier::environment {

double vesselConductance(double count, double radius) {
  constexpr double kWeight = 998.2 * 9.80665;  // of a cubic metre of water, N
  constexpr double kViscosity = 1.0016e-3;     // Pa s
  constexpr double kSecondsPerDay = 86400.0;
  const double square = radius * radius;
  return count * std::numbers::pi * square * square * kWeight / (8.0 * kViscosity) * kSecondsPerDay;
}

ConductivityTable::ConductivityTable(double constant, const ConfigurationRows& rows)
    : constant_(constant), rows_(rows) {}

double ConductivityTable::at(double order, double age) const {
  if (rows_.empty()) {
    return constant_;
  }
  const auto isBelow = [](double number, const std::vector<double>& row) { return number < row[0]; };
  // the rows of the highest order that is not above this one
  auto end = std::upper_bound(rows_.begin(), rows_.end(), order, isBelow);
  if (end == rows_.begin()) {
    end = std::upper_bound(rows_.begin(), rows_.end(), rows_.front()[0], isBelow);
  }
  const double found = (*(end - 1))[0];
  const auto begin = std::partition_point(rows_.begin(), end, [&](const auto& row) { return row[0] < found; });
  const auto after = std::find_if(begin, end, [&](const auto& row) { return row[1] > age; });
  if (after == begin || after == end) {
    return after == begin ? (*begin)[2] : (*(end - 1))[2];
  }
  const auto& from = *(after - 1);
  const double part = (age - from[1]) / ((*after)[1] - from[1]);
  return from[2] + part * ((*after)[2] - from[2]);
}

std::string ConductivityTable::problemOf(const ConfigurationRows& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0 && !(rows[i - 1][0] < rows[i][0] || (rows[i - 1][0] == rows[i][0] && rows[i - 1][1] < rows[i][1]))) {
      return "has the age " + numberText(rows[i][1]) + " of order " + numberText(rows[i][0]) + " after the age " +
             numberText(rows[i - 1][1]) + " of order " + numberText(rows[i - 1][0]);
    }
    if (rows[i][2] < 0.0) {
      return "has the conductivity " + numberText(rows[i][2]) + " in row " + std::to_string(i) + ", which is below 0";
    }
  }
  return {};
}

}  // namespace espalier::environment
