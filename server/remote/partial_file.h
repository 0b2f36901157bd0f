#pragma once

#include <cstddef>
#include <string>

namespace espalier::server {

/// The name of a file that is being written and takes the name of the whole file when it is complete. A partial file
/// that is never completed is removed: by the destructor, and by a signal that ends the program
/// (removePartialFilesAtSignals). The owner opens and writes the file.
class PartialFile {
 public:
  explicit PartialFile(std::string name);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Renames the file to `whole`, in the same folder. 0, or the errno of the failure.
  [[nodiscard]] int complete(const std::string& whole);

 private:
  std::string name_;  // empty: completed
  std::size_t slot_;  // of the table that signal handlers read
};

/// From now on SIGINT, SIGTERM, SIGHUP and SIGPIPE remove the partial files of this process before they end it. A
/// signal that is ignored, as SIGHUP under nohup, stays ignored. For programs, not for libraries in other programs.
void removePartialFilesAtSignals();

/// The same for one signal, for a command that has handled it in its own way once.
void removePartialFilesAtSignal(int signal);

}  // namespace espalier::server
