#include "clients/espalier/output/folder_writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace espalier::command {

namespace fs = std::filesystem;

FolderWriter::FolderWriter(std::string folder) : folder_(folder.empty() ? "." : std::move(folder)) {}

std::optional<std::string> FolderWriter::write(const std::string& name, bool replaces, std::string_view bytes) {
  const fs::path file = fs::path(folder_) / name;
  const auto refusal = [&](const std::string& why) {
    return std::optional<std::string>("the model cannot write the file '" + file.string() + "': " + why + ".");
  };
  // the real folder of the file must lie inside the folder of the model
  std::error_code error;
  const fs::path root = fs::canonical(folder_, error);
  if (error) {
    return refusal("the folder of the model does not exist");
  }
  const fs::path parent = fs::canonical(file.parent_path(), error);
  if (error) {
    return refusal("there is no folder '" + file.parent_path().string() + "'; make it first");
  }
  if (std::mismatch(root.begin(), root.end(), parent.begin(), parent.end()).first != root.end()) {
    return refusal("a symbolic link leads out of the model's folder");
  }
  const fs::file_status status = fs::symlink_status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return refusal(fs::is_symlink(status) ? "it is a symbolic link, which models may not write through"
                                          : "it is not an ordinary file");
  }
  errno = 0;
  std::ofstream stream(file, std::ios::binary | (replaces ? std::ios::trunc : std::ios::app));
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    return refusal(errno == 0 ? std::string("writing failed") : std::string(std::strerror(errno)));
  }
  return std::nullopt;
}

}  // namespace espalier::command
