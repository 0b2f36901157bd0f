#include "server/running/run_warnings.h"

#include <utility>

#include "engine/core/diagnostic.h"
#include "protocol/json_text.h"
#include "server/remote/models/gallery.h"

namespace espalier::server {

core::MessageSink RunWarnings::sinkOf(const std::shared_ptr<RunWarnings>& warnings, std::string gallery) {
  return [warnings, gallery = std::move(gallery)](core::MessageKind kind, std::string_view text) {
    if (kind == core::MessageKind::Warning) {
      warnings->add(withinGallery(gallery, std::string(text)));
    }
  };
}

std::vector<std::string> RunWarnings::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

void RunWarnings::add(std::string_view text) {
  constexpr std::size_t kMaximumBytes = 2'000;
  const std::string_view start = protocol::beginningOf(text, kMaximumBytes);
  const std::lock_guard lock(mutex_);
  if (said_.size() < core::DiagnosticList::kLimit && said_.emplace(start).second) {
    waiting_.emplace_back(start);
  }
}

}  // namespace espalier::server
