#include "clients/espalier/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace espalier::command {

std::string progressLine(std::uint64_t completedSteps, std::uint64_t totalSteps, std::uint64_t moduleCount,
                         std::size_t width) {
  const double fraction =
      totalSteps == 0 ? 1.0 : std::min(1.0, static_cast<double>(completedSteps) / static_cast<double>(totalSteps));
  const auto filled = static_cast<std::size_t>(fraction * static_cast<double>(width));
  return "[" + std::string(filled, '#') + std::string(width - filled, ' ') + "] step " +
         std::to_string(completedSteps) + " of " + std::to_string(totalSteps) + ", " + std::to_string(moduleCount) +
         " modules";
}

ProgressBar::ProgressBar(bool isWanted) : isOnTerminal_(isWanted && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  clear();
}

void ProgressBar::show(std::uint64_t completedSteps, std::uint64_t totalSteps, std::uint64_t moduleCount) {
  if (!isOnTerminal_) {
    return;
  }
  // carriage return, line, erase to the end of the line
  std::fprintf(stderr, "\r%s\x1b[K", progressLine(completedSteps, totalSteps, moduleCount, 30).c_str());
  std::fflush(stderr);
  isShown_ = true;
}

void ProgressBar::clear() {
  if (isShown_) {
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
    isShown_ = false;
  }
}

}  // namespace espalier::command
