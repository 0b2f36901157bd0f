#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/limits.h"
#include "engine/derivation/state/file_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The file functions of the language (fopen, fclose, fprintf, fscanf) on the FileState of one plant. A view, made for
/// one call. A handle is a number 1, 2, ...; 0 is no handle.
class ModelFiles {
 public:
  /// All must outlive the object. `canWrite`: the caller takes the written bytes.
  ModelFiles(const language::Program& program, FileState& state, const core::Limits& limits, bool canWrite)
      : program_(&program), state_(&state), limits_(&limits), canWrite_(canWrite) {}

  /// A handle, or the reason for the failure: a sentence without a full stop.
  [[nodiscard]] tl::expected<double, std::string> open(std::uint32_t file, const language::FileMode& mode);
  /// False: no open file has this handle.
  [[nodiscard]] bool close(double handle);

  enum class Written : std::uint8_t { Done, NotOpen, NotForWriting, TooLong };
  [[nodiscard]] Written write(double handle, std::string_view text);

  [[nodiscard]] bool canRead(double handle);
  /// Does what scanNumbers does, with the file of a handle that can be read.
  [[nodiscard]] int scan(double handle, std::string_view format, std::span<double> numbers);

 private:
  [[nodiscard]] OpenFile* find(double handle);
  [[nodiscard]] KeptFile* findKept(std::uint32_t file);
  KeptFile& keep(std::uint32_t file);
  [[nodiscard]] std::string_view textOf(std::uint32_t file);
  FileOutput& outputOf(std::uint32_t file);

  const language::Program* program_;
  FileState* state_;
  const core::Limits* limits_;
  bool canWrite_;
};

/// Takes the output of a plant, with the present content of the kept files.
[[nodiscard]] std::vector<FileOutput> takeOutput(FileState& state);

/// The name under which plant `plant` writes a file. The first plant uses the name in the model, the others put their
/// number before the suffix ("growth.txt", "growth.1.txt"), so that plants do not overwrite each other's files.
[[nodiscard]] std::string fileNameOfPlant(const std::string& name, std::uint32_t plant);

}  // namespace espalier::derivation
