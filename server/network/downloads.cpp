#include "server/network/downloads.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "engine/simulation/view_drawing.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/field.h"
#include "environment/output/field_output.h"
#include "protocol/codec.h"
#include "server/remote/models/gallery.h"
#include "server/running/simulation_trace.h"
#include "server/running/turn_meter.h"
#include "server/server_core.h"

namespace espalier::server {
namespace {

constexpr std::string_view kRoot = "/simulations";
constexpr std::string_view kGallery = "/gallery/";
constexpr std::string_view kSnapshotSuffix = ".snapshot";
constexpr std::string_view kFieldSuffix = ".vti";
constexpr std::string_view kBytes = "application/octet-stream";

/// The download was larger than it may be.
struct TooLarge {};

/// Keeps up to so many bytes.
class BoundedSink final : public core::ByteSink {
 public:
  explicit BoundedSink(std::uint64_t bound) : bound_(bound) {}
  void write(std::string_view bytes) override {
    if (text_.size() + bytes.size() > bound_) {
      throw TooLarge{};
    }
    text_.append(bytes);
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::uint64_t bound_;
  std::string text_;
};

std::optional<std::string> decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    unsigned value = 0;
    if (i + 2 >= text.size()) {
      return std::nullopt;
    }
    const auto [end, problem] = std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
    if (problem != std::errc() || end != text.data() + i + 3) {
      return std::nullopt;
    }
    plain += static_cast<char>(value);
    i += 2;
  }
  return plain;
}

HttpPage problemPage(unsigned status, const std::string& message) {
  return {status, "text/plain; charset=utf-8", message + "\n", {}};
}

HttpPage filePage(std::string bytes, std::string fileName) {
  return {200, std::string(kBytes), std::move(bytes), std::move(fileName)};
}

HttpPage listPage(const ServerCore& core) {
  protocol::JsonWriter json;
  json.beginObject().key("simulations").beginArray();
  for (const auto& runner : core.all()) {
    write(json, runner->information());
  }
  return {200, "application/json", json.endArray().endObject().take() + "\n", {}};
}

std::string suffixes() {
  std::string list(kSnapshotSuffix);
  for (const turtle::ExportFormat& format : turtle::exportFormats()) {
    list += " " + std::string(format.suffix);
  }
  return list;
}

HttpPage exportPage(simulation::ViewDrawing& drawing, const std::string& name, BoundedSink& sink) {
  const turtle::ExportFormat* const format = turtle::findExportFormatOfFile(name);
  turtle::Scene scene;
  std::vector<turtle::TurtleRecord> records;
  if (format->source == turtle::ExportSource::Scene) {
    auto drawn = drawing.scene();
    if (!drawn) {
      return problemPage(500, drawn.error().message);
    }
    scene = std::move(*drawn);
  }
  const simulation::PlantsView& view = drawing.view();
  std::vector<const derivation::ModuleString*> strings;
  std::vector<const language::Program*> programs;
  for (std::size_t plant = 0; plant < view.plants.size(); ++plant) {
    strings.push_back(&view.plants[plant].string);
    programs.push_back(&view.program(plant));
  }
  const auto visitModules = [&drawing](const turtle::ModuleVisitor& visit) -> std::optional<std::string> {
    const auto failure = drawing.visitModules(visit);
    return failure ? std::optional(failure->message) : std::nullopt;
  };
  const turtle::ExportInput input{.scene = scene,
                                  .view = drawing.settings(),
                                  .palette = &view.options->palette,
                                  .program = programs.front(),
                                  .programs = programs,
                                  .strings = strings,
                                  .visitModules = visitModules};
  if (auto problem = format->write(input, {.fileName = name, .sink = sink, .openCompanion = {}, .progress = {}})) {
    return problemPage(500, "cannot write " + name + ": " + *problem);
  }
  return filePage(sink.take(), name);
}

std::vector<turtle::Field> fieldsOf(simulation::Simulation& simulation) {
  return simulation.environment() == nullptr ? std::vector<turtle::Field>{} : simulation.environment()->fields();
}

/// The fields of the environment, without their values.
HttpPage fieldsPage(simulation::Simulation& simulation) {
  protocol::JsonWriter json;
  json.beginObject().key("step").integer(simulation.completedSteps()).key("fields").beginArray();
  const auto triple = [&json](double x, double y, double z) {
    json.beginArray().number(x).number(y).number(z).endArray();
  };
  for (const turtle::Field& field : fieldsOf(simulation)) {
    const environment::FieldSummary summary = environment::summaryOf(field);
    json.beginObject().key("name").text(field.name).key("unit").text(field.unit).key("cells").beginArray();
    for (const std::size_t count : field.cells) {
      json.integer(std::uint64_t{count});
    }
    json.endArray().key("position");
    triple(field.position.x, field.position.y, field.position.z);
    json.key("cellSize");
    triple(field.cellSize.x, field.cellSize.y, field.cellSize.z);
    json.key("least").number(summary.minimum).key("greatest").number(summary.maximum).endObject();
  }
  return {200, "application/json", json.endArray().endObject().take() + "\n", {}};
}

HttpPage fieldPage(simulation::Simulation& simulation, const std::string& file, BoundedSink& sink) {
  const std::vector<turtle::Field> fields = fieldsOf(simulation);
  const std::string_view name = std::string_view(file).substr(0, file.size() - kFieldSuffix.size());
  const auto found =
      std::find_if(fields.begin(), fields.end(), [name](const turtle::Field& field) { return field.name == name; });
  if (found == fields.end()) {
    std::string known;
    for (const turtle::Field& field : fields) {
      known += (known.empty() ? "" : ", ") + field.name;
    }
    return problemPage(404, "The environment has no field '" + std::string(name) +
                                "'. Its fields: " + (known.empty() ? "none" : known) + ".");
  }
  sink.write(environment::writeVti(std::span(&*found, 1), simulation.options().world.lengthUnit));
  return filePage(sink.take(), file);
}

/// The page, on a worker that owns the simulation.
HttpPage pageFor(SimulationRunner& runner, const DownloadPath& path, std::uint64_t bound) {
  HostedSimulation& hosted = runner.hosted();
  BoundedSink sink(bound);
  switch (path.kind) {
    case DownloadPath::Kind::Snapshot:
      hosted.simulation().save(sink);
      return filePage(sink.take(), path.name);
    case DownloadPath::Kind::Checkpoint: {
      auto state = hosted.readCheckpoint(path.name);
      return state.problem.empty() ? filePage(std::move(state.bytes), path.simulation + std::string(kSnapshotSuffix))
                                   : problemPage(404, state.problem + ".");
    }
    case DownloadPath::Kind::Trace: {
      auto trace = hosted.readTrace(std::strtoul(path.name.c_str(), nullptr, 10), bound);
      return trace ? filePage(std::move(*trace), path.simulation + "-" + path.name + ".trace.zst")
                   : problemPage(404, "This simulation has no trace " + path.name +
                                          ", or the trace is larger than blockBytes.");
    }
    case DownloadPath::Kind::Fields:
      return fieldsPage(hosted.simulation());
    case DownloadPath::Kind::Field:
      return fieldPage(hosted.simulation(), path.name, sink);
    case DownloadPath::Kind::Export:
    case DownloadPath::Kind::List:
    case DownloadPath::Kind::Picture:
      break;
  }
  return problemPage(404, "There is no download of that name.");
}

/// The page with its bytes in the account, or a page that says why they do not fit.
HttpPage counted(HttpPage page, Account& account) {
  const std::size_t bytes = page.body.size();
  if (!account.take(MemoryKind::Frames, bytes)) {
    return problemPage(503, account.memoryError().message);
  }
  page.memory = std::shared_ptr<void>(
      nullptr, [&account, bytes](void*) { account.add(MemoryKind::Frames, -static_cast<std::int64_t>(bytes)); });
  return page;
}

/// The parts of a path between slashes, percent-decoded; nothing when one is empty.
std::optional<std::vector<std::string>> partsOf(std::string_view rest) {
  std::vector<std::string> parts;
  while (parts.size() < 4) {
    const std::size_t slash = rest.find('/');
    auto part = decoded(rest.substr(0, slash));
    if (!part || part->empty()) {
      return std::nullopt;
    }
    parts.push_back(std::move(*part));
    if (slash == std::string_view::npos) {
      break;
    }
    rest.remove_prefix(slash + 1);
  }
  return parts;
}

std::optional<DownloadPath> simulationPathOf(const std::vector<std::string>& parts) {
  if (parts.size() == 2 && parts[1] == "fields") {
    return DownloadPath{DownloadPath::Kind::Fields, parts[0], ""};
  }
  if (parts.size() == 2) {
    const bool isSnapshot = parts[1].ends_with(kSnapshotSuffix);
    return DownloadPath{isSnapshot ? DownloadPath::Kind::Snapshot : DownloadPath::Kind::Export, parts[0], parts[1]};
  }
  if (parts.size() != 3) {
    return std::nullopt;
  }
  const bool isNumber = std::all_of(parts[2].begin(), parts[2].end(), [](char c) { return c >= '0' && c <= '9'; });
  if (parts[1] == "fields" && parts[2].size() > kFieldSuffix.size() && parts[2].ends_with(kFieldSuffix)) {
    return DownloadPath{DownloadPath::Kind::Field, parts[0], parts[2]};
  }
  if (parts[1] == "checkpoints") {
    return DownloadPath{DownloadPath::Kind::Checkpoint, parts[0], parts[2]};
  }
  if (parts[1] == "traces" && isNumber && parts[2].size() < 10) {
    return DownloadPath{DownloadPath::Kind::Trace, parts[0], parts[2]};
  }
  return std::nullopt;
}

HttpPage picturePage(const ServerCore& core, const DownloadPath& path) {
  auto bytes = readGalleryPicture(core.options().galleryFolder, path.simulation, path.name);
  return bytes ? HttpPage{200, "image/png", std::move(*bytes), {}}
               : problemPage(404, "The gallery has no such picture. model.list names the pictures.");
}

/// A download of a simulation. It asks for one short turn. An export is then drawn from the state of that turn by a
/// worker of frames, while the simulation goes on; the account that downloads pays for it. Thread-safe.
class Download final : public std::enable_shared_from_this<Download> {
 public:
  Download(ServerCore& core, Account& account, DownloadPath path, std::function<void(HttpPage)> done)
      : core_(&core), account_(&account), path_(std::move(path)), done_(std::move(done)) {}
  ~Download() { account_->endDownload(); }

