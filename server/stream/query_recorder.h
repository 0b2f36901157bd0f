#pragma once

#include <memory>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// What a step asked its environment, and the answers.
struct QueryRecord {
  turtle::QueryBatch queries;
  turtle::ReplyBatch replies;
};

/// Keeps a copy of the last step's queries and replies while somebody wants to see them. One worker at a time, as the
/// simulation.
class QueryRecorder {
 public:
  /// The process with its dialogue copied; null stays null.
  [[nodiscard]] static std::unique_ptr<turtle::EnvironmentProcess> record(
      std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<QueryRecorder> recorder);

  /// From now on steps are copied; false also forgets the last one.
  void want(bool isWanted);
  void keep(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies);
  /// Null: none was copied.
  [[nodiscard]] const std::shared_ptr<const QueryRecord>& last() const { return last_; }

 private:
  bool isWanted_ = false;
  std::shared_ptr<const QueryRecord> last_;
};

}  // namespace espalier::server
