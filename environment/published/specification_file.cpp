#include "environment/published/specification_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "environment/base/number_text.h"
#include "environment/base/published_text.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

/// A keyword of every program, which has no effect on answers.
constexpr std::string_view kVerbose = "verbose";

class SpecificationReader {
 public:
  SpecificationReader(const ProcessEntry& process, core::FileProvider& files, std::vector<Diagnostic>& warnings,
                      std::vector<Diagnostic>& errors)
      : process_(process), files_(files), warnings_(warnings), errors_(errors) {
    if (process.publishedDefaults != nullptr) {
      specification_.values = process.publishedDefaults();
    }
  }

  Specification read(const std::string& file, std::string_view text) {
    const std::vector<PublishedLine> lines = readPublishedLines(file, text, warnings_);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const PublishedLine& line = lines[i];
      lines_ = lines;
      before_ = lines_.first(i);
      const auto keyword = std::find_if(process_.publishedKeywords.begin(), process_.publishedKeywords.end(),
                                        [&](const PublishedKeyword& k) { return k.keyword == line.keyword; });
      if (keyword != process_.publishedKeywords.end()) {
        readLine(file, line, *keyword);
      } else if (line.keyword != kVerbose) {
        warnUnknown(line);
      }
      if (keyword == process_.publishedKeywords.end() || keyword->kind != PublishedKind::Own) {
        for (const SourceLocation& location : line.dataLocations) {
          warn(location, "line of numbers is ignored: '" + line.keyword + "' takes none", "expected 'keyword: values'");
        }
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
    if (keyword.kind == PublishedKind::Switch) {
      readSwitch(line, keyword);
      return;
    }
    bool areWhole = true;
    std::vector<double> numbers = readPublishedNumbers(line.value, &areWhole);
    if (keyword.kind == PublishedKind::Row && numbers.size() < keyword.count) {
      warn(valueLocation(line),
           "'" + line.keyword + "' needs " + std::to_string(keyword.count) + " numbers, found " +
               std::to_string(numbers.size()) + ": the line is dropped",
           {});
      return;
    }
    if (std::any_of(numbers.begin(), numbers.end(), [](double n) { return !std::isfinite(n); })) {
      errors_.push_back({Severity::Error, "'" + line.keyword + "' has a number that is too large", valueLocation(line),
                         "write a number below 1e308"});
      return;
    }
    if (!areWhole || numbers.size() != keyword.count) {
      warnOfNumbers(line, keyword, numbers, areWhole);
    }
    setNumbers(line, keyword, std::move(numbers));
  }

  void readSwitch(const PublishedLine& line, const PublishedKeyword& keyword) {
    const std::string_view word = firstPublishedWord(line.value);
    const bool switchesOn = keyword.offWords.empty();
    const auto words = switchesOn ? keyword.onWords : keyword.offWords;
    const bool isExact = std::find(words.begin(), words.end(), word) != words.end();
    const bool isOther = switchesOn ? word == "off" || word == "no" : word == "on" || word == "yes";
    if (!isExact && !isOther) {
      const std::string exact(words.front());
      warn(valueLocation(line),
           "'" + line.keyword + "' is switched " + (switchesOn ? "on" : "off") + " only by '" + exact + "': taken as " +
               (switchesOn ? "off" : "on"),
           "write '" + exact + "' or '" + (switchesOn ? "off" : "on") + "'");
    }
    specification_.locations.insert_or_assign(std::string(keyword.key), valueLocation(line));
    specification_.values.insert_or_assign(std::string(keyword.key), isExact == switchesOn);
  }

  /// Warns of numbers that are dropped or left at their defaults.
  void warnOfNumbers(const PublishedLine& line, const PublishedKeyword& keyword, const std::vector<double>& numbers,
                     bool areWhole) {
    std::string used;
    for (std::size_t i = 0; i < std::min(numbers.size(), keyword.count); ++i) {
      used += (i == 0 ? "" : " ") + numberText(numbers[i]);
    }
    const bool areMissing = numbers.size() < keyword.count;
    std::string message = "'" + line.keyword + "'";
    if (!areWhole || !areMissing) {
      message += ": '" + line.value + "' is read as '" + used + "'" + (areMissing ? "; it" : "");
    }
    if (areMissing) {
      message += " has " + std::to_string(numbers.size()) + " of " + std::to_string(keyword.count) +
                 (keyword.count == 1 ? " number: the default counts" : " numbers: the others keep their defaults");
    }
    warn(valueLocation(line), std::move(message),
         "expected " + (keyword.count == 1 ? "a number" : std::to_string(keyword.count) + " numbers"));
  }

  void setNumbers(const PublishedLine& line, const PublishedKeyword& keyword, std::vector<double> numbers) {
    const std::string name(keyword.key);
    const bool isFirst = specification_.locations.insert_or_assign(name, valueLocation(line)).second;
    const auto key = std::find_if(process_.keys.begin(), process_.keys.end(),
                                  [&](const ConfigurationKey& k) { return k.name == keyword.key; });
    ConfigurationValue& value = specification_.values.try_emplace(name, defaultOf(*key)).first->second;
    if (key->isWhole || key->kind == KeyKind::Integer) {
      std::transform(numbers.begin(), numbers.end(), numbers.begin(), [](double n) { return std::trunc(n); });
    }
    numbers.resize(std::min(numbers.size(), keyword.count));
    if (keyword.kind == PublishedKind::Row) {
      // the first row replaces the default
      auto& rows = std::get<ConfigurationRows>(value);
      rows.resize(isFirst ? 0 : rows.size());
      rows.push_back(std::move(numbers));
    } else if (keyword.kind == PublishedKind::Numbers) {
      auto& all = std::get<std::vector<double>>(value);
      all.resize(keyword.count);
      std::copy(numbers.begin(), numbers.end(), all.begin());
    } else if (!numbers.empty()) {
      value = numbers.front();
    }
  }

  static ConfigurationValue defaultOf(const ConfigurationKey& key) {
    if (key.kind == KeyKind::Rows) {
      return ConfigurationRows{};
    }
    if (key.kind == KeyKind::Numbers) {
      return std::vector<double>(key.defaultNumbers.begin(), key.defaultNumbers.end());
    }
    return key.defaultNumber;
  }

  void readOwn(const std::string& file, const PublishedLine& line, const PublishedKeyword& keyword) {
    ConfigurationValues read;
    std::string dropped;
    const std::string problem = keyword.read(PublishedLineInput{line, lines_, before_, file, files_, read, dropped});
    if (!dropped.empty()) {
      warn(valueLocation(line), "'" + line.keyword + "' " + dropped, {});
    }
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
  std::span<const PublishedLine> lines_;   // of the file that is read
  std::span<const PublishedLine> before_;  // those above the present one
};

}  // namespace

Specification readSpecification(const ProcessEntry& process, const std::string& file, std::string_view text,
                                core::FileProvider& files, std::vector<core::Diagnostic>& warnings,
                                std::vector<core::Diagnostic>& errors) {
  return SpecificationReader(process, files, warnings, errors).read(file, text);
}

}  // namespace espalier::environment
