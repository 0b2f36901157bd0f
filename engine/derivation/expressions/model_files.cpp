#include "engine/derivation/expressions/model_files.h"

#include <algorithm>
#include <utility>

#include "engine/derivation/expressions/number_scan.h"

namespace espalier::derivation {

OpenFile* ModelFiles::find(double handle) {
  if (!(handle >= 1.0 && handle < static_cast<double>(state_->open.size()) + 1.0)) {
    return nullptr;
  }
  OpenFile& file = state_->open[static_cast<std::size_t>(handle) - 1];
  return file.isOpen ? &file : nullptr;
}

KeptFile* ModelFiles::findKept(std::uint32_t file) {
  const auto found =
      std::find_if(state_->kept.begin(), state_->kept.end(), [&](const KeptFile& kept) { return kept.file == file; });
  return found == state_->kept.end() ? nullptr : &*found;
}

std::string_view ModelFiles::textOf(std::uint32_t file) {
  if (const KeptFile* kept = findKept(file)) {
    return kept->text;
  }
  const std::uint32_t source = program_->files[file].source;
  return source == language::ModelFile::kNoSource ? std::string_view{} : program_->sources[source].text;
}

KeptFile& ModelFiles::keep(std::uint32_t file) {
  if (KeptFile* kept = findKept(file)) {
    return *kept;
  }
  std::string text(textOf(file));
  return state_->kept.emplace_back(KeptFile{file, std::move(text)});
}

FileOutput& ModelFiles::outputOf(std::uint32_t file) {
  const auto found = std::find_if(state_->output.begin(), state_->output.end(),
                                  [&](const FileOutput& output) { return output.file == file; });
  return found == state_->output.end() ? state_->output.emplace_back(FileOutput{file, false, {}}) : *found;
}

tl::expected<double, std::string> ModelFiles::open(std::uint32_t file, const language::FileMode& mode) {
  const language::ModelFile& named = program_->files[file];
  if (named.isRefused) {
    return tl::unexpected(
        std::string("a model can open only files inside its folder, and cannot overwrite its own text"));
  }
  if (mode.canWrite && !canWrite_) {
    return tl::unexpected(std::string("models write no files here"));
  }
  const bool exists = named.source != language::ModelFile::kNoSource || findKept(file) != nullptr;
  if (mode.mustExist && !exists) {
    return tl::unexpected(std::string("there is no such file in the model's folder"));
  }
  // the first free place
  const auto free =
      std::find_if(state_->open.begin(), state_->open.end(), [](const OpenFile& place) { return !place.isOpen; });
  const auto index = static_cast<std::size_t>(free - state_->open.begin());
  if (index >= limits_->maximumOpenFiles) {
    return tl::unexpected("more than " + std::to_string(limits_->maximumOpenFiles) +
                          " files are open (limit openFiles)");
  }
  if (free == state_->open.end()) {
    state_->open.emplace_back();
  }
  state_->open[index] = OpenFile{file, mode, 0, true};
  if (mode.canWrite) {
    FileOutput& output = outputOf(file);
    if (named.isRead) {
      KeptFile& kept = keep(file);
      if (mode.truncates) {
        kept.text.clear();
      }
      output.replaces = true;
    } else if (mode.truncates) {
      output = {file, true, {}};
    }
  }
  return static_cast<double>(index + 1);
}

bool ModelFiles::close(double handle) {
  OpenFile* file = find(handle);
  if (file == nullptr) {
    return false;
  }
  file->isOpen = false;
  return true;
}

ModelFiles::Written ModelFiles::write(double handle, std::string_view text) {
  OpenFile* file = find(handle);
  if (file == nullptr) {
    return Written::NotOpen;
  }
  // a restored plant can hold a file that was opened where models may write
  if (!canWrite_ || !file->mode.canWrite) {
    return Written::NotForWriting;
  }
  if (program_->files[file->file].isRead) {
    KeptFile& kept = keep(file->file);
    const std::size_t position = file->mode.appends ? kept.text.size() : static_cast<std::size_t>(file->position);
    if (position + text.size() > limits_->maximumFileBytes) {
      return Written::TooLong;
    }
    if (kept.text.size() < position) {
      kept.text.resize(position, '\0');
    }
    kept.text.replace(position, std::min(text.size(), kept.text.size() - position), text);
    file->position = position + text.size();
    outputOf(file->file).replaces = true;
    return Written::Done;
  }
  FileOutput& output = outputOf(file->file);
  if (output.bytes.size() + text.size() > limits_->maximumFileBytes) {
    return Written::TooLong;
  }
  output.bytes += text;
  file->position += text.size();
  return Written::Done;
}

bool ModelFiles::canRead(double handle) {
  const OpenFile* file = find(handle);
  return file != nullptr && file->mode.canRead;
}

int ModelFiles::scan(double handle, std::string_view format, std::span<double> numbers) {
  OpenFile* file = find(handle);
  auto position = static_cast<std::size_t>(file->position);
  const int count = scanNumbers(textOf(file->file), position, format, numbers);
  file->position = position;
  return count;
}

std::vector<FileOutput> takeOutput(FileState& state) {
  std::vector<FileOutput> output = std::exchange(state.output, {});
  for (FileOutput& piece : output) {
    const auto kept = std::find_if(state.kept.begin(), state.kept.end(),
                                   [&](const KeptFile& file) { return file.file == piece.file; });
    if (kept != state.kept.end()) {
      piece.bytes = kept->text;
    }
  }
  return output;
}

std::string fileNameOfPlant(const std::string& name, std::uint32_t plant) {
  if (plant == 0) {
    return name;
  }
  const std::size_t slash = name.rfind('/');
  const std::size_t dot = name.rfind('.');
  const bool hasSuffix = dot != std::string::npos && dot > (slash == std::string::npos ? 0 : slash + 1);
  const std::size_t end = hasSuffix ? dot : name.size();
  return name.substr(0, end) + "." + std::to_string(plant) + name.substr(end);
}

}  // namespace espalier::derivation
