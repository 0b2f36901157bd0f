#include "protocol/message_id.h"

#include "protocol/json_writer.h"

namespace espalier::protocol {

std::string toText(const MessageId& id) {
  JsonWriter writer;
  switch (id.kind) {
    case MessageId::Kind::Null:
      writer.null();
      break;
    case MessageId::Kind::Number:
      writer.integer(id.number);
      break;
    case MessageId::Kind::Text:
      writer.text(id.text);
      break;
  }
  return writer.take();
}

}  // namespace espalier::protocol
