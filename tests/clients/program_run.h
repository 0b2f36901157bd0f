#pragma once

#include <string>

namespace espalier::test {

/// What a run of the program left.
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
