#pragma once

#include <string>
#include <variant>
#include <vector>

#include "protocol/envelope.h"
#include "protocol/errors.h"
#include "protocol/json_writer.h"
#include "protocol/messages.h"

namespace espalier::protocol {

/// The message or what is wrong with it: `params.steps: expected a whole number from 1 to 9007199254740992, found "x"`.
template <typename T>
using Decoded = std::variant<T, Error>;

// Reading params. Unknown fields are ignored; a wrong type, a missing field or a number out of range is an error with
// the field's path.
[[nodiscard]] Decoded<HelloParams> decodeHelloParams(const Payload& payload);
[[nodiscard]] Decoded<ModelParams> decodeModelParams(const Payload& payload);
[[nodiscard]] Decoded<CreateParams> decodeCreateParams(const Payload& payload);
/// Of a forest file: keys that are not known are errors.
[[nodiscard]] Decoded<ForestParams> decodeForestParams(const Payload& payload);
// Members of an object that is open.
void writePlants(JsonWriter& writer, const std::vector<PlantParams>& plants);
void writeSeeds(JsonWriter& writer, const SeedParams& seeds);
[[nodiscard]] Decoded<StepParams> decodeStepParams(const Payload& payload);
[[nodiscard]] Decoded<EditParams> decodeEditParams(const Payload& payload);
[[nodiscard]] Decoded<SetParams> decodeSetParams(const Payload& payload);
[[nodiscard]] Decoded<ForkParams> decodeForkParams(const Payload& payload);
[[nodiscard]] Decoded<GetParams> decodeGetParams(const Payload& payload);
[[nodiscard]] Decoded<ResetParams> decodeResetParams(const Payload& payload);
[[nodiscard]] Decoded<TraceParams> decodeTraceParams(const Payload& payload);
[[nodiscard]] Decoded<SaveParams> decodeSaveParams(const Payload& payload);
[[nodiscard]] Decoded<RestoreParams> decodeRestoreParams(const Payload& payload);
/// Params whose only member is the text `member`, not empty and at most 200 bytes.
[[nodiscard]] Decoded<NameParams> decodeNameParams(const Payload& payload, std::string_view member);
[[nodiscard]] Decoded<StreamOpenParams> decodeStreamOpenParams(const Payload& payload);
[[nodiscard]] Decoded<StreamAckParams> decodeStreamAckParams(const Payload& payload);
/// The id of the request to give up.
[[nodiscard]] Decoded<MessageId> decodeCancelParams(const Payload& payload);
[[nodiscard]] Decoded<OpenParams> decodeOpenParams(const Payload& payload);
[[nodiscard]] Decoded<EnvironmentStepParams> decodeEnvironmentStepParams(const Payload& payload);
[[nodiscard]] Decoded<RestoreStateParams> decodeRestoreStateParams(const Payload& payload);

// Reading results.
[[nodiscard]] Decoded<HelloResult> decodeHelloResult(const Payload& payload);
[[nodiscard]] Decoded<DescribeResult> decodeDescribeResult(const Payload& payload);
/// Each id below `queryCount`, at most once; numbers finite. From text or blocks.
[[nodiscard]] Decoded<ReplyColumns> decodeReplies(const Payload& payload, std::size_t queryCount);
[[nodiscard]] Decoded<std::string> decodeSaveResult(const Payload& payload);  // the state's bytes

// Writing params. All encoders throw NonFiniteNumber for NaN and infinity.
[[nodiscard]] std::string encode(const HelloParams& params);
[[nodiscard]] std::string encode(const OpenParams& params);
[[nodiscard]] std::string encode(const EnvironmentStepParams& params);
/// The same in blocks, for a peer that takes them. Refers to the columns until it is sent.
[[nodiscard]] Body encodeBlocks(const EnvironmentStepParams& params);
[[nodiscard]] std::string encode(const RestoreStateParams& params);
[[nodiscard]] Body encode(StreamData data);

// Writing results.
[[nodiscard]] std::string encode(const HelloResult& result);
[[nodiscard]] std::string encode(const ModelResult& result);
[[nodiscard]] std::string encode(const CreateResult& result);
[[nodiscard]] std::string encode(const StepResult& result);
[[nodiscard]] std::string encode(const DescribeResult& result);
[[nodiscard]] std::string encode(const ReplyColumns& replies);
[[nodiscard]] Body encodeBlocks(const ReplyColumns& replies);
[[nodiscard]] std::string encodeSaveResult(std::string_view state);
void write(JsonWriter& writer, const Statistics& statistics);
/// The member "queries":[...].
void writeQueries(JsonWriter& writer, const QueryColumns& queries);
/// The member "replies":[...].
void writeReplies(JsonWriter& writer, const ReplyColumns& replies);
/// The blocks of environment.step. They refer to the columns.
void addBlocks(BlockWriter& blocks, const QueryColumns& queries);
/// The member `bounds`.
void write(JsonWriter& writer, const BoundsRecord& bounds);
void write(JsonWriter& writer, const SavePolicy& policy);
void write(JsonWriter& writer, const SimulationInformation& information);
void write(JsonWriter& writer, const TurtleStreamRecord& record, bool hasIndex);
/// {"diagnostics":[...]} for the data of a Model error.
void write(JsonWriter& writer, const std::vector<DiagnosticRecord>& diagnostics);

}  // namespace espalier::protocol
