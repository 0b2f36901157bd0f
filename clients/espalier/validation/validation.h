#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::validation {

/// One comparison of a benchmark: how far the result is from the reference.
struct Row {
  std::string what;                 // "loam, depth, cm"
  double error = 0.0;               // in the sense of `what`; not a number: no result
  std::optional<double> tolerance;  // nothing: a figure that is reported only
  std::string published;            // errors of other programs in the same comparison, or empty

  [[nodiscard]] bool isMet() const { return !tolerance || error <= *tolerance; }
};

/// The largest of some errors. Not a number when there is none, or when one of them is not a number: nothing was shown.
class LargestError {
 public:
  void add(double error) {
    value_ = isEmpty_ || error > value_ || std::isnan(error) ? error : value_;
    isEmpty_ = false;
  }
  [[nodiscard]] double value() const { return value_; }

 private:
  double value_ = std::numeric_limits<double>::quiet_NaN();
  bool isEmpty_ = true;
};

/// A line of a picture of the results, or dots.
struct Curve {
  std::string name;
  bool isReference = false;
  std::vector<std::pair<double, double>> points;
  bool isDots = false;
};

/// A picture beside that of CaseResult::curves.
struct Picture {
  std::string name;  // of the file, behind that of the case: "sinks"
  std::string across, up;
  std::vector<Curve> curves;
};

struct CaseResult {
  std::vector<Row> rows;
  std::vector<Curve> curves;
  std::string across;                // the quantity along the horizontal, with its unit: "time, day"
  std::string up;                    // and along the vertical
  std::vector<std::string> missing;  // files of data without which a part is left out
  std::vector<Picture> pictures{};   // further ones

  /// All pictures that have curves; that of `curves` has no name.
  [[nodiscard]] std::vector<Picture> allPictures() const {
    std::vector<Picture> all;
    if (!curves.empty()) {
      all.push_back({"", across, up, curves});
    }
    all.insert(all.end(), pictures.begin(), pictures.end());
    return all;
  }
};

/// The text of a file of published data by its name; nothing when it is not there.
using Data = std::function<std::optional<std::string>(const std::string& name)>;

/// A benchmark with a known answer.
struct Case {
  std::string_view name;   // "m3.1"
  std::string_view title;  // one line: what is compared with what, and the source
  bool isQuick = true;     // belongs to the ordinary tests
  CaseResult (*run)(const Data& data);
};

/// All benchmarks in the order of the table.
[[nodiscard]] std::span<const Case> cases();

/// The cases, by subject: architecture_cases.cpp, soil_cases.cpp, root_cases.cpp, uptake_cases.cpp,
/// weather_cases.cpp, light_cases.cpp, forest_cases.cpp, stand_cases.cpp.
[[nodiscard]] std::span<const Case> architectureCases();
[[nodiscard]] std::span<const Case> soilCases();
[[nodiscard]] std::span<const Case> rootCases();
[[nodiscard]] std::span<const Case> uptakeCases();
[[nodiscard]] std::span<const Case> weatherCases();
[[nodiscard]] std::span<const Case> lightCases();
[[nodiscard]] std::span<const Case> forestCases();
[[nodiscard]] std::span<const Case> standCases();

}  // namespace espalier::validation
