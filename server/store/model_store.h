#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <variant>

#include "engine/language/compiler.h"
#include "protocol/errors.h"
#include "protocol/messages.h"
#include "server/store/store.h"

namespace espalier::server {

/// A model as it was asked for, compiled. `program` is null when it has errors.
struct CompiledModel {
  language::CompileResult result;
  std::string environmentJson;  // of a gallery model that brings one; empty otherwise
};

/// Compiles models from the wire or the gallery and keeps those that model.load named. Thread-safe.
class ModelStore {
 public:
  ModelStore(std::string galleryFolder, Store& store) : galleryFolder_(std::move(galleryFolder)), store_(&store) {}

  /// Models that were kept before the server was started are there again, and compiled when they are used.
  void loadKept();

  /// Reads and compiles; an error when the reference itself is wrong (no such gallery model). Files on the wire are the
  /// only files that such a model can read.
  [[nodiscard]] std::variant<CompiledModel, protocol::Error> compile(const protocol::ModelParams& params,
                                                                     const core::Limits& limits) const;

  /// Keeps a program, on disk when there is a data folder, and returns its identifier. At most kMaximumLoaded; then an
  /// error.
  [[nodiscard]] std::variant<std::string, protocol::Error> keep(const CompiledModel& model);

 private:
  static constexpr std::size_t kMaximumLoaded = 1000;

  [[nodiscard]] std::variant<CompiledModel, protocol::Error> findLoaded(const std::string& name,
                                                                        const core::Limits& limits) const;
  [[nodiscard]] std::variant<CompiledModel, protocol::Error> compileGallery(const std::string& name,
                                                                            const std::string& file,
                                                                            language::CompileInput input) const;

  std::string galleryFolder_;
  Store* store_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, CompiledModel> loaded_;
  mutable std::map<std::string, std::string> kept_;  // texts of models from disk that are not compiled yet
  std::uint64_t lastNumber_ = 0;
};

}  // namespace espalier::server