  void begin(const std::shared_ptr<SimulationRunner>& runner) {
    const auto command = std::make_shared<Command>();
    command->owner = owner();
    command->advance = [self = shared_from_this()](SimulationRunner& simulation, Command& turn) {
      if (!turn.isCancelled) {
        self->inTurn(simulation);
      }
      return false;
    };
    command->fail = [self = shared_from_this()](const protocol::Error& error) {
      self->done_(problemPage(503, error.message));
    };
    {
      const std::lock_guard lock(mutex_);
      runner_ = runner;
      command_ = command;
    }
    runner->submit(command);
  }

  /// Nobody waits for it any more.
  void giveUp() {
    std::shared_ptr<SimulationRunner> runner;
    std::shared_ptr<Command> command;
    {
      const std::lock_guard lock(mutex_);
      isGivenUp_ = true;
      runner = runner_.lock();
      command = command_.lock();
      stopWork();
    }
    if (runner != nullptr && command != nullptr) {
      runner->cancel(command);
    }
  }

 private:
  [[nodiscard]] std::string owner() const { return "http " + account_->owner(); }
  [[nodiscard]] std::uint64_t bound() const { return core_->limits().blockBytes; }

  void inTurn(SimulationRunner& runner) {
    if (path_.kind != DownloadPath::Kind::Export) {
      done_(guarded([&] { return pageFor(runner, path_, bound()); }));
      return;
    }
    core_->pool().post(
        {.run = [self = shared_from_this(), view = runner.hosted().simulation().takeView()] { self->draw(view); },
         .lane = Lane::Frame,
         .owner = owner(),
         .limit = std::chrono::seconds(core_->limits().callSeconds),
         .onLimit = [self = shared_from_this()] { self->stopAtLimit(); }});
  }

