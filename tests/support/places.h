#pragma once

#include <string>

/// Where tests find the repository's own files and what was built.
namespace espalier {

/// The folder of the sources, absolute, without a slash at its end.
std::string sourceFolder();

/// The folder of the build, absolute, without a slash at its end: the program is bin/espalier in it, plug-ins are in
/// lib.
std::string buildFolder();

}  // namespace espalier
