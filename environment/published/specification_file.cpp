#include "environment/published/specification_file.h"

#include <algorithm>
#include <utility>

#include "environment/base/published_text.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

class SpecificationReader {
 public:
  SpecificationReader(const ProcessEntry& process, core::FileProvider& files, std::vector<Diagnostic>& warnings,
                      std::vector<Diagnostic>& errors)
      : process_(process), files_(files), warnings_(warnings), errors_(errors) {}

  Specification read(const std::string& file, std::string_view text) {
    for (const PublishedLine& line : readPublishedLines(file, text, PublishedSyntax::Specification, warnings_)) {
      const auto keyword = std::find_if(process_.publishedKeywords.begin(), process_.publishedKeywords.end(),
                                        [&](const PublishedKeyword& k) { return k.keyword == line.keyword; });
      if (keyword == process_.publishedKeywords.end()) {
        warnUnknown(line);
      } else {
        readLine(file, line, *keyword);
      }
    }
    return std::move(specification_);
  }

 private:
  void warnUnknown(const PublishedLine& line) {
    std::vector<std::string_view> names;
    for (const PublishedKeyword& keyword : process_.publishedKeywords) {
      names.push_back(keyword.keyword);
    }
    warn(line.location, "unknown keyword '" + line.keyword + "' of '" + std::string(process_.name) + "' is ignored",
         names.empty() ? "this process reads no specification" : core::suggestName(line.keyword, names));
  }

  void readLine(const std::string& file, const PublishedLine& line, const PublishedKeyword& keyword) {
    if (keyword.kind == PublishedKind::Unused) {
      return;
    }
    if (keyword.kind == PublishedKind::Own) {
      readOwn(file, line, keyword);
      return;
    }
    const std::string key(keyword.key);
    specification_.locations.insert_or_assign(key, valueLocation(line));
    if (keyword.kind == PublishedKind::Switch) {
      const auto words = keyword.onWords;
      const bool isOn = std::find(words.begin(), words.end(), line.value) != words.end();
      if (!isOn && line.value != "off" && line.value != "no") {
        warn(valueLocation(line), "'" + line.keyword + "' is neither on nor off: taken as off",
             "write '" + std::string(words.front()) + "' or 'off'");
      }
      specification_.values.insert_or_assign(key, isOn);
      return;
    }
    std::string_view rest;
    std::vector<double> numbers = readPublishedNumbers(line.value, &rest);
    if (keyword.kind != PublishedKind::Row && numbers.size() < keyword.count) {
      errors_.push_back({Severity::Error,
                         "'" + line.keyword + "' needs " +
                             (keyword.count == 1 ? "a number" : std::to_string(keyword.count) + " numbers") +
                             ", found " + (numbers.empty() ? "'" + line.value + "'" : std::to_string(numbers.size())),
                         valueLocation(line),
                         {}});
      return;
    }
    if (numbers.size() > keyword.count || !rest.empty()) {
      warn(valueLocation(line),
           "'" + line.keyword + "': the text after the first " +
               (keyword.count == 1 ? "number" : std::to_string(keyword.count) + " numbers") + " is ignored",
           {});
      numbers.resize(std::min(numbers.size(), keyword.count));
    }
    if (keyword.kind == PublishedKind::Number) {
      specification_.values.insert_or_assign(key, numbers.front());
    } else if (keyword.kind == PublishedKind::Numbers) {
      specification_.values.insert_or_assign(key, std::move(numbers));
    } else {
      auto& rows = specification_.values.try_emplace(key, ConfigurationRows{}).first->second;
      std::get<ConfigurationRows>(rows).push_back(std::move(numbers));
    }
  }

  void readOwn(const std::string& file, const PublishedLine& line, const PublishedKeyword& keyword) {
    ConfigurationValues read;
    const std::string problem = keyword.read(PublishedLineInput{line, file, files_, read});
    if (!problem.empty()) {
      errors_.push_back({Severity::Error, "'" + line.keyword + "' " + problem, valueLocation(line), {}});
      return;
    }
    for (auto& [key, value] : read) {
      specification_.locations.insert_or_assign(key, valueLocation(line));
      specification_.values.insert_or_assign(key, std::move(value));
    }
  }

  void warn(const SourceLocation& location, std::string message, std::string hint) {
    warnings_.push_back({Severity::Warning, std::move(message), location, std::move(hint)});
  }

  const ProcessEntry& process_;
  core::FileProvider& files_;
  std::vector<Diagnostic>& warnings_;
  std::vector<Diagnostic>& errors_;
  Specification specification_;
};

}  // namespace

Specification readSpecification(const ProcessEntry& process, const std::string& file, std::string_view text,
                                core::FileProvider& files, std::vector<core::Diagnostic>& warnings,
                                std::vector<core::Diagnostic>& errors) {
  return SpecificationReader(process, files, warnings, errors).read(file, text);
}

}  // namespace espalier::environment
