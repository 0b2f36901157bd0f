#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/blocks.h"
#include "protocol/geometry.h"
#include "protocol/message_id.h"

namespace espalier::protocol {

// Plain data of the messages in README.md, by method. Members named ...Json hold a JSON text that travels as it is.

/// The params of a method without params: all members are ignored.
struct NoParams {};

// ---- handshake ----

struct HelloParams {
  std::vector<std::int64_t> protocol;  // versions the peer speaks
  std::vector<std::string> roles;      // that are asked for: controller, environment, viewer; none: all that there are
  std::string name;                    // for logs and people
  std::string version;
  std::vector<std::string> capabilities;
  std::string token;                                          // empty: none
  std::vector<std::pair<std::string, std::uint64_t>> limits;  // that the peer takes: lineBytes, blockBytes
};

struct HelloResult {
  std::int64_t protocol = 1;
  std::string session;
  std::string server;              // program and version
  std::vector<std::string> roles;  // granted; an environment grants none
  std::vector<std::string> capabilities;
  std::vector<std::pair<std::string, std::uint64_t>> limits;  // name, bound
};

// ---- models ----

/// Where a model comes from: exactly one of the four.
struct ModelReference {
  std::optional<std::string> source;         // the text of the `.l` file
  std::optional<std::string> gallery;        // name of a folder of the server's gallery
  std::map<std::string, std::string> files;  // contents by name, texts and bytes
  std::string main;                          // of `files`: FILE or FILE:ENTRY; empty: they are a model folder
  std::optional<std::string> loaded;         // identifier that model.load gave
};

struct ModelParams {
  ModelReference model;
  std::string compatibility;                                 // empty, cpfg or cpfg-batch
  std::vector<std::pair<std::string, std::string>> defines;  // NAME, VALUE: they win over #define
};

/// The params of editor.message: a message of the Language Server Protocol.
struct EditorParams {
  std::string message;     // JSON
  std::string simulation;  // whose counts code lenses show; empty: none
};

/// The params of model.read.
struct ReadModelParams {
  std::string gallery;  // NAME, NAME/FILE or NAME/FILE:ENTRY; empty: a saved model
  std::string saved;    // its name
};

/// The params of model.save.
struct SaveModelParams {
  std::string name;
  std::map<std::string, std::string> files;  // contents by name, texts and bytes
  std::vector<std::string> remove;           // names of files that the model has no more
  std::string revision;                      // of model.read or the last save; empty: the model is new
};

struct SourcePosition {
  std::uint32_t line = 0;    // 1-based
  std::uint32_t column = 0;  // 1-based, in bytes
};

struct DiagnosticRecord {
  std::string severity;  // error, warning, note
  std::string message;
  std::string file;  // empty: no place is known
  SourcePosition begin;
  SourcePosition end;  // one beyond the last byte
  std::string hint;
  std::string text;  // all of it as a person reads it, with the source line and a caret
};

struct ModelResult {
  std::string model;  // identifier; empty in the answer of model.check
  bool isValid = false;
  std::uint64_t derivationLength = 0;
  std::vector<std::string> symbols;
  std::vector<DiagnosticRecord> diagnostics;
};

// ---- simulations ----

/// One of several models of a simulation.
struct NamedModel {
  std::string name;         // plants choose it by this name
  ModelParams model;        // of requests
  std::string file;         // of forest files: instead of `model`, a .l file or a model folder
  std::int64_t colour = 0;  // added to the colours of its plants
};

struct PlantParams {
  std::array<double, 3> position{0.0, 0.0, 0.0};
  std::string model;                             // name of a NamedModel; empty: the first
  std::optional<std::array<double, 3>> heading;  // nothing: as the turtle starts
  double turnDegrees = 0.0;                      // about the heading
  std::string name;
  std::int64_t colour = 0;  // added to its colours
};

/// Where seeds take root.
struct SeedParams {
  std::optional<std::uint64_t> maximumPlants;
  double spacing = 0.0;
  double ground = 0.0;
  std::optional<std::array<std::array<double, 3>, 2>> area;  // two corners
};

/// The world of a simulation: units, directions, place, time and weather.
struct WorldRecord {
  std::string lengthUnit = "m";
  std::array<double, 3> up{0.0, 1.0, 0.0};
  std::array<double, 3> north{0.0, 0.0, -1.0};
  double stepDurationDays = 1.0;
  std::optional<double> latitudeDegrees;
  std::optional<double> longitudeDegrees;
  std::string start;
  double baseTemperature = 0.0;
  std::string weather;  // text of a table; empty: not known
};

/// A forest file (clients/espalier/README.md): the models and plants of a simulation with their environment.
struct ForestParams {
  std::vector<NamedModel> models;
  std::vector<PlantParams> plants;
  SeedParams seeds;
  std::string environmentJson;  // text of an array; empty: none, or a file
  std::string environmentFile;  // a published .e file or a configuration; empty: none, or in `environmentJson`
  std::optional<std::uint64_t> derivationLength;
  std::optional<std::uint64_t> seed;
  std::optional<WorldRecord> world;  // its weather is the name of a file
};

/// A box: its least and its greatest corner, in the world's unit.
using BoundsRecord = std::array<std::array<double, 3>, 2>;

/// When the state of a simulation is written to the server's disk.
struct SavePolicy {
  bool isKept = true;
  std::uint64_t every = 1;  // steps; 0: only when simulation.save asks
};

struct CreateParams {
  ModelParams model;
  std::vector<NamedModel> models;             // instead of `model`; empty: that one
  std::string simulation;                     // its identifier; empty: the server draws one
  std::string name;                           // for people; empty: the model's
  std::optional<std::uint64_t> seed;          // nothing: the server draws one and says which
  std::string environmentJson;                // text of an array; empty: no environment
  std::vector<std::string> environmentTypes;  // `type` of each entry
  std::optional<std::uint64_t> derivationLength;
  std::vector<PlantParams> plants;  // empty: one at the origin
  SeedParams seeds;
  std::optional<std::uint64_t> maximumModules;  // lowers the server's limits
  std::optional<std::uint64_t> maximumQueries;
  SavePolicy save;
  bool isTraced = false;               // the dialogue with its environments is recorded
  bool countsProductions = false;      // each step counts how often it applies each production
  std::uint32_t iterations = 1;        // of the coupling with its environments, at most, in each step
  double tolerance = 0.0;              // of the answers of two iterations
  std::optional<BoundsRecord> bounds;  // of the space that the plants may fill: passed on to environments
  std::optional<WorldRecord> world;    // nothing: the default
};

struct Statistics {
  std::uint64_t step = 0;
  std::uint64_t modules = 0;
  std::uint64_t parameters = 0;
  std::uint64_t queries = 0;
  std::uint64_t answers = 0;
  std::uint64_t bytes = 0;
  std::uint64_t plants = 0;  // living
  std::uint64_t births = 0;  // in the step
  std::uint64_t deaths = 0;
  double milliseconds = 0.0;     // wall time of the step, environment included
  std::uint32_t iterations = 0;  // exchanges with the environment; 0 and 1 are not sent
};

struct CreateResult {
  std::string simulation;
  std::uint64_t step = 0;
  std::uint64_t seed = 0;
  std::uint64_t derivationLength = 0;
  std::uint32_t plants = 1;
  bool isFinished = false;
  Statistics statistics;
  std::vector<DiagnosticRecord> diagnostics;  // warnings of the model
};

struct StepParams {
  std::string simulation;
  std::uint64_t steps = 1;
  std::optional<std::uint64_t> until;  // completed steps to reach, instead of `steps`
  bool wantsProgress = false;          // $/progress is sent on the way
};

/// The params of $/cancel.
struct CancelParams {
  MessageId request;  // the one to give up
};

struct StepResult {
  std::uint64_t step = 0;
  bool isFinished = false;  // the derivation length is reached or the model stopped itself
  bool isTruncated =
      false;  // fewer steps were made than asked for, although not finished (stopped by a limit or cancelled)
  bool isSaved = false;   // the state after the last step is on the server's disk
  Statistics statistics;  // figures of the last step; queries, answers and milliseconds summed over this call
  std::string printed;    // by the model since the last answer
};

struct ModuleRecord {
  std::string symbol;
  std::vector<double> parameters;
};

struct EditParams {
  std::string simulation;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::string action;        // insert, prune, replace
  std::vector<ModuleRecord> modules;
};

struct SetParams {
  std::string simulation;
  std::vector<std::pair<std::string, std::string>> values;  // name, text of the value
};

struct ForkParams {
  std::string simulation;
  std::string name;  // of the new one, for people; empty: that of the old one
};

/// The turtle records that a stream shows.
struct StreamSelection {
  std::vector<std::string> symbols;   // empty: all
  std::vector<std::uint32_t> plants;  // empty: all

