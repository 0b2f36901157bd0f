#pragma once

#include <string>
#include <vector>

#include "tests/architecture/source_tree.h"

namespace espalier::test {

/// Each returns one sentence per breach, with the file's name first; none: the rule holds.

/// Includes go only along the arrows of the folders: core <- files <- language <- derivation <- turtle <- simulation,
/// turtle <- environment, protocol alone, server/remote on all of them, server and clients/bmi on server/remote,
/// clients/cpp on protocol, clients/espalier on everything.
[[nodiscard]] std::vector<std::string> wrongDirections(const std::vector<SourceFile>& files);

/// Headers of engine/ and environment/ that are included from outside their folder name no third-party library.
[[nodiscard]] std::vector<std::string> thirdPartyNamesInPublicHeaders(const std::vector<SourceFile>& files);

/// engine/, environment/ and protocol/ never print, log, exit, read the clock, the environment or a file.
[[nodiscard]] std::vector<std::string> inputAndOutput(const std::vector<SourceFile>& files);

/// Only server/remote/control_group asks how many processors the machine has: a container may use fewer of them.
[[nodiscard]] std::vector<std::string> processorsOfTheMachine(const std::vector<SourceFile>& files);

/// The engine, environments, server/remote and the command line compute with core::sin and its like
/// (engine/core/elementary.h), which have the same bits on every processor. Files `published_…` reproduce programs that
/// were computed with the C library.
[[nodiscard]] std::vector<std::string> elementaryFunctionsOfTheCLibrary(const std::vector<SourceFile>& files);

/// A value or its failure is a tl::expected, not a variant that each caller takes apart. The MTG reader
/// (engine/turtle/export/text/mtg…) is exempt.
[[nodiscard]] std::vector<std::string> failuresInVariants(const std::vector<SourceFile>& files);

/// Code files have at most 700 lines.
[[nodiscard]] std::vector<std::string> longFiles(const std::vector<SourceFile>& files);

/// No file names a folder of the machine that it was written on.
[[nodiscard]] std::vector<std::string> machinePaths(const std::vector<SourceFile>& files);

/// Every folder with C++ sources outside tests/, or a folder above it, has a README.md.
[[nodiscard]] std::vector<std::string> foldersWithoutReadme(const std::vector<SourceFile>& files);

/// A folder has at most 35 source files; tests/ and clients/gallery/ are exempt.
[[nodiscard]] std::vector<std::string> crowdedFolders(const std::vector<SourceFile>& files);

}  // namespace espalier::test
