#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/envelope.h"
#include "protocol/errors.h"
#include "protocol/json_writer.h"
#include "protocol/messages.h"

namespace espalier::protocol {

// Reading params. Unknown members are ignored. A wrong type, a missing member or a number out of range is an error that
// begins with the member's path: `params.steps: expected a whole number from 1 to 9007199254740992, found "x"`.
//
//     Expected<StepParams> decodeStepParams(const Payload& payload);
//
// and so on, one for each struct of params in methods.def.
#define ESPALIER_METHOD(NAME, PARAMS, ANSWERER, ROLE, SUMMARY) \
  [[nodiscard]] Expected<PARAMS> decode##PARAMS(const Payload& payload);
#include "protocol/methods.def"
/// Reads a forest file. People write it, so an unknown member is an error.
[[nodiscard]] Expected<ForestParams> decodeForestParams(const Payload& payload);
/// Reads a world. People write it, so an unknown member is an error.
[[nodiscard]] Expected<WorldRecord> decodeWorld(const Payload& payload);
/// The days of a duration such as "1 h", "0.25 d" or "30 min"; nothing when the text is no such.
[[nodiscard]] std::optional<double> daysOfDuration(std::string_view text);

// Reading results.
[[nodiscard]] Expected<HelloResult> decodeHelloResult(const Payload& payload);
[[nodiscard]] Expected<DescribeResult> decodeDescribeResult(const Payload& payload);
/// Each id below `queryCount`, at most once; numbers finite. From text or blocks.
[[nodiscard]] Expected<ReplyColumns> decodeReplies(const Payload& payload, std::size_t queryCount);
[[nodiscard]] Expected<std::string> decodeSaveResult(const Payload& payload);  // the state's bytes

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

// Writing parts: members of an object that is open.
void writePlants(JsonWriter& writer, const std::vector<PlantParams>& plants);
void writeSeeds(JsonWriter& writer, const SeedParams& seeds);
void write(JsonWriter& writer, const Statistics& statistics);
/// The member "queries":[...].
void writeQueries(JsonWriter& writer, const QueryColumns& queries);
/// The member "replies":[...].
void writeReplies(JsonWriter& writer, const ReplyColumns& replies);
/// The blocks of environment.step. They refer to the columns.
void addBlocks(BlockWriter& blocks, const QueryColumns& queries);
/// The member `world`.
void write(JsonWriter& writer, const WorldRecord& world);
/// The member `bounds`.
void write(JsonWriter& writer, const BoundsRecord& bounds);
void write(JsonWriter& writer, const SavePolicy& policy);
void write(JsonWriter& writer, const SimulationInformation& information);
void write(JsonWriter& writer, const TurtleStreamRecord& record, bool hasIndex);
/// {"diagnostics":[...]} for the data of a Model error.
void write(JsonWriter& writer, const std::vector<DiagnosticRecord>& diagnostics);

}  // namespace espalier::protocol
