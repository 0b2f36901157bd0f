#include "clients/espalier/output/movies.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <vector>

#include "clients/espalier/messages.h"

extern char** environ;

namespace espalier::command {

namespace fs = std::filesystem;

namespace {

std::string suffixOf(const std::string& file) {
  std::string suffix = fs::path(file).extension().string();
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return suffix;
}

// the arguments that choose the codec; even sizes, as most players want
std::vector<std::string> codecOf(const std::string& suffix) {
  if (suffix == ".gif") {
    return {"-filter_complex", "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a"};
  }
  std::vector<std::string> codec{"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p"};
  const std::vector<std::string> more =
      suffix == ".webm" ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "28"}
                        : std::vector<std::string>{"-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"};
  codec.insert(codec.end(), more.begin(), more.end());
  return codec;
}

}  // namespace

bool isMovieFile(const std::string& file) {
  const std::string suffix = suffixOf(file);
  return suffix == ".mp4" || suffix == ".webm" || suffix == ".gif";
}

Movie::~Movie() {
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    static_cast<void>(wait());
  }
}

int Movie::wait() {
  if (input_ >= 0) {
    ::close(input_);
    input_ = -1;
  }
  int status = 0;
  while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  return status;
}

std::optional<std::string> Movie::begin(const std::string& file, unsigned framesPerSecond) {
  file_ = file;
  const fs::path partial =
      fs::path(file).replace_filename("." + fs::path(file).stem().string() + "-partial" + suffixOf(file));
  partial_.emplace(partial.string());
  std::array<int, 2> pipe{-1, -1};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) {
    return "cannot start ffmpeg: " + std::string(std::strerror(errno));
  }
  std::vector<std::string> words{"ffmpeg",     "-y",   "-loglevel", "error",      "-f",
                                 "image2pipe", "-c:v", "png",       "-framerate", std::to_string(framesPerSecond),
                                 "-i",         "-"};
  const std::vector<std::string> codec = codecOf(suffixOf(file));
  words.insert(words.end(), codec.begin(), codec.end());
  words.push_back(partial.is_absolute() ? partial.string() : "./" + partial.string());
  std::vector<char*> arguments;
  std::ranges::transform(words, std::back_inserter(arguments), [](std::string& word) { return word.data(); });
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe[0], STDIN_FILENO);
  // results only on standard output
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  const int reason = ::posix_spawnp(&child_, "ffmpeg", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[0]);
  input_ = pipe[1];
  if (reason != 0) {
    ::close(input_);
    input_ = child_ = -1;
    return std::string("a movie is made by the program ffmpeg, which cannot be started (") + std::strerror(reason) +
           "): install it (apt install ffmpeg), or write pictures with -o frame.png";
  }
  // a write to a program that has ended fails instead of ending this one
  std::signal(SIGPIPE, SIG_IGN);
  return std::nullopt;
}

std::optional<std::string> Movie::add(std::string_view png) {
  while (!png.empty()) {
    const ssize_t written = ::write(input_, png.data(), png.size());
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written < 0) {
      return "ffmpeg ended before the last picture of '" + file_ + "': its message is above";
    }
    png.remove_prefix(static_cast<std::size_t>(written));
  }
  return std::nullopt;
}

std::optional<std::string> Movie::finish() {
  if (wait() != 0) {
    return "ffmpeg could not make '" + file_ + "': its message is above";
  }
  if (const int reason = partial_->complete(file_)) {
    return "cannot write '" + file_ + "': " + std::strerror(reason);
  }
  return std::nullopt;
}

bool Movies::begin(const std::vector<std::string>& files, unsigned framesPerSecond) {
  files_ = files;
  for (const std::string& file : files_) {
    if (const auto problem = movies_.emplace_back().begin(file, framesPerSecond)) {
      printError(*problem);
      return false;
    }
  }
  return true;
}

bool Movies::add(const simulation::Simulation& simulation, const OutputWriter& writer) {
  if (movies_.empty()) {
    return true;
  }
  const std::optional<std::string> picture = writer.picture(simulation);
  if (!picture) {
    return false;
  }
  for (Movie& movie : movies_) {
    if (const auto problem = movie.add(*picture)) {
      printError(*problem);
      return false;
    }
  }
  ++pictureCount_;
  return true;
}

bool Movies::finish(bool isQuiet) {
  for (std::size_t i = 0; i < movies_.size(); ++i) {
    if (const auto problem = movies_[i].finish()) {
      printError(*problem);
      return false;
    }
    if (!isQuiet) {
      printNote("wrote " + files_[i] + " (" + std::to_string(pictureCount_) + " pictures)");
    }
  }
  return true;
}

}  // namespace espalier::command
