#include "server/disk_files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

namespace espalier::server {

std::optional<std::string> DiskFileProvider::read(const std::string& name) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(name, error)) {
    return std::nullopt;
  }
  const std::uintmax_t size = std::filesystem::file_size(name, error);
  if (error || size > maximumBytes_) {
    return std::nullopt;
  }
  std::ifstream file(name, std::ios::binary);
  if (!file) {
    return std::nullopt;
  }
  std::string content(static_cast<std::size_t>(size), '\0');
  file.read(content.data(), static_cast<std::streamsize>(size));
  content.resize(static_cast<std::size_t>(file.gcount()));
  return content;
}

std::optional<std::string> DiskFileProvider::readInside(const std::string& folder, const std::string& name) {
  // where the names lead once every link is followed
  std::error_code error;
  const std::filesystem::path root = std::filesystem::canonical(folder.empty() ? "." : folder, error);
  if (error) {
    return std::nullopt;
  }
  const std::filesystem::path file = std::filesystem::canonical(name, error);
  if (error || std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first != root.end()) {
    return std::nullopt;
  }
  return read(name);
}

std::optional<std::string> writeFileAtomically(const std::string& name, std::string_view content) {
  // a name of its own for each process and thread, so that two writers never share a temporary file
  const std::string temporary = name + "." + std::to_string(::getpid()) + "." +
                                std::to_string(std::hash<std::thread::id>()(std::this_thread::get_id())) + ".part";
  const auto failure = [&](const std::string& what) {
    const int reason = errno;
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    return "cannot " + what + " '" + name + "': " + std::strerror(reason) +
           ". Check that the folder exists, is writable and has room.";
  };

  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  if (!file) {
    return failure("write");
  }
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  if (!file) {
    return failure("write");
  }
  std::error_code error;
  std::filesystem::rename(temporary, name, error);
  if (error) {
    errno = error.value();
    return failure("replace");
  }
  return std::nullopt;
}

}  // namespace espalier::server
