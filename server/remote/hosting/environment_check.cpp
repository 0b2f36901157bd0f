#include "server/remote/hosting/environment_check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/simulation/trace.h"
#include "engine/turtle/scene/geometry.h"
#include "server/remote/channel_link.h"
#include "server/remote/remote_process.h"
#include "server/remote/trace_file.h"

namespace espalier::server {
namespace {

using turtle::QueryBatch;
using turtle::ReplyBatch;

// for the steps of one size
constexpr std::chrono::seconds kMeasuredSeconds{5};
// an interpreter starts slowly on a busy machine; a program that never answers hello is rare, and its author waits
constexpr std::chrono::milliseconds kLongestIntroduction{20'000};

/// Queries at different places, all with as many parameters. Every coordinate has all its digits.
QueryBatch makeQueries(std::size_t count, std::size_t parameterCount, std::uint64_t step) {
  QueryBatch batch;
  batch.step = step;
  batch.timeDays = static_cast<double>(step);
  batch.parameterOffset.push_back(0);
  batch.followingOffset.push_back(0);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 0.7 * static_cast<double>(i);
    batch.plant.push_back(static_cast<std::uint32_t>(i % 2));
    batch.module.push_back(3 * i);
    batch.symbol.push_back(0);
    batch.isTransient.push_back(0);
    batch.position.push_back({core::sin(angle), 0.1 + std::sqrt(static_cast<double>(i)), core::cos(angle)});
    batch.heading.push_back({core::sin(angle), core::cos(angle), 0.0});
    batch.left.push_back({-core::cos(angle), core::sin(angle), 0.0});
    batch.up.push_back({0.0, 0.0, -1.0});
    batch.width.push_back(1.0);
    batch.scale.push_back(1.0);
    for (std::size_t k = 0; k < parameterCount; ++k) {
      batch.parameters.push_back(0.5 + 0.1 * static_cast<double>(k));
    }
    batch.parameterOffset.push_back(batch.parameters.size());
    batch.following.push_back(i % 3 == 0 ? core::SymbolId{1} : core::kNoSymbol);
    if (i % 3 == 0) {
      batch.followingParameters.push_back(1.0);
    }
    batch.followingOffset.push_back(batch.followingParameters.size());
  }
  return batch;
}

template <typename T>
void reverse(std::vector<T>& column) {
  std::reverse(column.begin(), column.end());
}

/// The same queries from the last to the first.
QueryBatch reversed(const QueryBatch& before) {
  QueryBatch batch = before;
  reverse(batch.plant);
  reverse(batch.module);
  reverse(batch.symbol);
  reverse(batch.position);
  reverse(batch.heading);
  reverse(batch.left);
  reverse(batch.up);
  // the next modules have rows of different lengths
  std::vector<double> followingParameters;
  std::vector<std::uint64_t> followingOffset{0};
  std::vector<core::SymbolId> following;
  for (std::size_t i = batch.size(); i > 0; --i) {
    following.push_back(before.following[i - 1]);
    for (const double value : before.followingParametersOf(i - 1)) {
      followingParameters.push_back(value);
    }
    followingOffset.push_back(followingParameters.size());
  }
  batch.following = std::move(following);
  batch.followingOffset = std::move(followingOffset);
  batch.followingParameters = std::move(followingParameters);
  return batch;
}

bool isSame(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// A leaf behind each module that asks, and a stem below it.
std::shared_ptr<const turtle::Geometry> makeGeometry(const QueryBatch& queries) {
  auto geometry = std::make_shared<turtle::Geometry>();
  const auto add = [&queries](turtle::GeometrySources& sources, std::size_t query) {
    sources.plant.push_back(queries.plant[query]);
    sources.module.push_back(queries.module[query] + 1);
    sources.symbol.push_back(1);
    sources.colour.push_back(2);
    sources.branchOrder.push_back(0);
  };
  for (std::size_t query = 0; query < queries.size(); ++query) {
    const core::Vec3 base = queries.position.empty() ? core::Vec3{} : queries.position[query];
    add(geometry->segments, query);
    geometry->start.push_back(base - core::Vec3{0.0, 1.0, 0.0});
    geometry->end.push_back(base);
    geometry->startWidth.push_back(0.02);
    geometry->endWidth.push_back(0.01);
    add(geometry->organs, query);
    geometry->kind.push_back(turtle::GeometryKind::Polygon);
    const auto first = static_cast<std::uint32_t>(geometry->vertices.size());
    geometry->vertices.insert(geometry->vertices.end(),
                              {base, base + core::Vec3{0.1, 0.0, 0.0}, base + core::Vec3{0.0, 0.05, 0.1}});
    geometry->triangles.push_back({first, first + 1, first + 2});
    geometry->vertexOffset.push_back(geometry->vertices.size());
    geometry->triangleOffset.push_back(geometry->triangles.size());
  }
  return geometry;
}

class Checker {
 public:
  Checker(const EnvironmentCheckOptions& options, const std::function<void(const std::string&)>& print)
      : options_(options), print_(print) {}

  bool run() {
    if (!connect()) {
      return false;
    }
    describe();
    if (open()) {
      checkShapes();
      checkRepetition();
      checkOrder();
      checkNotFinite();
      checkState();
      measure();
    }
    if (options_.trace != nullptr) {
      compareWithTrace();
    }
    print_(isRight_ ? "all is right" : "not all is right");
    return isRight_;
  }

 private:
  void good(const std::string& what) { print_("ok    " + what); }
  void note(const std::string& what) { print_("note  " + what); }
  void bad(const std::string& what) {
    print_("wrong " + what);
    isRight_ = false;
  }

  bool connect() {
    constexpr std::string_view kTcp = "tcp://";
    constexpr std::string_view kStdio = "stdio:";
    constexpr std::string_view kUnix = "unix:";
    const std::string& address = options_.address;
    ChannelOptions channel;
    channel.introductionTimeout = std::min(options_.stepTimeout, kLongestIntroduction);
    if (address.starts_with(kTcp)) {
      link_ = ChannelLink::tcp(address.substr(kTcp.size()), channel);
    } else if (address.starts_with(kUnix)) {
      link_ = ChannelLink::unixSocket(address.substr(kUnix.size()), channel);
    } else if (address.starts_with(kStdio)) {
      link_ = ChannelLink::stdio(address.substr(kStdio.size()), channel);
    } else {
      bad("'" + address +
          "' does not name an environment in another process. Write tcp://HOST:PORT, unix:PATH, stdio:COMMAND, or "
          "the file of a plug-in (.so). `espalier environment NAME --describe` describes a built-in environment.");
      return false;
    }
    RemoteProcessOptions options;
    options.stepTimeout = options_.stepTimeout;
    options.introductionTimeout = channel.introductionTimeout;
    options.configurationJson = options_.configurationJson;
    process_ = std::make_unique<RemoteProcess>(link_, std::move(options));
    if (const auto error = process_->introduce()) {
      bad("connect: " + error->message);
      return false;
    }
    const PeerTerms terms = link_->terms();
    good(std::string("connect: it takes ") + (terms.takesBlocks ? "text and binary blocks" : "text only"));
    return true;
  }

  void describe() {
    description_ = process_->describe();
    if (!process_->isDescribed()) {
      bad("describe: environment.describe is not answered; it is sent everything and taken for one without state");
      return;
    }
    std::string needs;
    const turtle::EnvironmentNeeds& n = description_.needs;
    for (const auto& [isNeeded, name] : {std::pair{n.position, "position"},
                                         {n.heading, "heading"},
                                         {n.left, "left"},
                                         {n.up, "up"},
                                         {n.width, "width"},
                                         {n.scale, "scale"},
                                         {n.parameters, "parameters"},
                                         {n.following, "following"},
                                         {n.geometry, "geometry"}}) {
      needs += isNeeded ? (needs.empty() ? "" : " ") + std::string(name) : "";
    }
    good("describe: " + description_.name + ", needs " + (needs.empty() ? "nothing" : needs) +
         (description_.isStateful ? ", has state" : ", has no state"));
    for (const auto* list : {&description_.inputs, &description_.outputs}) {
      for (const turtle::EnvironmentVariable& variable : *list) {
        const std::string what = (list == &description_.inputs ? "input '" : "output '") + variable.name + "'";
        if (variable.name.empty() || variable.unit.empty()) {
          bad("units: " + what + " has no " + (variable.name.empty() ? "name" : "unit; write \"1\" for none"));
        } else {
          good("units: " + what + " in " + (variable.unit == "1" ? "no unit" : variable.unit));
        }
      }
    }
  }

  [[nodiscard]] std::size_t parameterCount() const {
    return std::max<std::size_t>({1, description_.inputs.size(), description_.outputs.size()});
  }

  bool open() {
    context_ = {.simulation = "check", .plantCount = 2, .symbols = {"E", "F"}, .seed = 7, .world = {}};
    if (const auto error = process_->open(context_)) {
      bad("open: " + error->message);
      return false;
    }
    good("open");
    return true;
  }

  /// Adds geometry to queries for an environment that asks for it.
  void addGeometry(QueryBatch& queries) const {
    if (description_.needs.geometry && queries.geometry == nullptr) {
      queries.geometry = makeGeometry(queries);
    }
  }

  /// The replies to a batch, or nothing with the failure told.
  std::optional<ReplyBatch> ask(QueryBatch queries, const std::string& what) {
    ReplyBatch replies;
    replies.prepare(queries);
    addGeometry(queries);
    if (const auto error = process_->step(queries, replies)) {
      bad(what + ": " + error->message);
      return std::nullopt;
    }
    return replies;
  }

  /// The replies of the first step after a fresh open.
  std::optional<ReplyBatch> askFresh(const QueryBatch& queries, const std::string& what) {
    if (const auto error = process_->open(context_)) {
      bad(what + ": it cannot be opened again: " + error->message);
      return std::nullopt;
    }
    return ask(queries, what);
  }

  void checkShapes() {
    for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{1'000}}) {
      const QueryBatch queries = makeQueries(count, parameterCount(), 0);
      const auto replies = askFresh(queries, "shapes");
      if (!replies) {
        return;
      }
      if (replies->surplusCount > 0) {
        bad("shapes: " + std::to_string(replies->surplusCount) + " values more than the queries have parameters (" +
            std::to_string(parameterCount()) + ", as inputs and outputs say); they are dropped in a simulation");
        return;
      }
      if (count == 7) {
        if (replies->answeredCount == 0) {
          note("shapes: none of 7 queries was answered, so modules keep their values; is a 'return' missing?");
        } else {
          good("shapes: " + std::to_string(replies->answeredCount) + " of 7 queries answered, no value too many");
        }
      }
    }
    // a step without queries
    if (description_.isStateful) {
      if (const auto error = process_->tick(1)) {
        bad("shapes: a step without queries fails: " + error->message);
      }
    }
  }

  /// Compares replies query by query; `other` may be in another order.
  bool agree(const std::string& what, const QueryBatch& queries, const ReplyBatch& first, const ReplyBatch& second,
             bool isReversed, const std::string& advice) {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t other = isReversed ? queries.size() - 1 - query : query;
      for (std::uint64_t k = 0; k < queries.parameterOffset[query + 1] - queries.parameterOffset[query]; ++k) {
        const std::uint64_t a = queries.parameterOffset[query] + k;
        const std::uint64_t b = queries.parameterOffset[other] + k;
        if (first.isSet[a] != second.isSet[b] || !isSame(first.values[a], second.values[b])) {
          bad(what + ": query " + std::to_string(query) + " got " + std::to_string(first.values[a]) + " as value " +
              std::to_string(k + 1) + ", then " + std::to_string(second.values[b]) + ". " + advice);
          return false;
        }
      }
    }
    good(what);
    return true;
  }

  void checkRepetition() {
    const QueryBatch queries = makeQueries(100, parameterCount(), 0);
    const auto first = askFresh(queries, "repetition");
    const auto again = first ? ask(queries, "repetition") : std::nullopt;
    if (again) {
      agree("the same step sent again gets the same replies", queries, *first, *again, false,
            "A step is idempotent by (step, iteration): keep the replies of the last one.");
    }
    const auto fresh = askFresh(queries, "repetition");
    if (first && fresh) {
      agree("opened again with the same seed it gives the same replies", queries, *first, *fresh, false,
            "Take random numbers from the seed of environment.open only.");
    }
  }

  void checkOrder() {
    const QueryBatch queries = makeQueries(100, parameterCount(), 0);
    const auto first = askFresh(queries, "order");
    const auto second = askFresh(reversed(queries), "order");
    if (first && second) {
      agree("replies do not depend on the order of the queries", queries, *first, *second, true,
            "Answer all queries from the state before the step, and add sums up in an order of your own.");
    }
  }

  void checkNotFinite() {
    if (const auto error = process_->open(context_)) {
      return;
    }
    const std::string params =
        R"({"simulation":"check","step":0,"iteration":0,"time":0,"queries":[{"id":0,"plant":0,"module":0,)"
        R"("symbol":"E","parameters":[NaN],"position":[NaN,0,0]}]})";
    const auto outcome = link_->call("environment.step", params, options_.stepTimeout);
    if (outcome) {
      bad("not finite: a query with NaN got a reply; refuse a line that is not JSON with error -32700");
    } else if (outcome.error().kind != LinkFailure::Kind::Refused) {
      bad("not finite: a query with NaN: it " + outcome.error().message + "; answer with an error and go on");
    } else {
      good("a query with NaN is refused");
    }
    QueryBatch huge = makeQueries(1, parameterCount(), 0);
    huge.position[0] = {1e300, -1e300, 1e300};
    ReplyBatch replies;
    replies.prepare(huge);
    if (process_->open(context_)) {
      bad("not finite: after it, it cannot be opened again");
      return;
    }
    addGeometry(huge);
    const auto error = process_->step(huge, replies);
    const bool isFinite =
        std::all_of(replies.values.begin(), replies.values.end(), [](double value) { return std::isfinite(value); });
    if (error && link_->generation() == 0) {
      bad("huge numbers: " + error->message);
    } else if (!isFinite) {
      bad("huge numbers: a reply is not finite");
    } else {
      good("huge numbers are answered or refused, and it goes on");
    }
  }

  void checkState() {
    if (!description_.isStateful) {
      return;
    }
    if (process_->open(context_)) {
      return;
    }
    const auto before = ask(makeQueries(50, parameterCount(), 0), "state");
    const std::string state = before ? process_->save() : std::string();
    if (state.empty()) {
      bad("state: it has state and does not save it; answer environment.save and restore, and say checkpoint:true");
      return;
    }
    const QueryBatch next = makeQueries(50, parameterCount(), 1);
    const auto first = ask(next, "state");
    if (const auto error = process_->restore(state)) {
      bad("state: " + error->message);
      return;
    }
    const auto second = ask(next, "state");
    if (first && second) {
      agree("after restoring its state it goes on as before", next, *first, *second, false,
            "environment.save must hold everything that changes from step to step.");
    }
  }

  void measure() {
    print_("      queries   median ms      99 % ms   queries/s");
    for (const std::size_t count : {std::size_t{1}, std::size_t{100}, std::size_t{10'000}}) {
      const std::size_t repetitions = count < 10'000 ? 100 : 20;
      std::vector<double> milliseconds;
      if (process_->open(context_)) {
        return;
      }
      // a slow one is not measured for minutes
      const auto end = std::chrono::steady_clock::now() + kMeasuredSeconds;
      for (std::size_t i = 0; i < repetitions && (i == 0 || std::chrono::steady_clock::now() < end); ++i) {
        QueryBatch queries = makeQueries(count, parameterCount(), i);
        addGeometry(queries);
        ReplyBatch replies;
        replies.prepare(queries);
        const auto start = std::chrono::steady_clock::now();
        if (const auto error = process_->step(queries, replies)) {
          bad("latency: " + error->message);
          return;
        }
        milliseconds.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
      }
      std::sort(milliseconds.begin(), milliseconds.end());
      const double median = milliseconds[milliseconds.size() / 2];
      char line[100];
      std::snprintf(line, sizeof(line), "      %7zu %11.3f %12.3f %11.0f", count, median,
                    milliseconds[milliseconds.size() * 99 / 100], static_cast<double>(count) / median * 1e3);
      print_(line);
    }
  }

  /// The run is made again, so that its plants can be shown: a trace has the questions and not the geometry.
  void compareWithReplay() {
    std::size_t steps = 0;
    std::size_t queries = 0;
    bool goesOn = true;
    simulation::ReplayWitness witness;
    witness.needsGeometry = true;
    witness.opened = [this, &goesOn](const turtle::EnvironmentContext& context) {
      if (const auto error = goesOn ? process_->open(context) : std::nullopt) {
        bad("trace: " + error->message);
        goesOn = false;
      }
    };
    witness.asked = [&](const QueryBatch& asked, const ReplyBatch& recorded) {
      if (goesOn) {
        ++steps;
        queries += asked.size();
        goesOn = repliesAsRecorded(asked, recorded);
      }
    };
    const auto replayed = simulation::replayTrace(*options_.trace, maximumTraceEventBytes(), 1, witness);
    if (!replayed) {
      bad("trace: " + replayed.error());
    } else if (const auto& divergence = replayed->divergence) {
      bad("trace: " + divergence->message);
    } else if (goesOn) {
      good("trace: the same replies to " + std::to_string(queries) + " queries in " + std::to_string(steps) +
           " steps as recorded");
    }
  }

  void compareWithTrace() {
    if (description_.needs.geometry) {
      compareWithReplay();
      return;
    }
    simulation::TraceReader reader(*options_.trace, maximumTraceEventBytes());
    std::size_t steps = 0;
    std::size_t queries = 0;
    while (true) {
      auto read = reader.next();
      if (!read) {
        bad("trace: " + read.error());
        return;
      }
      const auto& event = *read;
      if (!event) {
        good("trace: the same replies to " + std::to_string(queries) + " queries in " + std::to_string(steps) +
             " steps as recorded");
        return;
      }
      if (event->kind == simulation::TraceEventKind::Start) {
        if (const auto error = process_->open(event->context)) {
          bad("trace: " + error->message);
          return;
        }
      } else if (event->kind == simulation::TraceEventKind::Tick) {
        if (const auto error = process_->tick(event->step)) {
          bad("trace: " + error->message);
          return;
        }
      } else if (event->kind == simulation::TraceEventKind::Step) {
        ++steps;
        queries += event->queries.size();
        if (!repliesAsRecorded(event->queries, event->replies)) {
          return;
        }
      }
    }
  }

  bool repliesAsRecorded(const QueryBatch& asked, const ReplyBatch& recorded) {
    ReplyBatch replies;
    replies.prepare(asked);
    if (const auto error = process_->step(asked, replies)) {
      bad("trace: " + error->message);
      return false;
    }
    for (std::size_t query = 0; query < asked.size(); ++query) {
      for (std::uint64_t k = asked.parameterOffset[query]; k < asked.parameterOffset[query + 1]; ++k) {
        if (replies.isSet[k] != recorded.isSet[k] ||
            (replies.isSet[k] != 0 && !isSame(replies.values[k], recorded.values[k]))) {
          bad("trace: step " + std::to_string(asked.step) + ", plant " + std::to_string(asked.plant[query]) +
              ", module " + std::to_string(asked.module[query]) + ": value " +
              std::to_string(k - asked.parameterOffset[query] + 1) + " is " +
              (replies.isSet[k] != 0 ? std::to_string(replies.values[k]) : "not set") + ", it was " +
              (recorded.isSet[k] != 0 ? std::to_string(recorded.values[k]) : "not set"));
          return false;
        }
      }
    }
    return true;
  }

  const EnvironmentCheckOptions& options_;
  const std::function<void(const std::string&)>& print_;
  std::shared_ptr<EnvironmentLink> link_;
  std::unique_ptr<RemoteProcess> process_;
  turtle::EnvironmentDescription description_;
  turtle::EnvironmentContext context_;
  bool isRight_ = true;
};

}  // namespace

bool checkEnvironment(const EnvironmentCheckOptions& options, const std::function<void(const std::string&)>& print) {
  return Checker(options, print).run();
}

}  // namespace espalier::server
