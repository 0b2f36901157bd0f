#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"

namespace espalier::server {

/// A text that an editor has open.
struct OpenDocument {
  std::string uri;
  std::string path;  // the name under which the engine reads it
  std::string text;
  std::int64_t version = 0;
};

/// The texts that an editor has open. For the engine they stand in for the files with their names.
class OpenDocuments final : public core::FileProvider {
 public:
  static constexpr std::size_t kMostDocuments = 200;
  static constexpr std::size_t kMostBytes = std::size_t{16} << 20U;

  /// `files` gives what is not open; it must outlive the object.
  explicit OpenDocuments(core::FileProvider& files) : files_(files) {}

  /// Opens or replaces a document. A sentence when a limit is reached.
  [[nodiscard]] std::optional<std::string> put(const std::string& uri, std::string text, std::int64_t version);
  void close(const std::string& uri) { documents_.erase(pathOf(uri)); }
  [[nodiscard]] const OpenDocument* find(const std::string& uri) const;
  [[nodiscard]] std::vector<const OpenDocument*> all() const;

  [[nodiscard]] std::optional<std::string> read(const std::string& name) override;
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override;

  /// `/models/tree.l` for `file:///models/tree.l`; any other URI stays as it is.
  [[nodiscard]] static std::string pathOf(const std::string& uri);
  /// The URI of an open document with this path, else that of the file.
  [[nodiscard]] std::string uriOf(const std::string& path) const;

 private:
  core::FileProvider& files_;
  std::map<std::string, OpenDocument> documents_;  // by path
};

}  // namespace espalier::server