  bool operator==(const StreamSelection&) const = default;
};

struct GetParams {
  std::string simulation;
  // string, statistics, state-hash, turtle, model, information, checkpoints, traces, trace, palette, explanation,
  // environment, productions
  std::string what;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // of the explanation
  std::uint64_t trace = 0;   // number of the trace; 0: not given
  StreamSelection select;    // of turtle records
};

/// The params of a method that only names a simulation.
struct SimulationParams {
  std::string simulation;
};

struct TraceParams {
  std::string simulation;
  bool isTraced = true;
};

struct ResetParams {
  std::string simulation;
  std::optional<std::uint64_t> seed;
};

struct SaveParams {
  std::string simulation;
  std::string checkpoint;   // name under which the server keeps it; empty: it does not
  bool hasSnapshot = true;  // the answer brings the snapshot
};

/// One of the two.
struct RestoreParams {
  std::string simulation;
  std::string snapshot;    // bytes (base64 on the wire)
  std::string checkpoint;  // name that simulation.save gave
};

struct SimulationInformation {
  std::string simulation;
  std::string name;
  std::uint64_t step = 0;
  std::uint64_t derivationLength = 0;
  std::uint64_t seed = 0;
  std::uint32_t plants = 1;
  bool isFinished = false;
  bool isRunning = false;
  bool isSaved = false;
  std::vector<std::string> environment;  // types, in order; an offered one as offered:NAME
  std::string lastError;                 // of the last failed step; empty: none since the last good one
  std::string damage;                    // why it could not be loaded from disk; empty: it is loaded
};

// ---- streams ----

struct StreamCloseParams {
  std::string stream;
};

struct StreamOpenParams {
  std::string simulation;
  std::string what;            // turtle, string, statistics, geometry, queries
  std::string format = "glb";  // of geometry: glb, a file; columns
  StreamSelection select;
  std::uint64_t every = 1;  // frames at steps that are multiples of it
  std::optional<std::uint64_t>
      credits;                     // frames that may be unacknowledged; nothing: only the connection's speed counts
  double maximumHertz = 0.0;       // frames a second; 0: any number
  bool isDelta = false;            // a frame may be the difference from the one sent before
  bool isInBlocks = false;         // records as columns behind the message; needs the capability bin
  bool isSinglePrecision = false;  // turtle records with numbers rounded to floats, in blocks as <f4
};

struct StreamAckParams {
  std::string stream;
  std::optional<std::uint64_t> sequence;  // all frames up to this one were used
  std::uint64_t credits = 0;              // further frames allowed, on top
};

/// One record of the turtle stream.
struct TurtleStreamRecord {
  std::uint64_t index = 0;  // among all records of the frame, before the selection; `parent` is such an index
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::string_view symbol;
  std::array<double, 3> position{}, heading{}, left{}, up{};
  double width = 1.0;
  std::int32_t colour = 0;
  std::uint32_t branchOrder = 0;
  std::optional<std::uint64_t> parent;  // nothing: a root
  std::vector<double> parameters;
};

/// A frame of a stream. `body` has the members that depend on the stream: "records":[...], "string":"...",
/// "statistics":{...}, "geometry":{...}, "queries":[...],"replies":[...] or, in blocks, "count":n,"symbols":[...].
/// A difference has "kept" beside the records, "pieces" instead of the string, or "geometry" with runs.
struct StreamData {
  std::string stream;
  std::string simulation;
  std::uint64_t step = 0;
  std::uint64_t sequence = 0;  // 0, 1, 2, ... of the frames sent
  std::uint64_t missed = 0;    // frames left out since the one before
  bool isKey = true;           // complete in itself; else it refers to the frame sent before
  bool isFinished = false;     // the simulation will make no further step
  Body body;
};

// ---- environments ----

struct NeedsRecord {
  bool position = false, heading = false, left = false, up = false, width = false, scale = false;
  bool parameters = false, following = false, geometry = false;
  bool operator==(const NeedsRecord&) const = default;
};

struct VariableRecord {
  std::string name;
  std::string unit = "1";
  std::string type;  // empty: a number
};

struct OfferParams {
  std::string name;
};

struct DescribeResult {
  std::string name;
  std::string summary;
  NeedsRecord needs;
  std::vector<VariableRecord> inputs;
  std::vector<VariableRecord> outputs;
  bool isStateful = false;
  bool canCheckpoint = false;     // answers environment.save and environment.restore
  bool takesDifferences = false;  // of a geometry, instead of all of it in each step
};

struct OpenParams {
  std::string simulation;
  std::uint32_t plants = 1;
  std::vector<std::string> symbols;
  std::string configurationJson;  // text of an object; empty: none
  std::uint64_t seed = 0;
  std::optional<std::uint64_t>
      resumeStep;  // opened again in the middle of a run: completed steps; nothing: from the start
  WorldRecord world;
  std::optional<BoundsRecord> bounds;  // of the space that the plants may fill, where it is known
};

/// The queries of a step as columns; the row of a query is its id. A column that may be empty says so: then no query
/// has the value. The numbers live in `owner`; when it is null the caller keeps them alive.
struct QueryColumns {
  std::size_t count = 0;
  std::span<const std::uint32_t> plant;                 // (count)
  std::span<const std::uint64_t> module;                // index in the plant's string (count), or empty
  std::span<const std::uint8_t> isTransient;            // made by a homomorphism (count), or empty: none is
  std::span<const std::uint32_t> symbol;                // index in `symbols` (count)
  std::span<const std::uint64_t> offset;                // of each query's parameters (count + 1)
  std::span<const double> parameters;                   // concatenated
  std::span<const double> position, heading, left, up;  // (3 * count) each, or empty
  std::span<const double> width, scale;                 // (count) each, or empty
  std::span<const std::uint32_t> following;        // index in `symbols` of the next module, kNoSymbol: none; or empty
  std::span<const std::uint64_t> followingOffset;  // (count + 1), or empty
  std::span<const double> followingParameters;
  std::vector<std::string> symbols;
  std::shared_ptr<const void> owner;

  static constexpr std::uint32_t kNoSymbol = 0xFFFFFFFF;
};

struct EnvironmentStepParams {
  std::string simulation;
  std::uint64_t step = 0;  // completed steps when the queries were made
  std::uint32_t iteration = 0;
  double timeDays = 0.0;
  QueryColumns queries;
  std::optional<GeometryColumns> geometry;  // for an environment that needs it
};

/// The replies to a step as columns. The numbers live in `owner`; when it is null the caller keeps them alive.
struct ReplyColumns {
  std::size_t count = 0;
  std::span<const std::uint32_t> id;      // query that is answered (count); empty: reply i answers query i
  std::span<const std::uint64_t> offset;  // of each reply's values (count + 1)
  std::span<const double> values;         // concatenated
  std::span<const std::uint8_t> isSet;    // like values, 0: keeps what was sent; empty: all are set
  std::vector<std::string> notes;         // sentences for the user of the simulation
  std::shared_ptr<const void> owner;
};

struct RestoreStateParams {
  std::string simulation;
  std::string state;  // bytes (base64 on the wire)
};

}  // namespace espalier::protocol
