#include "server/store/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kOwnFile = 0600;
constexpr mode_t kOwnFolder = 0700;

}  // namespace

tl::expected<FolderLock, std::string> lockFolder(const std::string& folder) {
  const auto failure = [&folder](const std::string& reason) {
    return tl::unexpected("cannot use the data folder '" + folder + "': " + reason +
                          ". Give --data a folder that this user may read and write.");
  };
  std::error_code error;
  if (fs::create_directories(folder, error)) {
    (void)::chmod(folder.c_str(), kOwnFolder);
  }
  if (error) {
    return failure(error.message());
  }
  const std::string name = (fs::path(folder) / "lock").string();
  const int descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kOwnFile);
  if (descriptor < 0) {
    return failure(std::generic_category().message(errno));
  }
  FolderLock held(new int(descriptor), [](const int* last) {
    ::close(*last);
    delete last;
  });
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK ? tl::unexpected("the data folder '" + folder +
                                                 "' is used by another server. Stop it, or give --data another folder.")
                                : failure(std::generic_category().message(errno));
  }
  return held;
}

int makePrivate(const std::string& file, bool isMade) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC | (isMade ? O_CREAT : 0), kOwnFile);
  if (descriptor < 0) {
    return errno == ENOENT && !isMade ? 0 : errno;
  }
  const int outcome = ::fchmod(descriptor, kOwnFile) == 0 ? 0 : errno;
  ::close(descriptor);
  return outcome;
}

}  // namespace espalier::server