  void draw(const std::shared_ptr<const simulation::PlantsView>& view) {
    TurnMeter meter(*account_, MemoryKind::Frames);
    if (!setMeter(&meter)) {
      return;
    }
    HttpPage page;
    {
      const core::WorkMeter::Scope scope(&meter);
      simulation::ViewDrawing drawing;
      page = guarded([&] {
        drawing.show(view);
        BoundedSink sink(bound());
        return exportPage(drawing, path_.name, sink);
      });
    }
    (void)setMeter(nullptr);
    done_(std::move(page));
  }

  /// The page that `make` makes, or one that says why it could not.
  HttpPage guarded(const std::function<HttpPage()>& make) {
    try {
      return make();
    } catch (const TooLarge&) {
      return problemPage(413, "the limit 'blockBytes' is " + std::to_string(bound()) +
                                  ", and this is larger. Export less, or start the server with a higher --limit "
                                  "blockBytes=N.");
    } catch (const core::WorkStopped&) {
      return problemPage(503,
                         "This takes longer than callSeconds allows, or more memory than the account has. Export "
                         "less.");
    } catch (const std::bad_alloc&) {
      return problemPage(503, "There is not enough memory for this. Export less.");
    } catch (const std::exception& exception) {
      return problemPage(500, std::string("This failed: ") + exception.what() + ".");
    }
  }

