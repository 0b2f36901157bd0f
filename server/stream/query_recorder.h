#pragma once

#include <memory>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// The queries of a step and their answers.
struct QueryRecord {
  turtle::QueryBatch queries;
  turtle::ReplyBatch replies;
};

/// Keeps a copy of the last step's queries and replies while a viewer wants them. For one worker at a time, as the
/// simulation.
class QueryRecorder {
 public:
  /// The process with its dialogue copied; null stays null.
  [[nodiscard]] static std::unique_ptr<turtle::EnvironmentProcess> record(
      std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<QueryRecorder> recorder);

  /// True: queries of later steps are copied. False: they are not, and the last copy is dropped.
  void want(bool isWanted);
  void keep(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies);
  /// Null: none was copied.
  [[nodiscard]] const std::shared_ptr<const QueryRecord>& last() const { return last_; }

 private:
  bool isWanted_ = false;
  std::shared_ptr<const QueryRecord> last_;
};

}  // namespace espalier::server
