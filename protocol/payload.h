#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/blocks.h"

namespace espalier::protocol {

struct JsonTree;  // a parsed value; defined in payload_content.h, for protocol's own .cpp files only
struct BulkText;  // a message of many numbers; defined there too

/// The params of a request or notification, or the result of a response. Cheap to copy; never changes.
class Payload {
 public:
  Payload() = default;
  Payload(std::shared_ptr<const JsonTree> root, const void* value, std::string name)
      : root_(std::move(root)), value_(value), name_(std::move(name)) {}
  Payload(std::shared_ptr<const BulkText> bulk, std::string name) : bulk_(std::move(bulk)), name_(std::move(name)) {}

  [[nodiscard]] bool isPresent() const { return value_ != nullptr || bulk_ != nullptr; }
  /// "params" or "result": the first part of the paths in errors.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The value as JSON; "null" when absent.
  [[nodiscard]] std::string toText() const;
  /// The parsed value, for protocol's decoders.
  [[nodiscard]] const void* value() const { return value_; }
  /// The message as the bulk reader read it; null: there is a tree.
  [[nodiscard]] const BulkText* bulk() const { return bulk_.get(); }
  /// The binary blocks that came with the message; null: none.
  [[nodiscard]] const Blocks* blocks() const { return blocks_.get(); }
  void attach(std::shared_ptr<const Blocks> blocks) { blocks_ = std::move(blocks); }
  /// A decoder of this payload appends a sentence for each member that it does not know. `list` outlives the decoding.
  void listUnknownMembers(std::vector<std::string>& list) { unknown_ = &list; }
  [[nodiscard]] std::vector<std::string>* unknownMembers() const { return unknown_; }

 private:
  std::shared_ptr<const JsonTree> root_;
  std::shared_ptr<const BulkText> bulk_;
  std::shared_ptr<const Blocks> blocks_;
  std::vector<std::string>* unknown_ = nullptr;  // null: nobody asks
  const void* value_ = nullptr;
  std::string name_ = "params";
};

}  // namespace espalier::protocol