  /// False: it was given up before.
  [[nodiscard]] bool setMeter(TurnMeter* meter) {
    const std::lock_guard lock(mutex_);
    meter_ = meter;
    return !isGivenUp_;
  }
  void stopWork() {  // with mutex_ held
    if (meter_ != nullptr) {
      meter_->stop();
    }
  }
  void stopAtLimit() {
    const std::lock_guard lock(mutex_);
    stopWork();
  }

  ServerCore* core_;
  Account* account_;
  const DownloadPath path_;
  const std::function<void(HttpPage)> done_;
  std::mutex mutex_;
  bool isGivenUp_ = false;
  TurnMeter* meter_ = nullptr;  // of the export that is drawn
  std::weak_ptr<SimulationRunner> runner_;
  std::weak_ptr<Command> command_;
};

}  // namespace

std::optional<DownloadPath> downloadPathOf(std::string_view target) {
  target = target.substr(0, target.find('?'));
  if (target == kRoot) {
    return DownloadPath{};
  }
  const bool isOfGallery = target.starts_with(kGallery);
  if (!isOfGallery && (!target.starts_with(kRoot) || target[kRoot.size()] != '/')) {
    return std::nullopt;
  }
  const auto parts = partsOf(target.substr(isOfGallery ? kGallery.size() : kRoot.size() + 1));
  if (!parts) {
    return std::nullopt;
  }
  if (isOfGallery) {
    return parts->size() == 2 ? std::optional(DownloadPath{DownloadPath::Kind::Picture, (*parts)[0], (*parts)[1]})
                              : std::nullopt;
  }
  return simulationPathOf(*parts);
}

std::function<void()> makeDownload(ServerCore& core, Account& account, const DownloadPath& path,
                                   std::function<void(HttpPage)> use) {
  constexpr std::uint64_t kMostDownloads = 8;  // of an account at a time: each may keep a state in memory
  const auto nothing = [] {};
  const auto done = [&account, use = std::move(use)](HttpPage page) { use(counted(std::move(page), account)); };
  if (path.kind == DownloadPath::Kind::List) {
    core.pool().post({.run = [&core, done] { done(listPage(core)); }, .owner = "http"});
    return nothing;
  }
  if (path.kind == DownloadPath::Kind::Picture) {
    core.pool().post({.run = [&core, path, done] { done(picturePage(core, path)); }, .owner = "http"});
    return nothing;
  }
  const auto runner = core.find(path.simulation);
  if (runner == nullptr) {
    done(problemPage(404, "There is no simulation '" + path.simulation + "'. GET /simulations lists them."));
    return nothing;
  }
  if (path.kind == DownloadPath::Kind::Export && turtle::findExportFormatOfFile(path.name) == nullptr) {
    done(problemPage(404, "'" + path.name + "' names no format. Suffixes: " + suffixes() + "."));
    return nothing;
  }
  if (const auto problem = account.cpuProblem()) {
    done(problemPage(503, problem->message));
    return nothing;
  }
  if (!account.beginDownload(kMostDownloads)) {
    done(problemPage(503, "This account downloads " + std::to_string(kMostDownloads) +
                              " files now, and no more at a time. Ask again when one has come."));
    return nothing;
  }
  const auto download = std::make_shared<Download>(core, account, path, done);
  download->begin(runner);
  return [download] { download->giveUp(); };
}

tl::expected<Grant, std::string> downloadGrant(std::string_view authorization, const Access& access) {
  constexpr std::string_view kScheme = "Bearer ";
  const bool hasToken = authorization.starts_with(kScheme);
  auto grant = access.grant(hasToken ? authorization.substr(kScheme.size()) : std::string_view(), {"viewer"});
  if (!grant && !hasToken) {
    return tl::unexpected(std::string("Downloads need a token of the server: Authorization: Bearer TOKEN."));
  }
  return grant;
}

}  // namespace espalier::server
