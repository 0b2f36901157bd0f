#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "protocol/errors.h"
#include "protocol/messages.h"

namespace espalier::server {

/// A model on the server's disk as it is now.
struct SavedModel {
  std::map<std::string, std::string> files;  // bytes by name
  std::string revision;                      // another one when a file has changed
};

/// The models that controllers keep on the server's disk: one folder (`espalier serve --models FOLDER`), in it a folder
/// of plain files for each model. People may change them with other programs too. No name from the wire leads out of
/// the folder, and links in it are not followed. Thread-safe.
class SavedModels {
 public:
  /// `folder` is empty when the server keeps no models. `mostBytes` bounds all of them together; 0: no bound.
  SavedModels(std::string folder, std::uint64_t mostBytes) : folder_(std::move(folder)), mostBytes_(mostBytes) {}

  /// Another bound from now on. Models that are there stay.
  void setMostBytes(std::uint64_t mostBytes) { mostBytes_ = mostBytes; }
  [[nodiscard]] bool isOn() const { return !folder_.empty(); }
  /// Names of the models, sorted.
  [[nodiscard]] std::vector<std::string> names() const;
  /// The files of a model. Error NotFound.
  [[nodiscard]] protocol::Expected<SavedModel> read(const std::string& name) const;
  /// Writes the files of a model, each whole, removes those of `params.remove`, and gives the new revision. Other files
  /// that the model has stay.
  /// Errors: InvalidParams for a name; ModelChanged unless `params.revision` is the present one (empty: the model must
  /// be new); Limit; Storage when the disk refuses.
  [[nodiscard]] protocol::Expected<std::string> save(const protocol::SaveModelParams& params);

 private:
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] bool hasModel(const std::string& name) const;

  std::string folder_;
  std::atomic<std::uint64_t> mostBytes_;
  mutable std::mutex mutex_;  // one save at a time, and no reading of half of it
};

/// Why a text cannot be the name of a saved model or of a file in it; empty: it can.
[[nodiscard]] std::string problemOfSavedName(const std::string& name);

}  // namespace espalier::server
