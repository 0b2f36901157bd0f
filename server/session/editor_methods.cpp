#include "protocol/codec.h"
#include "server/session/editor_conversation.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server::methods {

void editorMessage(const Request& request, protocol::EditorParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) {
    protocol::JsonWriter result;
    result.beginObject().key("messages").texts(self.session.editor()->receive(params.message)).endObject();
    self.session.respond(self.id, result.view());
  });
}

}  // namespace espalier::server::methods
