#include "server/session/editor_conversation.h"

#include <algorithm>
#include <utility>

#include "server/running/turn_meter.h"

namespace espalier::server {

void EditorConversation::takeTurn(std::function<void(Turn)> begin) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(begin));
    if (std::exchange(isBusy_, true)) {
      return;
    }
  }
  beginNext();
}

void EditorConversation::beginNext() {
  std::function<void(Turn)> begin;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) {
      isBusy_ = false;
      return;
    }
    begin = std::move(waiting_.front());
    waiting_.pop_front();
  }
  begin(Turn(nullptr, [self = shared_from_this()](void*) { self->beginNext(); }));
}

void EditorConversation::receive(const std::string& message, const OpenRun& run,
                                 const std::function<void(const Messages&)>& answer) {
  PartMeter meter;
  Messages messages;
  // the answers are taken and given back under the same meter: what is left is what the conversation keeps
  const std::shared_ptr<void> count(nullptr, [&](void*) {
    {
      const core::WorkMeter::Scope scope(&meter);
      messages = {};
    }
    keptBytes_ += meter.net();
    memory_.set(static_cast<std::uint64_t>(std::max<std::int64_t>(keptBytes_, 0)));
  });
  {
    const core::WorkMeter::Scope scope(&meter);
    messages = server_.receive(message, run);
  }
  answer(messages);
}

}  // namespace espalier::server
