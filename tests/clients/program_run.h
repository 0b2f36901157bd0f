#pragma once

#include <string>

namespace espalier::test {

/// Grows by one F a step until its query answers 2.
inline constexpr const char* kHeight =
    "Lsystem: 1\nderivation length: 3\nAxiom: A?E(0)\n"
    "A > ?E(h) : h < 2 --> FA\nA > ?E(h) : h >= 2 --> *\nendlsystem\n";

[[nodiscard]] inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The result of a run of the program.
struct ProgramRun {
  int status = -1;     // exit status; -1: it did not end by itself
  std::string output;  // standard output
  std::string errors;  // standard error
};

/// Runs the built program with arguments in the form of the shell, in the given working folder.
[[nodiscard]] ProgramRun runProgram(const std::string& arguments, const std::string& folder);

/// A folder for the files of one test, empty at the start and removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  void write(const std::string& name, const std::string& text) const;
  /// The content of a file; an empty text when there is none.
  [[nodiscard]] std::string read(const std::string& name) const;

 private:
  std::string path_;
};

}  // namespace espalier::test
