#include "engine/language/redefinition.h"

#include <algorithm>

namespace espalier::language {
namespace {

/// The name that a line defines: `  # define NAME ...`; empty for any other line.
std::string_view definedName(std::string_view line) {
  constexpr std::string_view kBlanks = " \t";
  const auto skip = [&line, kBlanks](std::string_view word) {
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
    const bool isThere = line.starts_with(word);
    line.remove_prefix(isThere ? word.size() : 0);
    return isThere;
  };
  if (!skip("#") || !skip("define") || !skip("")) {
    return {};
  }
  return line.substr(0, line.find_first_of(" \t\r("));
}

}  // namespace

std::vector<std::string_view> definedNames(const Program& program) {
  std::vector<std::string_view> names;
  for (const auto& file : program.sources) {
    const std::string_view text = file.text;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      if (const std::string_view name = definedName(text.substr(begin, end - begin)); !name.empty()) {
        names.push_back(name);
      }
      begin = end + 1;
    }
  }
  return names;
}

bool definesName(const Program& program, std::string_view name) {
  const std::vector<std::string_view> names = definedNames(program);
  return std::find(names.begin(), names.end(), name) != names.end();
}

CompileResult withDefinitions(const Program& program,
                              const std::vector<std::pair<std::string, std::string>>& definitions,
                              const core::Limits& limits) {
  CompileInput input;
  input.modelFile = program.modelFile;
  input.viewFile = program.viewFile;
  input.compatibility = program.compatibility;
  input.defines = program.defines;
  input.limits = limits;
  core::MemoryFileProvider files;
  for (const auto& file : program.sources) {
    files.add(file.name, file.text);
  }
  for (const auto& define : definitions) {
    if (definesName(program, define.first)) {
      std::erase_if(input.defines, [&define](const auto& old) { return old.first == define.first; });
      input.defines.push_back(define);
    }
  }
  return compile(input, files);
}

}  // namespace espalier::language
