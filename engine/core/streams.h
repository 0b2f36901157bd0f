#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::core {

/// Gives the engine its files. The engine itself opens none.
class FileProvider {
 public:
  virtual ~FileProvider() = default;
  /// The whole content of a file, or nothing when it cannot be read. `name` is as the model or the user wrote it;
  /// names in a model are joined to the folder of the file that names them before the call.
  [[nodiscard]] virtual std::optional<std::string> read(const std::string& name) = 0;
  /// The same for a file that a model opens (fopen). Nothing when the file lies outside `folder`, for example behind a
  /// symbolic link. `name` begins with `folder`; an empty folder is the working folder.
  [[nodiscard]] virtual std::optional<std::string> readInside(const std::string& folder, const std::string& name) {
    static_cast<void>(folder);
    return read(name);
  }
};

/// Takes the files that models write (fopen, fprintf).
class FileWriter {
 public:
  virtual ~FileWriter() = default;
  /// Adds bytes to the end of a file, or replaces its whole content by them. `name` is relative to the model's folder
  /// and has no `..`. Returns a sentence that says why it failed, or nothing.
  [[nodiscard]] virtual std::optional<std::string> write(const std::string& name, bool replaces,
                                                         std::string_view bytes) = 0;
};

/// Files in memory, by name: sources from a client, snapshots, tests.
class MemoryFileProvider final : public FileProvider {
 public:
  MemoryFileProvider() = default;
  explicit MemoryFileProvider(std::map<std::string, std::string> files) : files_(std::move(files)) {}
  void add(std::string name, std::string content) { files_.insert_or_assign(std::move(name), std::move(content)); }
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    const auto found = files_.find(name);
    return found == files_.end() ? std::nullopt : std::optional<std::string>(found->second);
  }

 private:
  std::map<std::string, std::string> files_;
};

/// Reads through another provider and keeps a copy of every file.
class RecordingFileProvider final : public FileProvider {
 public:
  /// `files` must outlive it.
  explicit RecordingFileProvider(FileProvider& files) : files_(&files) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    std::optional<std::string> text = files_->read(name);
    if (text) {
      recorded_.emplace_back(name, *text);
    }
    return text;
  }
  /// Names and texts, in the order of reading.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> take() { return std::move(recorded_); }

 private:
  FileProvider* files_;
  std::vector<std::pair<std::string, std::string>> recorded_;
};

/// Takes the engine's output.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual void write(std::string_view bytes) = 0;
};

/// A sink that keeps everything in a string.
class StringSink final : public ByteSink {
 public:
  void write(std::string_view bytes) override { text_.append(bytes); }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

enum class MessageKind : std::uint8_t { Printf, Warning };

/// Receives the printf output of a model, newlines included, and the warnings of a run. May be empty.
using MessageSink = std::function<void(MessageKind, std::string_view)>;

}  // namespace espalier::core
