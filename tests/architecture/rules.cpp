#include "tests/architecture/rules.h"

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <utility>

namespace espalier::test {
namespace {

// names that the files of a folder may include, by prefix of the included name
const std::vector<std::pair<std::string, std::vector<std::string>>>& directions() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> kDirections = {
      {"engine/core/", {"engine/core/"}},
      {"engine/files/", {"engine/core/", "engine/files/"}},
      {"engine/language/", {"engine/core/", "engine/files/", "engine/language/"}},
      {"engine/derivation/", {"engine/core/", "engine/files/", "engine/language/", "engine/derivation/"}},
      {"engine/turtle/", {"engine/core/", "engine/files/", "engine/language/", "engine/derivation/", "engine/turtle/"}},
      {"engine/simulation/", {"engine/"}},
      {"environment/",
       {"engine/core/", "engine/files/", "engine/language/", "engine/derivation/", "engine/turtle/", "environment/"}},
      {"protocol/", {"protocol/"}},
      {"server/remote/", {"engine/", "environment/", "protocol/", "server/remote/"}},
      {"server/language_server/", {"engine/core/", "engine/files/", "engine/language/", "server/language_server/"}},
      {"server/", {"engine/", "environment/", "protocol/", "server/"}},
      {"clients/bmi/", {"engine/", "environment/", "protocol/", "server/remote/", "clients/bmi/"}},
      {"clients/cpp/", {"protocol/", "clients/cpp/"}},
      {"clients/web/", {"clients/web/"}},
      {"clients/espalier/", {"engine/", "environment/", "protocol/", "server/", "clients/"}},
  };
  return kDirections;
}

bool startsWith(const std::string& text, const std::string& prefix) {
  return text.rfind(prefix, 0) == 0;
}

bool endsWith(const std::string& text, const std::string& suffix) {
  return text.size() >= suffix.size() && text.compare(text.size() - suffix.size(), suffix.size(), suffix) == 0;
}

bool isCpp(const SourceFile& file) {
  return endsWith(file.name, ".h") || endsWith(file.name, ".cpp");
}

std::string folderOf(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? std::string{} : name.substr(0, slash);
}

// the folder of the library that a file belongs to, as in the directions; empty: none
std::string libraryOf(const std::string& name) {
  const auto entry = std::find_if(directions().begin(), directions().end(),
                                  [&](const auto& direction) { return startsWith(name, direction.first); });
  return entry == directions().end() ? std::string{} : entry->first;
}

bool isPure(const std::string& name) {
  return startsWith(name, "engine/") || startsWith(name, "environment/") || startsWith(name, "protocol/");
}

// headers of engine/ and environment/ that a file of another folder sees, directly or through another header
std::set<std::string> publicHeaders(const std::vector<SourceFile>& files) {
  std::map<std::string, std::vector<std::string>> includes;
  std::vector<std::string> open;
  for (const SourceFile& file : files) {
    if (!isCpp(file) || startsWith(file.name, "tests/")) {
      continue;
    }
    includes[file.name] = quotedIncludes(file.text);
    for (const std::string& included : includes[file.name]) {
      if (libraryOf(file.name) != libraryOf(included) &&
          (startsWith(included, "engine/") || startsWith(included, "environment/"))) {
        open.push_back(included);
      }
    }
  }
  std::set<std::string> seen;
  while (!open.empty()) {
    const std::string header = open.back();
    open.pop_back();
    if (seen.insert(header).second) {
      open.insert(open.end(), includes[header].begin(), includes[header].end());
    }
  }
  return seen;
}

}  // namespace

std::vector<std::string> wrongDirections(const std::vector<SourceFile>& files) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const auto rule = std::find_if(directions().begin(), directions().end(),
                                   [&](const auto& entry) { return startsWith(file.name, entry.first); });
    if (!isCpp(file) || rule == directions().end()) {
      continue;
    }
    for (const std::string& included : quotedIncludes(file.text)) {
      const bool isAllowed = std::any_of(rule->second.begin(), rule->second.end(),
                                         [&](const std::string& prefix) { return startsWith(included, prefix); });
      if (!isAllowed) {
        breaches.push_back(file.name + " includes " + included + ", which " + rule->first + " may not");
      }
    }
  }
  return breaches;
}

std::vector<std::string> thirdPartyNamesInPublicHeaders(const std::vector<SourceFile>& files) {
  static const std::regex kLibraries(R"(\b(nlohmann|simdjson|spdlog|asio|embree\w*|RTC\w+|boost)\b)");
  const std::set<std::string> isPublic = publicHeaders(files);
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (isPublic.count(file.name) == 0) {
      continue;
    }
    const std::string code = withoutCommentsAndLiterals(file.text);
    std::smatch match;
    if (std::regex_search(code, match, kLibraries)) {
      breaches.push_back(file.name + " is a public header and names " + match.str());
    }
  }
  return breaches;
}

std::vector<std::string> inputAndOutput(const std::vector<SourceFile>& files) {
  static const std::regex kForbidden(
      R"(<(iostream|fstream|filesystem|chrono|ctime|print)>|\bstd::(cout|cerr|clog|exit|abort|getenv|system)\b|)"
      R"(\b(printf|fprintf|vprintf|puts|fputs|perror|fopen|getenv|clock_gettime|gettimeofday)\s*\()");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!isCpp(file) || !isPure(file.name)) {
      continue;
    }
    const std::string code = withoutCommentsAndLiterals(file.text);
    for (auto match = std::sregex_iterator(code.begin(), code.end(), kForbidden); match != std::sregex_iterator();
         ++match) {
      breaches.push_back(file.name + " uses " + match->str());
    }
  }
  return breaches;
}

