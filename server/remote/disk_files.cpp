#include "server/remote/disk_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

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

namespace {

constexpr std::size_t kBufferBytes = 1U << 16U;

// a name of its own for each process and file, so that two writers never share a temporary file
std::string temporaryNameFor(const std::string& name) {
  static std::atomic<unsigned> count = 0;
  return name + "." + std::to_string(::getpid()) + "." + std::to_string(count++) + ".part";
}

// a device, a pipe or a name that stands for an open file, which a rename would replace
bool isSpecial(const std::string& name) {
  // not all of /dev: /dev/shm holds plain files
  if (name.starts_with("/dev/std") || name.starts_with("/dev/fd/") || name.starts_with("/proc/")) {
    return true;
  }
  std::error_code error;
  const auto status = std::filesystem::status(name, error);
  return !error && std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

// the file that links lead to: a rename would replace a link
std::string behindLinks(const std::string& name) {
  constexpr int kMostLinks = 40;  // as many as the system follows
  std::filesystem::path at = name;
  std::error_code error;
  for (int i = 0; i < kMostLinks && !isSpecial(at.string()) && std::filesystem::is_symlink(at, error); ++i) {
    // an absolute target replaces the folder
    at = at.parent_path() / std::filesystem::read_symlink(at, error);
  }
  return at.string();
}

}  // namespace

AtomicFile::AtomicFile(std::string name) : name_(std::move(name)), place_(behindLinks(name_)) {
  const bool isDirect = isSpecial(place_);
  if (!isDirect) {
    temporary_.emplace(temporaryNameFor(place_));
  }
  struct stat old {};
  // by the given name: the system follows no link that a stranger has put into a folder of all, such as /tmp
  const bool isReplaced = !isDirect && ::stat(name_.c_str(), &old) == 0;
  if (!isDirect && !isReplaced && errno != ENOENT) {
    failure_ = errno;
    return;
  }
  if (isReplaced && ::access(place_.c_str(), W_OK) != 0) {
    failure_ = errno;  // a rename would ask for the folder's permission only
    return;
  }
  const std::string& opened = isDirect ? place_ : temporary_->name();
  const int flags = O_WRONLY | O_CLOEXEC | (isDirect ? O_APPEND : O_CREAT | O_TRUNC);
  descriptor_ = ::open(opened.c_str(), flags, 0666);
  failure_ = descriptor_ < 0 ? errno : 0;
  if (isReplaced && descriptor_ >= 0) {
    (void)::fchmod(descriptor_, old.st_mode & 0777U);  // a disk without permissions has none to keep
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

void AtomicFile::write(std::string_view bytes) {
  if (bytes.size() >= kBufferBytes) {
    flush();
    put(bytes);
    return;
  }
  buffered_.append(bytes);
  if (buffered_.size() >= kBufferBytes) {
    flush();
  }
}

void AtomicFile::flush() {
  put(buffered_);
  buffered_.clear();
}

void AtomicFile::put(std::string_view rest) {
  while (failure_ == 0 && !rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      failure_ = errno;
    }
  }
}

std::optional<std::string> AtomicFile::finish() {
  flush();
  if (const int descriptor = std::exchange(descriptor_, -1); descriptor >= 0 && ::close(descriptor) != 0) {
    failure_ = failure_ == 0 ? errno : failure_;
  }
  return problem();
}

std::optional<std::string> AtomicFile::commit() {
  static_cast<void>(finish());
  if (failure_ == 0 && temporary_) {
    failure_ = temporary_->complete(place_);
    if (failure_ == 0) {
      temporary_.reset();
    }
  }
  return problem();
}

std::optional<std::string> AtomicFile::problem() const {
  if (failure_ == 0) {
    return std::nullopt;
  }
  return "cannot write '" + name_ + "': " + std::strerror(failure_) +
         ". Check that the folder exists, is writable and has room.";
}

std::optional<std::string> writeFileAtomically(const std::string& name, std::string_view content) {
  AtomicFile file(name);
  file.write(content);
  return file.commit();
}

}  // namespace espalier::server
