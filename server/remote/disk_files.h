#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"
#include "server/remote/partial_file.h"

namespace espalier::server {

/// Files of the local disk, names relative to the working directory. A file above `maximumBytes` is not read.
class DiskFileProvider final : public core::FileProvider {
 public:
  explicit DiskFileProvider(std::size_t maximumBytes = 256'000'000) : maximumBytes_(maximumBytes) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override;
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override;

 private:
  std::size_t maximumBytes_;
};

/// A file that is written piece by piece and appears under its name only when it is complete. It writes a temporary
/// file in the same folder and renames it. The name may be a link, which stays; a file that was there gives its
/// permissions to the new one. A device such as /dev/stdout is written directly. A file that is never committed leaves
/// nothing behind (PartialFile).
class AtomicFile final : public core::ByteSink {
 public:
  explicit AtomicFile(std::string name);
  ~AtomicFile() override;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// After a failure nothing more is written; commit() reports it.
  void write(std::string_view bytes) override;
  /// Writes the buffered rest and closes the file. A caller that writes several files finishes all before it commits
  /// one. Returns an error sentence with a remedy, or nothing.
  [[nodiscard]] std::optional<std::string> finish();
  /// Finishes the file and puts it in its place. An error sentence, or nothing.
  [[nodiscard]] std::optional<std::string> commit();
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Whether it will be renamed into its place: not a device or the like.
  [[nodiscard]] bool isRenamed() const { return temporary_.has_value(); }

 private:
  std::string name_;
  std::string place_;                     // behind all links
  std::optional<PartialFile> temporary_;  // none: written directly, or committed
  int descriptor_ = -1;
  int failure_ = 0;  // errno of the first failure
  std::string buffered_;

  void flush();
  void put(std::string_view rest);
  [[nodiscard]] std::optional<std::string> problem() const;
};

/// Writes a file so that a reader sees the old content or the new, never a part: temporary file beside it, then rename.
/// Returns an error sentence, or nothing on success.
[[nodiscard]] std::optional<std::string> writeFileAtomically(const std::string& name, std::string_view content);

}  // namespace espalier::server
