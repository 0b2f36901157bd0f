#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "engine/files/colour_files.h"
#include "engine/language/compiler.h"
#include "protocol/errors.h"
#include "protocol/messages.h"
#include "server/store/store.h"

namespace espalier::server {

/// A compiled model. `program` is null when the model has errors.
struct CompiledModel {
  language::CompileResult result;
  files::Palette palette{};                          // of its folder; empty: none
  std::optional<std::uint64_t> lastStep{};           // that its folder asks for; nothing: the derivation length
  std::map<std::string, std::string> colourFiles{};  // behind the palette, by ColourFile as text (for the disk)
  int colourBase = 1;
  std::string environmentJson{};  // of a model that brings one; empty otherwise
};

/// Compiles models from the wire or the gallery, and keeps those of model.load. Thread-safe.
class ModelStore {
 public:
  ModelStore(std::string galleryFolder, Store& store) : galleryFolder_(std::move(galleryFolder)), store_(&store) {}

  /// Finds the models that were kept before the server was started. They are compiled when they are used.
  void loadKept();

  /// Reads and compiles. An error when the reference itself is wrong (no such gallery model). A model from the wire can
  /// read only the files that came with it.
  [[nodiscard]] protocol::Expected<CompiledModel> compile(const protocol::ModelParams& params,
                                                          const core::Limits& limits) const;

  /// Keeps a program, on disk when there is a data folder, and returns its identifier. An error when there are
  /// kMaximumLoaded already.
  [[nodiscard]] protocol::Expected<std::string> keep(const CompiledModel& model);

 private:
  static constexpr std::size_t kMaximumLoaded = 1000;

  [[nodiscard]] protocol::Expected<CompiledModel> findLoaded(const std::string& name, const core::Limits& limits) const;
  [[nodiscard]] protocol::Expected<CompiledModel> compileGallery(const std::string& name, const std::string& file,
                                                                 language::CompileInput input) const;

  std::string galleryFolder_;
  Store* store_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, CompiledModel> loaded_;
  mutable std::map<std::string, std::string> kept_;  // texts of models from disk that are not compiled yet
  std::uint64_t lastNumber_ = 0;
};

}  // namespace espalier::server
