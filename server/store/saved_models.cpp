#include "server/store/saved_models.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "engine/core/hash.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/disk_files.h"

namespace espalier::server {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostNameBytes = 120;
constexpr std::size_t kMostFiles = 1000;             // of a model
constexpr std::size_t kMostModelBytes = 48'000'000;  // a message has 64 MB, and base64 takes a third more
constexpr std::size_t kMostModels = 100'000;         // that are listed
constexpr std::uint64_t kBytesOfAName = 4096;        // that a file or folder takes on the disk besides its content

// a link is no file and no folder of a model
bool isPlainFile(const fs::directory_entry& entry) {
  std::error_code error;
  return entry.symlink_status(error).type() == fs::file_type::regular;
}

bool isPlainFolder(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() == fs::file_type::directory;
}

/// The files of a folder that could have been saved; nothing when they cannot be read.
std::optional<std::map<std::string, std::string>> filesIn(const fs::path& folder) {
  std::map<std::string, std::string> files;
  std::error_code error;
  DiskFileProvider disk(kMostModelBytes);
  std::size_t total = 0;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!isPlainFile(*entry) || !problemOfSavedName(name).empty()) {
      continue;
    }
    auto bytes = disk.read(entry->path().string());
    total += bytes ? bytes->size() : 0;
    if (!bytes || files.size() == kMostFiles || total > kMostModelBytes) {
      return std::nullopt;
    }
    files.emplace(name, std::move(*bytes));
  }
  return error ? std::nullopt : std::optional(std::move(files));
}

std::string revisionOf(const std::map<std::string, std::string>& files) {
  core::Hasher hasher;
  for (const auto& [name, bytes] : files) {
    for (const std::string_view text : {std::string_view(name), std::string_view(bytes)}) {
      hasher.bytes(text);
      hasher.integer(text.size());
    }
  }
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) {
    text += kDigits[(hasher.value() >> static_cast<unsigned>(shift)) & 15U];
  }
  return text;
}

protocol::Error storageError(const std::string& sentence) {
  return {protocol::ErrorCode::Storage, sentence, {}};
}

protocol::Error changedError(const std::string& name, const std::string& revision) {
  protocol::JsonWriter data;
  data.beginObject().key("revision").text(revision).endObject();
  return {
      protocol::ErrorCode::ModelChanged,
      "The saved model '" + name +
          "' is not the one that this save knows: somebody else has saved or changed it. Save under another name, or "
          "read it again.",
      data.take()};
}

}  // namespace

std::string problemOfSavedName(const std::string& name) {
  // a message could not carry it
  if (!protocol::isPlainText(name)) {
    return "expected a name in UTF-8";
  }
  if (name.empty() || name.size() > kMostNameBytes) {
    return "expected a name of 1 to " + std::to_string(kMostNameBytes) + " bytes";
  }
  const bool hasOther = std::ranges::any_of(name, [](char letter) {
    return static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f ||
           std::string_view("/\\:*?\"<>|").find(letter) != std::string_view::npos;
  });
  if (hasOther || name.front() == '.' || name.front() == ' ' || name.back() == ' ' || name.ends_with(".part")) {
    return "expected the name of a file or folder: it has no / \\ : * ? \" < > |, does not begin with a dot or a "
           "blank, "
           "and does not end in a blank or .part";
  }
  return {};
}

