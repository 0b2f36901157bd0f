#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

#include "server/access/access.h"
#include "server/network/http_pages.h"
#include "server/running/account.h"

namespace espalier::server {

/// The thing that the path of a download names: `/simulations` (a list), `/simulations/ID/NAME.SUFFIX` (an export in
/// the format of the suffix, or the `.snapshot`), `/simulations/ID/checkpoints/NAME`, `/simulations/ID/traces/NUMBER`,
/// `/simulations/ID/fields` (a list), `/simulations/ID/fields/NAME.vti`, `/gallery/NAME/FILE.png`.
struct DownloadPath {
  enum class Kind { List, Export, Snapshot, Checkpoint, Trace, Picture, Fields, Field };
  Kind kind = Kind::List;
  std::string simulation;  // or the folder of a picture
  std::string name;        // of the export, checkpoint, picture or field, or the number of the trace
};

/// The path of a target without its query, percent-decoded; nothing when it is not the path of a download.
[[nodiscard]] std::optional<DownloadPath> downloadPathOf(std::string_view target);

/// Makes a download on a worker and calls `done` once, on any thread. blockBytes bounds the bytes. They count for the
/// account as long as the page is there; so does the processor time. The returned function gives the download up: then
/// `done` may never be called.
[[nodiscard]] std::function<void()> makeDownload(ServerCore& core, Account& account, const DownloadPath& path,
                                                 std::function<void(HttpPage)> done);

/// The grant for a request with this header `Authorization`, or why it may not download. When the server has tokens, it
/// must be `Bearer TOKEN` of a viewer.
[[nodiscard]] tl::expected<Grant, std::string> downloadGrant(std::string_view authorization, const Access& access);

}  // namespace espalier::server
