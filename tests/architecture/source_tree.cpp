#include "tests/architecture/source_tree.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "tests/support/disk_files.h"

namespace espalier::test {
namespace {

namespace fs = std::filesystem;

// "musl" is copied code
constexpr std::array kSkippedFolders = {"build",       "out",         ".git",  ".setup", "node_modules",
                                        "__pycache__", ".mypy_cache", "cases", "musl"};

constexpr std::array kTextSuffixes = {".h", ".cpp", ".def", ".py", ".md", ".txt", ".json", ".toml", ".sh",
                                      ".l", ".v",   ".e",   ".ts", ".js", ".yml", ".html", ".css"};

bool isSkipped(const fs::path& folder) {
  return std::find(kSkippedFolders.begin(), kSkippedFolders.end(), folder.filename().string()) != kSkippedFolders.end();
}

bool isText(const fs::path& file) {
  const std::string suffix = file.extension().string();
  // scripts have no suffix
  return suffix.empty() || std::find(kTextSuffixes.begin(), kTextSuffixes.end(), suffix) != kTextSuffixes.end();
}

// end of a literal or comment that begins at `begin`, one past it; npos: none begins there
std::size_t skip(const std::string& text, std::size_t begin) {
  if (text.compare(begin, 2, "//") == 0) {
    return std::min(text.find('\n', begin), text.size());
  }
  if (text.compare(begin, 2, "/*") == 0) {
    const std::size_t end = text.find("*/", begin + 2);
    return end == std::string::npos ? text.size() : end + 2;
  }
  if (text.compare(begin, 2, "R\"") == 0) {
    const std::size_t open = text.find('(', begin);
    const std::string close = ")" + text.substr(begin + 2, open - begin - 2) + "\"";
    const std::size_t end = text.find(close, open);
    return end == std::string::npos ? text.size() : end + close.size();
  }
  const bool isDigitSeparator =
      text[begin] == '\'' && begin > 0 && std::isalnum(static_cast<unsigned char>(text[begin - 1]));
  if ((text[begin] == '"' || text[begin] == '\'') && !isDigitSeparator) {
    std::size_t i = begin + 1;
    while (i < text.size() && text[i] != text[begin]) {
      i += text[i] == '\\' ? 2U : 1U;
    }
    return std::min(i + 1, text.size());
  }
  return std::string::npos;
}

}  // namespace

std::vector<SourceFile> readSourceTree(const std::string& root) {
  std::vector<SourceFile> files;
  for (auto entry = fs::recursive_directory_iterator(root); entry != fs::recursive_directory_iterator(); ++entry) {
    if (entry->is_directory() && isSkipped(entry->path())) {
      entry.disable_recursion_pending();
    } else if (entry->is_regular_file() && isText(entry->path())) {
      files.push_back(
          {fs::relative(entry->path(), root).generic_string(), readFile(entry->path().string()).value_or("")});
    }
  }
  std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) { return a.name < b.name; });
  return files;
}

std::string withoutCommentsAndLiterals(const std::string& text) {
  std::string result;
  std::size_t i = 0;
  while (i < text.size()) {
    // the name of an include line is not a literal
    if (text.compare(i, 8, "#include") == 0) {
      const std::size_t end = std::min(text.find('\n', i), text.size());
      result += text.substr(i, end - i);
      i = end;
      continue;
    }
    const std::size_t end = skip(text, i);
    if (end == std::string::npos) {
      result += text[i++];
    } else {
      result += ' ';
      i = end;
    }
  }
  return result;
}

std::vector<std::string> quotedIncludes(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream stream(text);
  constexpr std::string_view kStart = "#include \"";
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(kStart, 0) == 0) {
      names.push_back(line.substr(kStart.size(), line.find('"', kStart.size()) - kStart.size()));
    }
  }
  return names;
}

}  // namespace espalier::test
