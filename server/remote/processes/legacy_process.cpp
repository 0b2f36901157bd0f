#include "server/remote/processes/legacy_process.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include "engine/core/number_text.h"
#include "environment/base/published_text.h"
#include "environment/published/environment_file.h"
#include "server/remote/processes/line_channel.h"

namespace espalier::server {
namespace {

using Clock = std::chrono::steady_clock;
using turtle::EnvironmentError;

// of the word after `Control:`
constexpr int kFirstChunk = 1;
constexpr int kLastChunk = 4;
constexpr int kExit = 8;
// the published programs read no more of a line, and of a module
constexpr std::size_t kLongestLine = 2000;
constexpr std::size_t kMostParameters = 20;
constexpr std::size_t kLongestAnswer = 1'000'000;
constexpr std::string_view kReady = "\x01";

bool isExecutable(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

std::string folderOfFile(const std::string& file) {
  return std::filesystem::path(file).parent_path().string();
}

/// A word as the shell reads it unchanged.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) {
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return text + "'";
}

std::string fileNameOf(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// A file in the folder of temporary files, removed with its owner.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::string path) : path_(std::move(path)) {}
  TemporaryFile(TemporaryFile&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile() {
    if (!path_.empty()) {
      ::unlink(path_.c_str());
    }
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Writes an `.e` file; nothing when that fails.
std::optional<TemporaryFile> writeTemporary(const std::string& text) {
  std::error_code error;
  // the program runs in another folder
  const std::filesystem::path folder = std::filesystem::absolute(std::filesystem::temp_directory_path(error), error);
  std::string path = (folder / "espalier-XXXXXX.e").string();
  const Descriptor file(::mkstemps(path.data(), 2));
  if (file.number() < 0) {
    return std::nullopt;
  }
  TemporaryFile result(path);
  const bool isWritten = ::write(file.number(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  return isWritten ? std::optional(std::move(result)) : std::nullopt;
}

/// The command of a program, with the files that it needs while it runs.
struct ProgramCommand {
  std::string text;  // cd FOLDER && exec PROGRAM -e FILE ARGUMENTS
  std::vector<TemporaryFile> files;
};

/// The command of `words`. A program reads the `.e` file behind `-e`, too, and fails when that names another
/// communication type than pipes. It then gets a copy that names pipes. A sentence when a copy cannot be written.
tl::expected<ProgramCommand, std::string> commandOf(std::vector<std::string> words, const std::string& fieldFile,
                                                    core::FileProvider& files) {
  const std::filesystem::path folder = std::filesystem::path(fieldFile).parent_path();
  if (words.size() < 2 || words[1] != "-e") {
    words.insert(words.begin() + 1, {"-e", fileNameOf(fieldFile)});
  }
  ProgramCommand command;
  for (std::size_t i = 1; i + 1 < words.size(); ++i) {
    const auto text = words[i] == "-e" ? files.read(environment::besideFile(fieldFile, words[i + 1])) : std::nullopt;
    const auto forPipes = text ? environment::textForPipes(*text) : std::nullopt;
    if (forPipes) {
      auto copy = writeTemporary(*forPipes);
      if (!copy) {
        return tl::unexpected("cannot write a copy of '" + words[i + 1] +
                              "' for pipes: check that the folder of temporary files can be written, or write "
                              "'communication type: pipes' in the file");
      }
      words[i + 1] = copy->path();
      command.files.push_back(std::move(*copy));
    }
  }
  command.text = (folder.empty() ? std::string() : "cd " + quoted(folder.string()) + " && ") + "exec";
  for (const std::string& word : words) {
    command.text += " " + quoted(word);
  }
  return command;
}

/// One number as `%g` prints it.
void appendNumber(std::string& text, double value) {
  char printed[32];
  const int length = std::snprintf(printed, sizeof(printed), "%g", value);
  text.append(printed, static_cast<std::size_t>(length));
}

void appendModule(std::string& text, std::string_view name, std::span<const double> parameters) {
  text += name;
  if (!parameters.empty()) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      text += i == 0 ? '(' : ',';
      appendNumber(text, parameters[i]);
    }
    text += ')';
  }
}

/// A line of the turtle, by a format that readEnvironmentFile checked: conversions of real numbers only, at most three.
/// The published library rounds the numbers to 32-bit floats before it prints them.
void appendTurtleLine(std::string& text, const std::string& format, double x, double y, double z) {
  char printed[4000];
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  const auto rounded = [](double value) { return static_cast<double>(static_cast<float>(value)); };
  const int length = std::snprintf(printed, sizeof(printed), format.c_str(), rounded(x), rounded(y), rounded(z));
#pragma GCC diagnostic pop
  text.append(printed, static_cast<std::size_t>(std::clamp<int>(length, 0, sizeof(printed) - 1)));
  text += '\n';
}

class LegacyProcess final : public turtle::EnvironmentProcess {
 public:
  LegacyProcess(environment::EnvironmentFile field, ProgramCommand command, std::chrono::milliseconds stepTimeout)
      : field_(std::move(field)), command_(std::move(command)), stepTimeout_(stepTimeout) {}

  ~LegacyProcess() override { sayGoodbye(); }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = field_.program;
    description.summary = "The published program '" + field_.program + "', in a process of its own.";
    description.needs = {.position = !field_.printed[0].empty(),
                         .heading = !field_.printed[1].empty(),
                         .left = !field_.printed[2].empty(),
                         .up = !field_.printed[3].empty(),
                         .width = !field_.printed[4].empty(),
                         .scale = !field_.printed[5].empty(),
                         .parameters = true,
                         .following = field_.formats.isFollowingSent};
    description.isStateful = true;
    return description;
  }

  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    symbols_ = context.symbols;
    sayGoodbye();
    hasAnswered_ = false;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    if (queries.size() == 0) {
      return std::nullopt;  // without a query nothing is transmitted
    }
    if (child_ == nullptr) {
      if (auto error = start()) {
        return error;
      }
    }
    deadline_ = Clock::now() + stepTimeout_;
    auto error = exchange(queries, replies);
    if (error) {
      stop();
    } else {
      hasAnswered_ = true;
    }
    return error;
  }

  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t) override { return std::nullopt; }

 private:
  [[nodiscard]] std::optional<EnvironmentError> start() {
    auto started = ChildProcess::start(command_.text);
    if (!started) {
      return EnvironmentError{"environment program " + started.error(), false};
    }
    child_ = std::move(*started);
    channel_ = std::make_unique<LineChannel>(std::move(child_->input), std::move(child_->output), kLongestAnswer);
    isFirstLine_ = true;
    return std::nullopt;
  }

  void stop() {
    channel_.reset();
    child_.reset();
  }

  /// Tells the program to end, and gives it the time that ChildProcess gives.
  void sayGoodbye() {
    if (channel_ != nullptr) {
      const Deadline end = Clock::now() + std::chrono::seconds(1);
      std::string line;
      (void)channel_->write(controlLine(kExit, lastStep_), end);
      // it confirms with one byte and ends
      while (channel_->readLine(line, end) == LineChannel::Status::Done) {
      }
    }
    stop();
  }

  static std::string controlLine(int flags, std::uint64_t step) {
    return "Control: " + std::to_string(flags) + " " + std::to_string(step) + "\n";
  }

  /// Published programs know modules that a homomorphism made by the number 1.
  static std::uint64_t identifierOf(const turtle::QueryBatch& queries, std::size_t query) {
    if (!queries.isTransient.empty() && queries.isTransient[query] != 0) {
      return 1;
    }
    return query == 0 ? 0 : query + 1;
  }

  [[nodiscard]] std::optional<EnvironmentError> exchange(const turtle::QueryBatch& queries,
                                                         turtle::ReplyBatch& replies) {
    lastStep_ = queries.step;
    const std::size_t count = queries.size();
    std::string chunk;
    for (std::size_t first = 0; first < count; first += field_.chunkModules) {
      const std::size_t end = std::min(count, first + field_.chunkModules);
      chunk.clear();
      for (std::size_t query = first; query < end; ++query) {
        if (auto error = appendRecord(chunk, queries, query)) {
          return error;
        }
      }
      const bool isLast = end == count;
      chunk += controlLine((first == 0 ? kFirstChunk : 0) | (isLast ? kLastChunk : 0), isLast ? queries.step : 0);
      if (auto error = write(chunk, queries.step)) {
        return error;
      }
      // the program answers every chunk with one; after the last its chunks follow one another up to its own last.
      // A line sent between them would make one chunk too many
      int flags = 0;
      do {
        if (auto error = readChunk(queries, replies, flags)) {
          return error;
        }
      } while (isLast && (flags & kLastChunk) == 0);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> appendRecord(std::string& text, const turtle::QueryBatch& queries,
                                                             std::size_t query) const {
    const std::size_t begin = text.size();
    const auto parameters = queries.parametersOf(query);
    text += std::to_string(identifierOf(queries, query)) + " ";
    appendModule(text, symbols_[queries.symbol[query]].substr(0, 4), parameters);
    if (field_.formats.isFollowingSent && !queries.following.empty() && queries.following[query] != core::kNoSymbol) {
      // the two-character names ~x and @x have both characters, other names at most four
      const char pair = queries.followingPair.empty() ? '\0' : queries.followingPair[query];
      const std::string& name = symbols_[queries.following[query]];
      appendModule(text, pair == '\0' ? name.substr(0, 4) : std::string(1, pair) + name.substr(0, 1),
                   queries.followingParametersOf(query));
    }
    text += '\n';
    if (parameters.size() > kMostParameters || text.size() - begin > kLongestLine) {
      return failure(queries.step, "cannot be sent a module of " + std::to_string(parameters.size()) + " parameters (" +
                                       std::to_string(text.size() - begin) +
                                       " characters): the published programs read at most " +
                                       std::to_string(kMostParameters) + " and lines of " +
                                       std::to_string(kLongestLine) + ". Give the communication module fewer.");
    }
    const std::array<const std::vector<core::Vec3>*, 4> vectors{&queries.position, &queries.heading, &queries.left,
                                                                &queries.up};
    for (std::size_t item = 0; item < vectors.size(); ++item) {
      if (!field_.printed[item].empty()) {
        const core::Vec3& v = (*vectors[item])[query];
        appendTurtleLine(text, field_.printed[item], v.x, v.y, v.z);
      }
    }
    if (!field_.printed[4].empty()) {
      appendTurtleLine(text, field_.printed[4], queries.width[query], 0.0, 0.0);
    }
    if (!field_.printed[5].empty()) {
      appendTurtleLine(text, field_.printed[5], queries.scale[query], 0.0, 0.0);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> write(std::string_view bytes, std::uint64_t step) {
    const LineChannel::Status status = channel_->write(bytes, deadline_);
    return status == LineChannel::Status::Done ? std::nullopt : std::optional(failureOf(status, step));
  }

  /// Reads answers up to the program's `Control:` line, whose flags are returned.
  [[nodiscard]] std::optional<EnvironmentError> readChunk(const turtle::QueryBatch& queries,
                                                          turtle::ReplyBatch& replies, int& flags) {
    std::string line;
    while (true) {
      // a program that never stops writing is late, too
      const LineChannel::Status status =
          Clock::now() > deadline_ ? LineChannel::Status::Timeout : channel_->readLine(line, deadline_);
      if (status != LineChannel::Status::Done) {
        return failureOf(status, queries.step);
      }
      std::string_view text = line;
      if (isFirstLine_) {
        // the byte with which it says that it is ready
        text.remove_prefix(text.starts_with(kReady) ? 1 : 0);
        isFirstLine_ = false;
      }
      if (text.ends_with('\r')) {
        text.remove_suffix(1);
      }
      if (text.empty()) {
        continue;
      }
      if (text.starts_with("Control:")) {
        const std::vector<std::string> words = environment::readPublishedWords(text.substr(8));
        const auto number = words.empty() ? std::nullopt : core::parseNumber(words[0]);
        if (number && *number >= 0.0 && *number < 256.0) {
          flags = static_cast<int>(*number);
          return std::nullopt;
        }
      }
      if (text.starts_with("Control:") || !applyAnswer(text, queries, replies)) {
        return failure(queries.step,
                       "answered '" + std::string(text.substr(0, 80)) +
                           "', which is no answer: expected '<id> E(value,,value)' for a module that was "
                           "sent, or 'Control: <flags>'. What it prints for people belongs on its standard "
                           "error.");
      }
    }
  }

  /// `<id> E(v1,,v3)`: empty values keep what was sent. False when it is not of this form.
  [[nodiscard]] static bool applyAnswer(std::string_view text, const turtle::QueryBatch& queries,
                                        turtle::ReplyBatch& replies) {
    const std::size_t blank = text.find(' ');
    const std::size_t open = text.find('(');
    if (blank == std::string_view::npos) {
      return false;
    }
    const auto identifier = core::parseNumber(text.substr(0, blank));
    if (!identifier || *identifier < 0.0 ||
        *identifier != static_cast<double>(static_cast<std::uint64_t>(*identifier))) {
      return false;
    }
    const auto id = static_cast<std::uint64_t>(*identifier);
    if (id == 1) {
      return true;  // of a module that a homomorphism made: discarded
    }
    const std::size_t query = id == 0 ? 0 : static_cast<std::size_t>(id - 1);
    if (query >= queries.size()) {
      return false;
    }
    if (open == std::string_view::npos) {
      return true;  // a module without parameters: nothing is set
    }
    const std::size_t close = text.rfind(')');
    if (close == std::string_view::npos || close < open) {
      return false;
    }
    std::string_view values = text.substr(open + 1, close - open - 1);
    for (std::size_t k = 0; !values.empty() || k == 0; ++k) {
      const std::size_t comma = std::min(values.find(','), values.size());
      std::string_view value = values.substr(0, comma);
      value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
      value = value.substr(0, value.find_last_not_of(' ') + 1);
      if (!value.empty()) {
        const auto number = core::parseNumber(value);
        if (!number || !(*number - *number == 0.0)) {
          return false;
        }
        replies.set(queries, query, k, *number);
      }
      if (comma == values.size()) {
        break;
      }
      values.remove_prefix(comma + 1);
    }
    return true;
  }

  [[nodiscard]] EnvironmentError failureOf(LineChannel::Status status, std::uint64_t step) {
    if (status == LineChannel::Status::Timeout) {
      return failure(step,
                     "did not answer within " + std::to_string(stepTimeout_.count()) +
                         " ms: expected '<id> E(value,,value)' for each module, and 'Control: 4' behind the last.");
    }
    if (status == LineChannel::Status::Overflow) {
      return failure(step, "sent a line of more than " + std::to_string(kLongestAnswer) + " bytes.");
    }
    const std::string fate = child_->process.fate();
    return failure(step, (fate.empty() ? "closed its output" : fate) +
                             " before it had answered. Run it by hand to see why: " + command_.text);
  }

  [[nodiscard]] EnvironmentError failure(std::uint64_t step, const std::string& what) const {
    std::string text = "environment program '" + field_.program + "' " + what;
    if (hasAnswered_) {
      text += " If it remembers earlier steps, run from the start: the next step starts it anew at step " +
              std::to_string(step) + ".";
    }
    return {text, true};
  }

  environment::EnvironmentFile field_;
  ProgramCommand command_;
  std::chrono::milliseconds stepTimeout_;
  std::vector<std::string> symbols_;
  std::unique_ptr<ChildProcess::Started> child_;  // null: not running
  std::unique_ptr<LineChannel> channel_;          // to it
  Deadline deadline_;
  std::uint64_t lastStep_ = 0;
  bool isFirstLine_ = true;   // of what the program writes
  bool hasAnswered_ = false;  // a step since open()
};

}  // namespace

bool isProgramIn(const std::string& program, const std::string& folder) {
  namespace fs = std::filesystem;
  return isExecutable(fs::path(program).is_absolute() ? fs::path(program) : fs::path(folder) / program);
}

std::string findExecutable(const std::string& program, const std::string& folder) {
  namespace fs = std::filesystem;
  if (isProgramIn(program, folder)) {
    return (fs::path(program).is_absolute() ? fs::path(program) : fs::path(folder) / program).string();
  }
  if (program.find('/') != std::string::npos) {
    return {};
  }
  const char* const variable = std::getenv("PATH");
  std::string_view paths = variable == nullptr ? "" : variable;
  while (!paths.empty()) {
    const std::size_t colon = std::min(paths.find(':'), paths.size());
    if (const fs::path path = fs::path(paths.substr(0, colon)) / program; colon > 0 && isExecutable(path)) {
      return path.string();
    }
    paths.remove_prefix(std::min(paths.size(), colon + 1));
  }
  return {};
}

environment::ProcessOrErrors makeLegacyProcess(const std::string& fieldFile, core::FileProvider& files,
                                               const LegacyProcessOptions& options,
                                               std::vector<core::Diagnostic>& warnings) {
  const auto text = files.read(fieldFile);
  if (!text) {
    return tl::unexpected(std::vector{core::Diagnostic{core::Severity::Error,
                                                       "cannot read the environment file '" + fieldFile + "'",
                                                       {},
                                                       "check the name and that the file can be read"}});
  }
  std::vector<core::Diagnostic> errors;
  environment::EnvironmentFile field = environment::readEnvironmentFile(fieldFile, *text, warnings, errors);
  if (!options.executable.empty()) {
    field.command = environment::readPublishedWords(options.executable);
    field.program = field.command.empty() ? std::string() : fileNameOf(field.command.front());
  }
  if (field.command.empty() && errors.empty()) {
    errors.push_back(environment::missingProgram(fieldFile));
  }
  for (std::size_t item = 0; item < field.printed.size(); ++item) {
    const auto all = environment::TurtleFormat::parse(field.printed[item], SIZE_MAX);
    if (all && all->conversionCount() > (item < 4 ? 3U : 1U)) {
      errors.push_back({core::Severity::Error,
                        "the format '" + field.printed[item] + "' prints more numbers than there are", field.executable,
                        "at most three for a vector, one for line width and scale factor"});
    }
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  // a program in the folder needs no path
  std::string& program = field.command.front();
  if (program.find('/') == std::string::npos && isProgramIn(program, folderOfFile(fieldFile))) {
    program = "./" + program;
  }
  auto command = commandOf(field.command, fieldFile, files);
  if (!command) {
    return tl::unexpected(std::vector{core::Diagnostic{core::Severity::Error, command.error(), field.executable, {}}});
  }
  return std::make_unique<LegacyProcess>(std::move(field), std::move(*command), options.stepTimeout);
}

}  // namespace espalier::server
