#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace espalier::command {

/// The largest number of steps that an option takes.
inline constexpr std::uint64_t kMaximumSteps = 1'000'000'000;

/// An option that takes a whole number from `least` to `most` and passes it to `set`. Any other text, also a sign or a
/// fraction, is a usage error that names the range.
CLI::Option* addWholeNumber(CLI::App& command, const std::string& name, const std::string& help, std::uint64_t least,
                            std::uint64_t most, const std::function<void(std::uint64_t)>& set);

/// An option that takes a number above 0 and passes it to `set`. Any other text is a usage error: "give `unit`, above
/// 0".
CLI::Option* addPositiveNumber(CLI::App& command, const std::string& name, const std::string& help,
                               const std::string& unit, const std::function<void(double)>& set);

/// A check that a text is a number from `least` to `most`; NaN is none.
[[nodiscard]] CLI::Validator numberFrom(double least, double most);

}  // namespace espalier::command
