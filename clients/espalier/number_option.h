#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace espalier::command {

/// The largest number of steps that an option takes.
inline constexpr std::uint64_t kMaximumSteps = 1'000'000'000;

/// An option that takes a whole number from `least` to `most`, given to `set`. Anything else, a sign or a fraction too,
/// is refused as wrong usage with the range.
CLI::Option* addWholeNumber(CLI::App& command, const std::string& name, const std::string& help, std::uint64_t least,
                            std::uint64_t most, const std::function<void(std::uint64_t)>& set);

/// An option that takes a number above 0, given to `set`. `unit` completes "give", as in "seconds". Anything else is
/// refused as wrong usage.
CLI::Option* addPositiveNumber(CLI::App& command, const std::string& name, const std::string& help,
                               const std::string& unit, const std::function<void(double)>& set);

}  // namespace espalier::command
