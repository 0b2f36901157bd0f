#include "clients/espalier/installation/version_text.h"

#include <gnu/libc-version.h>
#include <sys/utsname.h>

#include <filesystem>
#include <fstream>

#include "protocol/version.h"
#include "server/remote/control_group.h"
#include "server/remote/models/gallery.h"

namespace espalier::command {
namespace {

// the value of the first line `KEY : VALUE` of /proc/cpuinfo
std::string processorFact(const std::string& key) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with(key) && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

// those that vector code asks for
std::string vectorInstructions() {
  const std::string flags = " " + processorFact("flags") + " ";
  std::string found;
  for (const char* const name : {"sse4_2", "avx", "avx2", "fma", "avx512f"}) {
    if (flags.find(" " + std::string(name) + " ") != std::string::npos) {
      found += (found.empty() ? "" : " ") + std::string(name);
    }
  }
  return found.empty() ? "none" : found;
}

std::string orMissing(const std::string& folder) {
  return folder.empty() ? "not found" : folder;
}

}  // namespace

std::string versionLine() {
  return "espalier " ESPALIER_VERSION;
}

std::string verboseVersionText() {
  utsname system{};
  (void)::uname(&system);
  std::error_code error;
  std::string text = versionLine() + "\n";
  text += "protocol    " + std::string(protocol::kProtocolName) + "\n";
#ifdef __clang__
  text += "compiler    clang " __clang_version__ "\n";
#else
  text += "compiler    gcc " __VERSION__ "\n";
#endif
  text += "C library   glibc " + std::string(::gnu_get_libc_version()) + "\n";
  text += "system      " + std::string(system.sysname) + " " + system.release + " " + system.machine + "\n";
  text += "processor   " + processorFact("model name") + ", " + std::to_string(server::processorCount()) + " threads\n";
  text += "vectors     " + vectorInstructions() + "\n";
  text += "program     " + std::filesystem::read_symlink("/proc/self/exe", error).string() + "\n";
  text += "gallery     " + orMissing(server::galleryOfProgram()) + "\n";
  text += "suite       " + orMissing(server::conformanceOfProgram()) + "\n";
  text += "handbook    " + orMissing(server::handbookOfProgram());
  return text;
}

}  // namespace espalier::command
