#pragma once

#include <string>
#include <vector>

#include "clients/espalier/result.h"
#include "server/server.h"

namespace espalier::command {

/// The files of the built handbook (`./dev docs`), in memory: the server gives them to browsers below /handbook, and no
/// path of a request reaches the disk.
class HandbookFiles {
 public:
  /// Reads a folder. An error sentence when it has no index.html.
  [[nodiscard]] static Result<HandbookFiles> read(const std::string& folder);

  /// Adds a page for each file, and /handbook, which leads to /handbook/. The pages refer to this object.
  void addTo(std::vector<server::WebFile>& pages) const;

 private:
  struct File {
    std::string path;  // below the folder, with /
    std::string content;
  };
  std::vector<File> files_;
};

/// The Content-Security-Policy that a page of the handbook has in its head: its own scripts by their hashes. Empty when
/// it has none.
[[nodiscard]] std::string policyInPage(const std::string& html);

}  // namespace espalier::command
