#include "clients/espalier/output/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace espalier::command {

namespace {

std::string barOf(std::uint64_t done, std::uint64_t total, std::size_t width) {
  const double fraction = total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(fraction * static_cast<double>(width));
  return "[" + std::string(filled, '#') + std::string(width - filled, ' ') + "] ";
}

std::uint64_t percentageOf(std::uint64_t done, std::uint64_t total) {
  return total == 0 ? 100 : std::min<std::uint64_t>(100, done * 100 / total);
}

}  // namespace

std::string writingLine(const std::string& file, std::uint64_t done, std::uint64_t total, std::size_t width) {
  return barOf(done, total, width) + "writing " + file + ", " + std::to_string(percentageOf(done, total)) + " %";
}

std::string progressLine(std::uint64_t completedSteps, std::uint64_t totalSteps, std::uint64_t moduleCount,
                         std::size_t width) {
  return barOf(completedSteps, totalSteps, width) + "step " + std::to_string(completedSteps) + " of " +
         std::to_string(totalSteps) + ", " + std::to_string(moduleCount) + " modules";
}

ProgressBar::ProgressBar(bool isWanted) : isOnTerminal_(isWanted && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  clear();
}

void ProgressBar::draw(const std::string& line) {
  // carriage return, line, erase to the end of the line
  std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
  std::fflush(stderr);
  isShown_ = true;
}

void ProgressBar::show(std::uint64_t completedSteps, std::uint64_t totalSteps, std::uint64_t moduleCount) {
  if (isOnTerminal_) {
    draw(progressLine(completedSteps, totalSteps, moduleCount, 30));
  }
}

void ProgressBar::showWriting(const std::string& file, std::uint64_t done, std::uint64_t total) {
  const std::uint64_t percentage = percentageOf(done, total);
  if (isOnTerminal_ && percentage != percentage_) {
    percentage_ = percentage;
    draw(writingLine(file, done, total, 30));
  }
}

void ProgressBar::showLine(const std::string& line) {
  if (isOnTerminal_) {
    draw(line);
  }
}

void ProgressBar::clear() {
  if (isShown_) {
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
    isShown_ = false;
  }
}

}  // namespace espalier::command