std::vector<std::string> SavedModels::names() const {
  std::vector<std::string> names;
  std::error_code error;
  if (!isOn()) {
    return names;
  }
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end && names.size() < kMostModels;
       entry.increment(error)) {
    std::string name = entry->path().filename().string();
    if (isPlainFolder(entry->path()) && problemOfSavedName(name).empty()) {
      names.push_back(std::move(name));
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool SavedModels::hasModel(const std::string& name) const {
  return isOn() && problemOfSavedName(name).empty() && isPlainFolder(fs::path(folder_) / name);
}

protocol::Expected<SavedModel> SavedModels::read(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  if (!hasModel(name)) {
    return tl::unexpected(
        protocol::Error{protocol::ErrorCode::NotFound,
                        "There is no saved model '" + name + "'. " +
                            (isOn() ? "model.list names those that there are."
                                    : "The server keeps no models: its operator can start it with --models FOLDER."),
                        {}});
  }
  auto files = filesIn(fs::path(folder_) / name);
  if (!files) {
    return tl::unexpected(storageError("The files of the saved model '" + name +
                                       "' cannot be read. The server sends at most 1000 files and 48 MB of a model, "
                                       "and must be allowed to read them."));
  }
  SavedModel model{.files = std::move(*files), .revision = {}};
  model.revision = revisionOf(model.files);
  return model;
}

std::uint64_t SavedModels::bytes() const {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code missing;
    const std::uintmax_t size = isPlainFile(*entry) ? entry->file_size(missing) : 0;
    sum += kBytesOfAName + (missing ? 0 : size);
  }
  return sum;
}

protocol::Expected<std::string> SavedModels::save(const protocol::SaveModelParams& params) {
  if (!isOn()) {
    return tl::unexpected(
        storageError("The server keeps no models on its disk. Its operator can start it with --models FOLDER."));
  }
  if (const std::string problem = problemOfSavedName(params.name); !problem.empty()) {
    return tl::unexpected(protocol::memberError("params.name", problem));
  }
  if (params.files.empty() || params.files.size() > kMostFiles) {
    return tl::unexpected(
        protocol::memberError("params.files", "expected 1 to " + std::to_string(kMostFiles) + " files"));
  }
  std::uint64_t added = kBytesOfAName;
  std::size_t total = 0;
  for (const auto& [name, content] : params.files) {
    if (const std::string problem = problemOfSavedName(name); !problem.empty()) {
      return tl::unexpected(protocol::memberError("params.files." + name.substr(0, kMostNameBytes), problem));
    }
    added += kBytesOfAName + content.size();
    total += content.size();
  }
  if (total > kMostModelBytes) {
    return tl::unexpected(protocol::memberError("params.files", "expected at most 48 MB in all"));
  }
  const std::scoped_lock lock(mutex_);
  const fs::path folder = fs::path(folder_) / params.name;
  std::error_code error;
  const bool isThere = fs::exists(fs::symlink_status(folder, error));
  std::map<std::string, std::string> files;
  if (isThere) {
    auto found = hasModel(params.name) ? filesIn(folder) : std::nullopt;
    if (!found) {
      return tl::unexpected(storageError("There is something else under the name '" + params.name +
                                         "' on the server's disk. Save under another name."));
    }
    files = std::move(*found);
  }
  const std::string present = isThere ? revisionOf(files) : "";
  if (params.revision != present) {
    return tl::unexpected(changedError(params.name, present));
  }
  // the changed model must be readable
  std::size_t count = params.files.size();
  for (const auto& [name, content] : files) {
    const bool isGone = std::ranges::find(params.remove, name) != params.remove.end();
    if (!params.files.contains(name) && !isGone) {
      ++count;
      total += content.size();
    }
  }
  if (count > kMostFiles || total > kMostModelBytes) {
    return tl::unexpected(protocol::memberError(
        "params.files", "the model would have " + std::to_string(count) + " files of " + std::to_string(total) +
                            " bytes in all, and may have " + std::to_string(kMostFiles) + " and " +
                            std::to_string(kMostModelBytes) + ". Remove some with this save."));
  }
  const std::uint64_t bound = mostBytes_;
  const std::uint64_t used = bound > 0 ? bytes() : 0;
  if (bound > 0 && used + added > bound) {
    return tl::unexpected(
        protocol::limitError("savedModelBytes", used + added, bound, "Remove old models from the server's disk."));
  }
  if (!isThere && !fs::create_directory(folder, error)) {
    return tl::unexpected(storageError("The folder of the model cannot be made: " + error.message() + "."));
  }
  for (const auto& [name, content] : params.files) {
    const auto old = files.find(name);
    if (old != files.end() && old->second == content) {
      continue;
    }
    // a link or a folder of that name is none of the model's files
    const fs::file_status status = fs::symlink_status(folder / name, error);
    if (fs::exists(status) && status.type() != fs::file_type::regular) {
      return tl::unexpected(storageError("'" + name + "' is a link or a folder on the server's disk and stays."));
    }
    // its sentence names the folder, which is not for clients
    if (writeFileAtomically((folder / name).string(), content)) {
      return tl::unexpected(
          storageError("The model is not saved completely: the server's disk does not take '" + name +
                       "'. Its operator can look for room and for rights in the folder of --models."));
    }
    files.insert_or_assign(name, content);
  }
  for (const std::string& name : params.remove) {
    // only what this save has seen, and does not bring again
    if (!params.files.contains(name) && files.erase(name) > 0) {
      fs::remove(folder / name, error);
    }
  }
  return revisionOf(files);
}

}  // namespace espalier::server
