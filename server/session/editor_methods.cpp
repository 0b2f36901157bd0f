#include "protocol/codec.h"
#include "server/running/interruption.h"
#include "server/session/editor_conversation.h"
#include "server/session/production_counts.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server::methods {

void editorMessage(const Request& request, protocol::EditorParams params) {
  SimulationRunner::Productions productions;
  // an editor may name a run that has just ended: there is nothing to say about it
  if (const auto runner = request.session.core().find(params.simulation)) {
    productions = runner->productions();
  }
  const auto interruption = std::make_shared<Interruption>();
  // a message that waits for its turn can be cancelled too
  request.session.onCancel(request.id, [interruption] { interruption->interrupt(Interruption::Reason::Cancelled); });
  request.session.editor()->takeTurn([weak = request.session.weak_from_this(), id = request.id,
                                      message = std::make_shared<const std::string>(std::move(params.message)),
                                      productions = std::move(productions),
                                      interruption](const EditorConversation::Turn& turn) {
    const auto session = weak.lock();
    if (session == nullptr) {
      return;
    }
    const auto answer = [message, productions, turn](const Request& self) {
      const auto run = [&productions]() -> std::optional<RunCounts> {
        return productions.uses == nullptr ? std::nullopt
                                           : std::optional(runCounts(productions.programs, *productions.uses));
      };
      self.session.editor()->receive(*message, run, [&](const EditorConversation::Messages& messages) {
        protocol::JsonWriter result;
        result.beginObject().key("messages").texts(messages).endObject();
        self.session.respond(self.id, result.view());
      });
    };
    runOnWorker({*session, id}, answer, interruption);
  });
}

}  // namespace espalier::server::methods
