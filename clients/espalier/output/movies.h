#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/output/outputs.h"
#include "engine/simulation/simulation.h"
#include "server/remote/partial_file.h"

namespace espalier::command {

/// Whether a file's name ends as that of a movie: .mp4, .webm or .gif.
[[nodiscard]] bool isMovieFile(const std::string& file);

/// A movie of pictures that the program ffmpeg makes. The file appears when it is complete.
class Movie {
 public:
  Movie() = default;
  ~Movie();
  Movie(const Movie&) = delete;
  Movie& operator=(const Movie&) = delete;

  /// Starts ffmpeg. A sentence when it cannot be started.
  [[nodiscard]] std::optional<std::string> begin(const std::string& file, unsigned framesPerSecond);
  /// Adds a picture: the bytes of a PNG file. All pictures of a movie have one size. A sentence when ffmpeg has ended.
  [[nodiscard]] std::optional<std::string> add(std::string_view png);
  /// Ends the movie. A sentence when ffmpeg could not make it.
  [[nodiscard]] std::optional<std::string> finish();

 private:
  [[nodiscard]] int wait();

  std::string file_;
  std::optional<server::PartialFile> partial_;  // the file while ffmpeg writes it, beside the other
  int input_ = -1;                              // ffmpeg's standard input
  int child_ = -1;                              // process; -1: none
};

/// The movies of a run. Errors are printed; a function returns false then.
class Movies {
 public:
  [[nodiscard]] bool begin(const std::vector<std::string>& files, unsigned framesPerSecond);
  /// Draws the present state once and adds it to all.
  [[nodiscard]] bool add(const simulation::Simulation& simulation, const OutputWriter& writer);
  /// Completes the files. Prints their names on standard error unless `isQuiet`.
  [[nodiscard]] bool finish(bool isQuiet);

 private:
  std::vector<std::string> files_;
  std::deque<Movie> movies_;  // of the files; they do not move
  std::uint64_t pictureCount_ = 0;
};

}  // namespace espalier::command
