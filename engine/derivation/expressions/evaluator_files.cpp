#include <string>

#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/model_files.h"
#include "engine/derivation/expressions/number_format.h"
#include "engine/files/file_name.h"

namespace espalier::derivation {

double Evaluator::openFile(std::uint32_t file, std::uint16_t mode, std::uint32_t at) {
  const language::FileMode fileMode = language::FileMode::fromBits(mode);
  const auto opened =
      ModelFiles(*program_, state_->files, options_.limits, options_.canWriteFiles).open(file, fileMode);
  if (opened) {
    return *opened;
  }
  // the compiler has warned about a name outside the folder
  if (!files::isNameInside(program_->files[file].name)) {
    return 0.0;
  }
  warnOnce(at, "fopen(\"" + program_->files[file].name + "\", \"" + fileMode.text() + "\") gives 0: " + opened.error());
  return 0.0;
}

void Evaluator::closeFile(double handle, std::uint32_t at) {
  if (!ModelFiles(*program_, state_->files, options_.limits, options_.canWriteFiles).close(handle)) {
    warnOnce(at, "fclose: the variable holds no open file");
  }
}

void Evaluator::printToFile(double handle, const std::string& format, std::span<const double> arguments,
                            std::uint32_t at) {
  ModelFiles files(*program_, state_->files, options_.limits, options_.canWriteFiles);
  switch (files.write(handle, formatNumbers(format, arguments))) {
    case ModelFiles::Written::Done:
      break;
    case ModelFiles::Written::NotOpen:
      warnOnce(at, "fprintf: the variable holds no open file; nothing is written");
      break;
    case ModelFiles::Written::NotForWriting:
      warnOnce(at, "fprintf: the file was opened for reading; nothing is written");
      break;
    case ModelFiles::Written::TooLong:
      failHere(core::SimulationErrorCode::LimitExceeded,
               "a file is longer than " + std::to_string(options_.limits.maximumFileBytes) +
                   " bytes in one step (limit fileBytes)",
               program_->codeRanges[at]);
  }
}

double Evaluator::scanFile(double handle, const std::string& format, std::span<double> numbers, std::uint32_t at) {
  ModelFiles files(*program_, state_->files, options_.limits, options_.canWriteFiles);
  if (!files.canRead(handle)) {
    warnOnce(at, "fscanf: the variable holds no file that is open for reading; nothing is read");
    return -1.0;
  }
  return files.scan(handle, format, numbers);
}

}  // namespace espalier::derivation
