#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::conformance {

/// One module of a string in text form: a symbol of one character and its parameters.
struct TextModule {
  char symbol = 0;
  std::vector<double> parameters;
  std::string text;  // as written
};

/// How far two numbers may be apart: |a-b| <= relative * max(|a|,|b|) + absolute. Never met by a value that is not
/// finite.
struct Tolerance {
  double relative = 1e-5;
  double absolute = 1e-6;
};

/// The largest difference between two numbers that agreed.
struct Deviation {
  double share = 0.0;  // of what the tolerance allows, 0 … 1
  std::string place;   // "module 3: expected A(1), actual A(1.00001)"; empty: all numbers were equal
};

/// Splits the text form into modules (cases/README.md, "How to compare"). Nothing when a parameter is not a number or a
/// list has no end; `problem` then says where.
[[nodiscard]] std::optional<std::vector<TextModule>> splitModules(std::string_view text, std::string& problem);

/// The first difference between two strings in text form as a sentence, or nothing when they agree. `largest` becomes
/// the largest deviation that was accepted, when it is larger than what it holds.
[[nodiscard]] std::optional<std::string> firstDifference(std::string_view expected, std::string_view actual,
                                                         const Tolerance& tolerance, Deviation& largest);

}  // namespace espalier::conformance
