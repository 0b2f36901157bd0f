#include "tests/fuzz/bundle.h"

#include <algorithm>

namespace espalier::fuzz {
namespace {

constexpr std::string_view kMark = "==== ";

}  // namespace

core::MemoryFileProvider unbundle(std::string_view text, const std::string& mainFile) {
  core::MemoryFileProvider files;
  std::string name = mainFile;
  std::size_t begin = 0;
  std::size_t line = 0;
  while (line < text.size()) {
    const std::size_t next = std::min(text.find('\n', line), text.size() - 1) + 1;
    if (text.substr(line, kMark.size()) == kMark) {
      files.add(name, std::string(text.substr(begin, line - begin)));
      const std::string_view rest = text.substr(line + kMark.size(), next - line - kMark.size());
      name = rest.substr(0, rest.find_first_of(" \t\r\n"));
      begin = next;
    }
    line = next;
  }
  files.add(name, std::string(text.substr(begin)));
  return files;
}

std::string bundleHead(std::string_view name) {
  return std::string(kMark) + std::string(name) + '\n';
}

}  // namespace espalier::fuzz
