#include "server/running/run_messages.h"

#include <utility>

#include "engine/core/diagnostic.h"
#include "protocol/json_text.h"
#include "server/remote/models/gallery.h"

namespace espalier::server {

core::MessageSink RunMessages::sinkOf(const std::shared_ptr<RunMessages>& messages, std::string gallery) {
  return [messages, gallery = std::move(gallery)](core::MessageKind kind, std::string_view text) {
    if (kind == core::MessageKind::Warning) {
      messages->warn(withinGallery(gallery, std::string(text)));
    } else {
      messages->print(text);
    }
  };
}

std::vector<std::string> RunMessages::takeWarnings() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

void RunMessages::forgetWarnings() {
  const std::lock_guard lock(mutex_);
  said_ = {waiting_.begin(), waiting_.end()};
}

std::string RunMessages::takePrinted() {
  const std::lock_guard lock(mutex_);
  std::string printed = std::exchange(printed_, {});
  if (const std::uint64_t missing = std::exchange(missingBytes_, 0); missing > 0) {
    printed += "\n[" + std::to_string(missing) + " bytes more were printed]\n";
  }
  return printed;
}

void RunMessages::print(std::string_view text) {
  const std::lock_guard lock(mutex_);
  const std::string_view taken =
      missingBytes_ > 0 ? std::string_view() : protocol::beginningOf(text, kMostPrinted - printed_.size());
  printed_ += taken;
  missingBytes_ += text.size() - taken.size();
}

void RunMessages::warn(std::string_view text) {
  constexpr std::size_t kMaximumBytes = 2'000;
  const std::string_view start = protocol::beginningOf(text, kMaximumBytes);
  const std::lock_guard lock(mutex_);
  if (said_.size() < core::DiagnosticList::kLimit && said_.emplace(start).second) {
    waiting_.emplace_back(start);
  }
}

}  // namespace espalier::server
