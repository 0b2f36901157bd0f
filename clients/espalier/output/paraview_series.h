#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace espalier::command {

/// Writes the series of a run with --every as ParaView reads them: for each of `files` that ends in .vtp, .vtu or .vti
/// a .pvd, which lists the file of every step with the step as its time. Files that differ in the suffix only are parts
/// of one series. False: a file could not be written, an error was printed.
[[nodiscard]] bool writeParaviewSeries(std::span<const std::string> files, std::span<const std::uint64_t> steps,
                                       bool isQuiet);

}  // namespace espalier::command