std::vector<std::string> processorsOfTheMachine(const std::vector<SourceFile>& files) {
  static const std::regex kAsking(
      R"(\b(hardware_concurrency|sched_getaffinity|get_nprocs(_conf)?|_SC_NPROCESSORS_\w+|omp_get_\w+)\b)");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!isCpp(file) || startsWith(file.name, "tests/") || file.name == "server/remote/control_group.cpp") {
      continue;
    }
    const std::string code = withoutCommentsAndLiterals(file.text);
    for (auto match = std::sregex_iterator(code.begin(), code.end(), kAsking); match != std::sregex_iterator();
         ++match) {
      breaches.push_back(file.name + " uses " + match->str() +
                         ": use processorCount() of server/remote/control_group.h, or take the number from the caller");
    }
  }
  return breaches;
}

std::vector<std::string> elementaryFunctionsOfTheCLibrary(const std::vector<SourceFile>& files) {
  static const std::regex kFunctions(
      R"(std::(a?(sin|cos|tan)h?|atan2|exp2?|expm1|log(2|10|1p)?|pow|hypot|cbrt|erfc?|[lt]gamma)\s*\()");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const bool isHeld = startsWith(file.name, "engine/") || startsWith(file.name, "environment/") ||
                        startsWith(file.name, "server/remote/") || startsWith(file.name, "clients/espalier/");
    // the references of benchmarks share no code with what they test
    const bool isExempt = startsWith(file.name, "engine/core/elementary.") ||
                          startsWith(file.name, "clients/espalier/validation/") ||
                          file.name.find("/published_") != std::string::npos;
    if (!isCpp(file) || !isHeld || isExempt) {
      continue;
    }
    const std::string code = withoutCommentsAndLiterals(file.text);
    for (auto match = std::sregex_iterator(code.begin(), code.end(), kFunctions); match != std::sregex_iterator();
         ++match) {
      breaches.push_back(file.name + " uses " + match->str() + "): use core:: of engine/core/elementary.h");
    }
  }
  return breaches;
}

std::vector<std::string> failuresInVariants(const std::vector<SourceFile>& files) {
  static const std::regex kFailure(R"(std::variant<[^;{}()]*,\s*(\w+::)*(\w*Error|DiagnosticList|string)\s*>)");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const bool isExempt = startsWith(file.name, "tests/") || startsWith(file.name, "engine/turtle/export/text/mtg");
    if (!isCpp(file) || isExempt) {
      continue;
    }
    const std::string code = withoutCommentsAndLiterals(file.text);
    for (auto match = std::sregex_iterator(code.begin(), code.end(), kFailure); match != std::sregex_iterator();
         ++match) {
      breaches.push_back(file.name + " uses " + match->str() + ": use tl::expected");
    }
  }
  return breaches;
}

std::vector<std::string> longFiles(const std::vector<SourceFile>& files) {
  constexpr std::ptrdiff_t kMostLines = 700;
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const bool isCode = isCpp(file) || endsWith(file.name, ".py") || endsWith(file.name, ".def") || file.name == "dev";
    const std::ptrdiff_t lines = std::count(file.text.begin(), file.text.end(), '\n');
    if (isCode && lines > kMostLines) {
      breaches.push_back(file.name + " has " + std::to_string(lines) + " lines");
    }
  }
  return breaches;
}

std::vector<std::string> machinePaths(const std::vector<SourceFile>& files) {
  static const std::regex kPath(R"((^|[^\w.])/(work|root|home|tmp)/[\w.])");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    std::smatch match;
    if (std::regex_search(file.text, match, kPath)) {
      const auto line = 1 + std::count(file.text.begin(), file.text.begin() + match.position(0), '\n');
      breaches.push_back(file.name + ":" + std::to_string(line) + " names a folder of one machine");
    }
  }
  return breaches;
}

std::vector<std::string> foldersWithoutReadme(const std::vector<SourceFile>& files) {
  std::set<std::string> folders;
  std::set<std::string> documented;
  for (const SourceFile& file : files) {
    const bool isOurs = isPure(file.name) || startsWith(file.name, "server/") || startsWith(file.name, "clients/");
    if (isOurs && isCpp(file)) {
      folders.insert(folderOf(file.name));
    }
    if (endsWith(file.name, "/README.md")) {
      documented.insert(folderOf(file.name));
    }
  }
  // the rooms of a folder are documented on its page
  std::vector<std::string> breaches;
  for (const std::string& folder : folders) {
    std::string page = folder;
    while (!page.empty() && documented.count(page) == 0) {
      page = folderOf(page);
    }
    if (page.empty()) {
      breaches.push_back(folder + " has no README.md");
    }
  }
  return breaches;
}

std::vector<std::string> crowdedFolders(const std::vector<SourceFile>& files) {
  constexpr int kMostFiles = 35;
  std::map<std::string, int> counts;
  for (const SourceFile& file : files) {
    const bool isSource = isCpp(file) || endsWith(file.name, ".def") || endsWith(file.name, ".py") ||
                          endsWith(file.name, ".ts") || endsWith(file.name, ".js");
    const bool isExempt = startsWith(file.name, "tests/") || startsWith(file.name, "clients/gallery/");
    if (isSource && !isExempt) {
      ++counts[folderOf(file.name)];
    }
  }
  std::vector<std::string> breaches;
  for (const auto& [folder, count] : counts) {
    if (count > kMostFiles) {
      breaches.push_back(folder + " has " + std::to_string(count) + " source files: give it subfolders");
    }
  }
  return breaches;
}

}  // namespace espalier::test
