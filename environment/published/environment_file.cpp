#include "environment/published/environment_file.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "environment/base/published_text.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

/// Reads an `.e` file.
class EnvironmentFileReader {
 public:
  EnvironmentFileReader(std::vector<Diagnostic>& warnings, std::vector<Diagnostic>& errors)
      : warnings_(warnings), errors_(errors) {}

  EnvironmentFile read(const std::string& file, std::string_view text) {
    for (const PublishedLine& line : readPublishedLines(file, text, warnings_)) {
      readLine(line);
    }
    return std::move(file_);
  }

 private:
  void readLine(const PublishedLine& line) {
    static const std::vector<std::string_view> kKeywords{
        "executable",       "communication type",  "turtle position",   "turtle heading",
        "turtle left",      "turtle up",           "turtle line width", "turtle scale factor",
        "following module", "interpreted modules", "when interpret",    "verbose",
        "remote host",      "strings only",        "binary data"};
    const std::string& keyword = line.keyword;
    if (keyword == "executable") {
      readExecutable(line);
    } else if (keyword == "turtle position") {
      file_.formats.position = readFormat(line, 3, 0);
    } else if (keyword == "turtle heading") {
      file_.formats.heading = readFormat(line, 3, 1);
    } else if (keyword == "turtle left") {
      file_.formats.left = readFormat(line, 3, 2);
    } else if (keyword == "turtle up") {
      file_.formats.up = readFormat(line, 3, 3);
    } else if (keyword == "turtle line width") {
      file_.formats.width = readFormat(line, 1, 4);
    } else if (keyword == "turtle scale factor") {
      file_.formats.scale = readFormat(line, 1, 5);
    } else if (keyword == "following module") {
      file_.formats.isFollowingSent = line.value != "no";
      if (line.value != "no" && line.value != "yes") {
        warn(valueLocation(line), "'following module' is neither yes nor no: taken as yes", "write yes or no");
      }
    } else if (keyword == "interpreted modules" || keyword == "when interpret") {
      warn(line.location, "'" + keyword + "' is not used: no geometry is sent with a query", {});
    } else if (keyword == "remote host") {
      warn(line.location, "'remote host' is not used: the process runs inside Espalier",
           "an environment in another process is named as tcp://HOST:PORT or stdio:COMMAND");
    } else if (keyword == "communication type") {
      readChunk(line);
    } else if (std::find(kKeywords.begin(), kKeywords.end(), keyword) == kKeywords.end()) {
      warn(line.location, "unknown keyword '" + keyword + "' is ignored", core::suggestName(keyword, kKeywords));
    }
    // verbose, strings only and binary data concern the transport only: no effect
  }

  // `pipes 250`: modules in a chunk. A program is always started with pipes, so the other types are read like them
  void readChunk(const PublishedLine& line) {
    const std::vector<std::string> words = readPublishedWords(line.value);
    if (words.size() < 2) {
      return;
    }
    const std::vector<double> numbers = readPublishedNumbers(words[1]);
    if (numbers.size() != 1 || numbers[0] < 1.0 || numbers[0] > 1e9) {
      warn(valueLocation(line), "'communication type' takes the number of modules in a chunk, from 1 on",
           "taken as 100");
      return;
    }
    file_.chunkModules = static_cast<std::size_t>(numbers[0]);
  }

  void readExecutable(const PublishedLine& line) {
    const std::vector<std::string> words = readPublishedWords(line.value);
    if (words.empty()) {
      errors_.push_back({Severity::Error, "'executable' names no program", line.location,
                         "expected a line like 'executable: honda81 -e model.e model.spec'"});
      return;
    }
    std::string program = words[0].substr(words[0].find_last_of("/\\") + 1);
    if (program.size() > 4 && program.compare(program.size() - 4, 4, ".exe") == 0) {
      program.resize(program.size() - 4);
    }
    file_.program = program;
    file_.command = words;
    file_.executable = valueLocation(line);
    file_.executable.length = static_cast<std::uint32_t>(words[0].size());
    file_.specification.clear();
    file_.ignoredArguments.clear();
    for (std::size_t i = 1; i < words.size(); ++i) {
      static const std::vector<std::string_view> kOptions{"-e", "-k", "-ext", "-host", "-C"};
      if (std::find(kOptions.begin(), kOptions.end(), words[i]) != kOptions.end()) {
        ++i;  // its value
      } else if (words[i].front() == '-') {
        ignore("option '" + words[i] + "' of the program is ignored", {});
      } else if (file_.specification.empty()) {
        file_.specification = words[i];
      } else {
        ignore("argument '" + words[i] + "' of the program is ignored",
               "one specification file is read: " + file_.specification);
      }
    }
  }

  std::optional<TurtleFormat> readFormat(const PublishedLine& line, std::size_t count, std::size_t item) {
    // a program skips the characters before the first number, so the blanks behind the separator count, too
    const std::string written = line.location.lineText.substr(line.keyword.size() + 1);
    const auto format = TurtleFormat::parse(written, count);
    if (!format) {
      errors_.push_back({Severity::Error, "'" + line.keyword + "': " + format.error(), valueLocation(line), {}});
      return std::nullopt;
    }
    if (format->conversionCount() < count) {
      warn(valueLocation(line),
           "'" + line.keyword + "' sends " + std::to_string(format->conversionCount()) + " of " +
               std::to_string(count) + " numbers: the others arrive as 0",
           {});
    }
    file_.printed[item] = written;
    return *format;
  }

  void ignore(std::string message, std::string hint) {
    file_.ignoredArguments.push_back({Severity::Warning, std::move(message), file_.executable, std::move(hint)});
  }

  void warn(const SourceLocation& location, std::string message, std::string hint) {
    warnings_.push_back({Severity::Warning, std::move(message), location, std::move(hint)});
  }

  std::vector<Diagnostic>& warnings_;
  std::vector<Diagnostic>& errors_;
  EnvironmentFile file_;
};

}  // namespace

EnvironmentFile readEnvironmentFile(const std::string& file, std::string_view text,
                                    std::vector<core::Diagnostic>& warnings, std::vector<core::Diagnostic>& errors) {
  return EnvironmentFileReader(warnings, errors).read(file, text);
}

std::optional<std::string> textForPipes(std::string_view text) {
  std::string result;
  bool isChanged = false;
  while (!text.empty()) {
    const std::size_t newline = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, newline);
    const std::size_t separator = std::min(line.find_first_of("\t:"), line.size());
    const bool isType = separator < line.size() && line.substr(0, separator) == "communication type";
    const std::vector<std::string> words =
        isType ? readPublishedWords(line.substr(separator + 1)) : std::vector<std::string>{};
    if (isType && (words.empty() || words[0] != "pipes")) {
      isChanged = true;
      result += "communication type: pipes" + (words.size() > 1 ? " " + words[1] : std::string());
    } else {
      result += line;
    }
    result += newline < text.size() ? "\n" : "";
    text.remove_prefix(std::min(newline + 1, text.size()));
  }
  return isChanged ? std::optional(std::move(result)) : std::nullopt;
}

core::Diagnostic missingProgram(const std::string& file) {
  SourceLocation location;
  location.file = file;
  location.line = 1;
  location.column = 1;
  return {Severity::Error, "the environment file names no program", location,
          "expected a line like 'executable: honda81 -e " + file.substr(file.rfind('/') + 1) + " honda.spec'"};
}

}  // namespace espalier::environment
