#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <variant>

#include "engine/language/compiler.h"
#include "protocol/errors.h"
#include "protocol/messages.h"

namespace espalier::server {

/// A model as it was asked for, compiled. `program` is null when it has errors.
struct CompiledModel {
  language::CompileResult result;
  std::string environmentJson;  // of a gallery model that brings one; empty otherwise
};

/// Compiles models from the wire or the gallery and keeps those that model.load named. Thread-safe.
class ModelStore {
 public:
  explicit ModelStore(std::string galleryFolder) : galleryFolder_(std::move(galleryFolder)) {}

  /// Reads and compiles; an error when the reference itself is wrong (no such gallery model). Files on the wire are the
  /// only files that such a model can read.
  [[nodiscard]] std::variant<CompiledModel, protocol::Error> compile(const protocol::ModelParams& params,
                                                                     const core::Limits& limits) const;

  /// Keeps a program and returns its identifier. At most kMaximumLoaded; then an error.
  [[nodiscard]] std::variant<std::string, protocol::Error> keep(const CompiledModel& model);

 private:
  static constexpr std::size_t kMaximumLoaded = 1000;

  [[nodiscard]] std::variant<CompiledModel, protocol::Error> compileGallery(const std::string& name,
                                                                            language::CompileInput input) const;

  std::string galleryFolder_;
  mutable std::mutex mutex_;
  std::map<std::string, CompiledModel> loaded_;
  std::uint64_t lastNumber_ = 0;
};

}  // namespace espalier::server
