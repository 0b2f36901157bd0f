#pragma once

#include <cstdint>
#include <string>

namespace espalier::command {

/// One line of progress: a bar of `width` characters, the step, and the modules of the strings.
[[nodiscard]] std::string progressLine(std::uint64_t completedSteps, std::uint64_t totalSteps,
                                       std::uint64_t moduleCount, std::size_t width);

/// One line of progress of a file that is written: a bar, the file, and how much of it is done.
[[nodiscard]] std::string writingLine(const std::string& file, std::uint64_t done, std::uint64_t total,
                                      std::size_t width);

/// A progress bar on standard error, redrawn in place. Shows nothing when standard error is not a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool isWanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::uint64_t completedSteps, std::uint64_t totalSteps, std::uint64_t moduleCount);
  /// The same for a file that is being written; redrawn only when the percentage changes.
  void showWriting(const std::string& file, std::uint64_t done, std::uint64_t total);
  /// A line of the caller's.
  void showLine(const std::string& line);
  /// Erases the bar, so that a message can be written in its place.
  void clear();

 private:
  void draw(const std::string& line);

  std::uint64_t percentage_ = 101;  // shown of a file; 101: none
  bool isShown_ = false;
  bool isOnTerminal_ = false;
};

}  // namespace espalier::command
