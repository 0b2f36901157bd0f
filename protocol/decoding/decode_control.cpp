#include <algorithm>
#include <array>

#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/decoding/decode_payload.h"
#include "protocol/decoding/forest_members.h"

namespace espalier::protocol {
namespace {

// of iterated coupling: answers that change after so many will not settle
constexpr std::int64_t kMostIterations = 10'000;

/// Whether a text has the form of the identifiers that servers draw.
bool isSimulationName(std::string_view text) {
  constexpr std::string_view kPrefix = "sim-";
  constexpr std::size_t kDigits = 12;
  return text.size() == kPrefix.size() + kDigits && text.starts_with(kPrefix) &&
         text.find_first_not_of("0123456789abcdef", kPrefix.size()) == std::string_view::npos;
}

constexpr double kMinimumHertz = 0.001;
constexpr double kMaximumHertz = 1000.0;

std::vector<std::string> readTexts(const Member& member) {
  std::vector<std::string> texts;
  if (member.isAbsent()) {
    return texts;
  }
  const std::size_t count = member.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    texts.push_back(member.element(i).text());
  }
  return texts;
}

template <typename T>
void readOptionalCount(const Member& member, std::optional<T>& value) {
  if (!member.isAbsent()) {
    value = member.count();
  }
}

// files of a model: texts, and bytes in base64
void readFiles(const Member& member, std::map<std::string, std::string>& contents) {
  const Member files = member["files"];
  files.requireObject();
  for (const auto& [name, value] : files.json().items()) {
    contents.emplace(name, files[name].text());
  }
  if (const Member bytes = member["binaryFiles"]; !bytes.isAbsent()) {
    bytes.requireObject();
    for (const auto& [name, value] : bytes.json().items()) {
      auto content = fromBase64(bytes[name].text());
      if (!content) {
        bytes[name].failExpected("base64");
      }
      contents.insert_or_assign(name, std::move(*content));
    }
  }
}

void readModelFolder(const Member& member, ModelReference& model) {
  readFiles(member, model.files);
  if (const Member main = member["main"]; !main.isAbsent()) {
    model.main = readName(main);
    // FILE, or FILE:ENTRY
    if (!model.files.contains(model.main) && !model.files.contains(model.main.substr(0, model.main.find(':')))) {
      main.fail("'" + model.main + "' is not one of the files");
    }
  }
}

void readModelReference(const Member& member, ModelReference& model) {
  // a text is short for {"loaded": TEXT}
  if (member.isText()) {
    model.loaded = readName(member);
    return;
  }
  member.requireObject();
  int count = 0;
  if (const Member source = member["source"]; !source.isAbsent()) {
    model.source = source.text();
    ++count;
  }
  if (const Member gallery = member["gallery"]; !gallery.isAbsent()) {
    model.gallery = readName(gallery);
    ++count;
  }
  if (const Member loaded = member["loaded"]; !loaded.isAbsent()) {
    model.loaded = readName(loaded);
    ++count;
  }
  if (!member["files"].isAbsent()) {
    readModelFolder(member, model);
    ++count;
  }
  if (count != 1) {
    member.fail("expected exactly one of \"source\", \"gallery\", \"files\" and \"loaded\"");
  }
}

/// NAME: number or text, each as text.
void readValues(const Member& parameters, std::vector<std::pair<std::string, std::string>>& values) {
  parameters.requireObject();
  for (const auto& [name, value] : parameters.json().items()) {
    const Member member = parameters[name];
    if (member.isText()) {
      values.emplace_back(name, member.text());
    } else {
      const double number = member.number();
      JsonWriter text;
      values.emplace_back(name, text.number(number).take());
    }
  }
}

void readModelParams(const Member& params, ModelParams& model) {
  // model.check {source} is short for model.check {model:{source}}
  const Member reference = params["model"];
  if (reference.isAbsent() &&
      (!params["source"].isAbsent() || !params["gallery"].isAbsent() || !params["files"].isAbsent())) {
    readModelReference(params, model.model);
  } else {
    readModelReference(reference, model.model);
  }
  if (const Member mode = params["compatibility"]; !mode.isAbsent()) {
    model.compatibility = mode.text();
    if (model.compatibility != "cpfg" && model.compatibility != "cpfg-batch") {
      mode.failExpected("\"cpfg\" or \"cpfg-batch\" (or nothing for Espalier's own mode)");
    }
  }
  if (const Member parameters = params["parameters"]; !parameters.isAbsent()) {
    readValues(parameters, model.defines);
  }
}

void readEnvironment(const Member& environment, CreateParams& create) {
  if (environment.isAbsent()) {
    return;
  }
  const std::size_t count = environment.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Member entry = environment.element(i);
    entry.requireObject();
    create.environmentTypes.push_back(readName(entry["type"]));
  }
  if (count > 0) {
    create.environmentJson = environment.dump();
  }
}

void readLimits(const Member& member, std::vector<std::pair<std::string, std::uint64_t>>& limits) {
  if (member.isObject()) {
    for (const auto& [name, value] : member.json().items()) {
      limits.emplace_back(name, member[name].count());
    }
  }
}

void readSelection(const Member& select, StreamSelection& selection) {
  if (select.isAbsent()) {
    return;
  }
  select.requireObject();
  selection.symbols = readTexts(select["symbols"]);
  if (const Member plants = select["plants"]; !plants.isAbsent()) {
    const std::size_t count = plants.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      selection.plants.push_back(static_cast<std::uint32_t>(plants.element(i).integer(0, 0xFFFFFFFF)));
    }
  }
}

}  // namespace

Expected<HelloParams> decodeHelloParams(const Payload& payload) {
  return decodePayload<HelloParams>(payload, [](const Member& params, HelloParams& hello) {
    params.requireObject();
    const Member versions = params["protocol"];
    const std::size_t count = versions.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      hello.protocol.push_back(versions.element(i).integer(0, kMaximumExactInteger));
    }
    hello.roles = readTexts(params["roles"]);
    for (std::size_t i = 0; i < hello.roles.size(); ++i) {
      const std::string& role = hello.roles[i];
      if (role != "controller" && role != "environment" && role != "viewer") {
        const Member roles = params["roles"];
        roles.element(i).failExpected("\"controller\", \"environment\" or \"viewer\"");
      }
    }
    hello.name = params["name"].textOrEmpty();
    hello.version = params["version"].textOrEmpty();
    hello.token = params["token"].textOrEmpty();
    hello.capabilities = readTexts(params["capabilities"]);
    readLimits(params["limits"], hello.limits);
  });
}

Expected<ModelParams> decodeModelParams(const Payload& payload) {
  return decodePayload<ModelParams>(payload, [](const Member& params, ModelParams& model) {
    params.requireObject();
    readModelParams(params, model);
  });
}

namespace {

SavePolicy readSavePolicy(const Member& save) {
  if (save.isText()) {
    if (save.text() != "request") {
      save.failExpected("true, false, a number of steps or \"request\"");
    }
    return {.isKept = true, .every = 0};
  }
  if (save.json().is_number()) {
    return {.isKept = true, .every = static_cast<std::uint64_t>(save.integer(1, kMaximumExactInteger))};
  }
  return {.isKept = save.boolean(), .every = 1};
}

}  // namespace

Expected<CreateParams> decodeCreateParams(const Payload& payload) {
  return decodePayload<CreateParams>(payload, [](const Member& params, CreateParams& create) {
    params.requireObject();
    if (params["models"].isAbsent()) {
      readModelParams(params, create.model);
    } else {
      if (!params["model"].isAbsent()) {
        params["models"].fail("give \"model\" or \"models\", not both");
      }
      readModels(params, readModelParams, create.models);
    }
    if (const Member simulation = params["simulation"]; !simulation.isAbsent()) {
      create.simulation = simulation.text();
      if (!isSimulationName(create.simulation)) {
        simulation.failExpected("an identifier that a server gave, as sim-5d03a1c7e2b4");
      }
    }
    create.name = params["name"].textOrEmpty();
    readOptionalCount(params["seed"], create.seed);
    readEnvironment(params["environment"], create);
    readOptionalCount(params["derivationLength"], create.derivationLength);
    readPlants(params["plants"], create.models, create.plants);
    readSeeds(params["seeds"], create.seeds);
    if (const Member limits = params["limits"]; !limits.isAbsent()) {
      limits.requireObject();
      readOptionalCount(limits["modules"], create.maximumModules);
      readOptionalCount(limits["queries"], create.maximumQueries);
    }
    if (const Member coupling = params["coupling"]; !coupling.isAbsent()) {
      coupling.requireObject();
      create.iterations = static_cast<std::uint32_t>(coupling["iterations"].integer(1, kMostIterations));
      if (const Member tolerance = coupling["tolerance"]; !tolerance.isAbsent()) {
        create.tolerance = tolerance.number();
        if (create.tolerance < 0.0) {
          tolerance.failExpected("a number from 0 on");
        }
      }
    }
    create.bounds = readBounds(params);
    if (const Member world = params["world"]; !world.isAbsent()) {
      create.world = readOwnWorld(world);
    }
    create.isTraced = !params["trace"].isAbsent() && params["trace"].boolean();
    create.countsProductions = !params["countProductions"].isAbsent() && params["countProductions"].boolean();
    if (const Member save = params["save"]; !save.isAbsent()) {
      create.save = readSavePolicy(save);
    }
  });
}

Expected<StepParams> decodeStepParams(const Payload& payload) {
  return decodePayload<StepParams>(payload, [](const Member& params, StepParams& step) {
    params.requireObject();
    step.simulation = readName(params["simulation"]);
    readOptionalCount(params["until"], step.until);
    step.wantsProgress = !params["progress"].isAbsent() && params["progress"].boolean();
    if (const Member steps = params["steps"]; !steps.isAbsent()) {
      if (step.until) {
        steps.fail("give \"steps\" or \"until\", not both");
      }
      step.steps = static_cast<std::uint64_t>(steps.integer(1, kMaximumExactInteger));
    }
  });
}

Expected<EditParams> decodeEditParams(const Payload& payload) {
  return decodePayload<EditParams>(payload, [](const Member& params, EditParams& edit) {
    params.requireObject();
    edit.simulation = readName(params["simulation"]);
    if (const Member plant = params["plant"]; !plant.isAbsent()) {
      edit.plant = static_cast<std::uint32_t>(plant.integer(0, UINT32_MAX));
    }
    edit.module = params["module"].count();
    const Member action = params["action"];
    edit.action = action.text();
    if (edit.action != "insert" && edit.action != "prune" && edit.action != "replace") {
      action.failExpected("one of insert, prune, replace");
    }
    const Member modules = params["modules"];
    if (edit.action == "prune") {
      if (!modules.isAbsent()) {
        modules.fail("prune puts nothing in; use replace");
      }
      return;
    }
    const std::size_t count = modules.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      const Member module = modules.element(i);
      module.requireObject();
      ModuleRecord record{module["symbol"].text(), {}};
      if (const Member parameters = module["parameters"]; !parameters.isAbsent()) {
        const std::size_t parameterCount = parameters.arraySize();
        for (std::size_t k = 0; k < parameterCount; ++k) {
          record.parameters.push_back(parameters.element(k).number());
        }
      }
      edit.modules.push_back(std::move(record));
    }
  });
}

Expected<SetParams> decodeSetParams(const Payload& payload) {
  return decodePayload<SetParams>(payload, [](const Member& params, SetParams& set) {
    params.requireObject();
    set.simulation = readName(params["simulation"]);
    readValues(params["parameters"], set.values);
  });
}

Expected<ForkParams> decodeForkParams(const Payload& payload) {
  return decodePayload<ForkParams>(payload, [](const Member& params, ForkParams& fork) {
    params.requireObject();
    fork.simulation = readName(params["simulation"]);
    fork.name = params["name"].textOrEmpty();
  });
}

Expected<EditorParams> decodeEditorParams(const Payload& payload) {
  return decodePayload<EditorParams>(payload, [](const Member& params, EditorParams& editor) {
    params.requireObject();
    editor.message = params["message"].text();
    editor.simulation = params["simulation"].textOrEmpty();
  });
}

Expected<ReadModelParams> decodeReadModelParams(const Payload& payload) {
  return decodePayload<ReadModelParams>(payload, [](const Member& params, ReadModelParams& read) {
    params.requireObject();
    const Member saved = params["saved"];
    if (saved.isAbsent() || !params["gallery"].isAbsent()) {
      read.gallery = readName(params["gallery"]);
    }
    if (!saved.isAbsent()) {
      read.saved = readName(saved);
      if (!read.gallery.empty()) {
        saved.fail("expected either \"saved\" or \"gallery\"");
      }
    }
  });
}

Expected<SaveModelParams> decodeSaveModelParams(const Payload& payload) {
  return decodePayload<SaveModelParams>(payload, [](const Member& params, SaveModelParams& save) {
    params.requireObject();
    save.name = readName(params["name"]);
    readFiles(params, save.files);
    save.remove = readTexts(params["remove"]);
    save.revision = params["revision"].textOrEmpty();
  });
}

Expected<GetParams> decodeGetParams(const Payload& payload) {
  return decodePayload<GetParams>(payload, [](const Member& params, GetParams& get) {
    params.requireObject();
    get.simulation = readName(params["simulation"]);
    const Member what = params["what"];
    get.what = what.text();
    constexpr std::array<std::string_view, 13> kKinds{"string",      "statistics",  "state-hash", "turtle", "model",
                                                      "information", "checkpoints", "traces",     "trace",  "palette",
                                                      "explanation", "environment", "productions"};
    if (std::find(kKinds.begin(), kKinds.end(), get.what) == kKinds.end()) {
      what.failExpected(
          "one of string, statistics, state-hash, turtle, model, information, checkpoints, traces, trace, palette, "
          "explanation, environment, productions");
    }
    if (get.what == "trace") {
      get.trace = static_cast<std::uint64_t>(params["trace"].integer(1, kMaximumExactInteger));
    }
    if (get.what == "explanation") {
      get.module = params["module"].count();
    }
    if (const Member plant = params["plant"]; !plant.isAbsent()) {
      get.plant = static_cast<std::uint32_t>(plant.integer(0, 0xFFFFFFFF));
    }
    readSelection(params["select"], get.select);
  });
}

Expected<TraceParams> decodeTraceParams(const Payload& payload) {
  return decodePayload<TraceParams>(payload, [](const Member& params, TraceParams& trace) {
    params.requireObject();
    trace.simulation = readName(params["simulation"]);
    trace.isTraced = params["trace"].boolean();
  });
}

Expected<ResetParams> decodeResetParams(const Payload& payload) {
  return decodePayload<ResetParams>(payload, [](const Member& params, ResetParams& reset) {
    params.requireObject();
    reset.simulation = readName(params["simulation"]);
    readOptionalCount(params["seed"], reset.seed);
  });
}

Expected<SaveParams> decodeSaveParams(const Payload& payload) {
  return decodePayload<SaveParams>(payload, [](const Member& params, SaveParams& save) {
    params.requireObject();
    save.simulation = readName(params["simulation"]);
    if (const Member checkpoint = params["checkpoint"]; !checkpoint.isAbsent()) {
      save.checkpoint = readName(checkpoint);
      save.hasSnapshot = false;
    }
    if (const Member hasSnapshot = params["snapshot"]; !hasSnapshot.isAbsent()) {
      save.hasSnapshot = hasSnapshot.boolean();
    }
  });
}

Expected<RestoreParams> decodeRestoreParams(const Payload& payload) {
  return decodePayload<RestoreParams>(payload, [](const Member& params, RestoreParams& restore) {
    params.requireObject();
    restore.simulation = readName(params["simulation"]);
    if (const Member checkpoint = params["checkpoint"]; !checkpoint.isAbsent()) {
      restore.checkpoint = readName(checkpoint);
      return;
    }
    const Member snapshot = params["snapshot"];
    auto bytes = fromBase64(snapshot.text());
    if (!bytes) {
      snapshot.fail("expected base64, as simulation.save gave it");
    }
    restore.snapshot = std::move(*bytes);
  });
}

Expected<NoParams> decodeNoParams(const Payload&) {
  return NoParams{};
}

Expected<SimulationParams> decodeSimulationParams(const Payload& payload) {
  return decodePayload<SimulationParams>(payload, [](const Member& params, SimulationParams& named) {
    params.requireObject();
    named.simulation = readName(params["simulation"]);
  });
}

Expected<OfferParams> decodeOfferParams(const Payload& payload) {
  return decodePayload<OfferParams>(payload, [](const Member& params, OfferParams& offer) {
    params.requireObject();
    offer.name = readName(params["name"]);
  });
}

Expected<StreamCloseParams> decodeStreamCloseParams(const Payload& payload) {
  return decodePayload<StreamCloseParams>(payload, [](const Member& params, StreamCloseParams& close) {
    params.requireObject();
    close.stream = readName(params["stream"]);
  });
}

Expected<StreamOpenParams> decodeStreamOpenParams(const Payload& payload) {
  return decodePayload<StreamOpenParams>(payload, [](const Member& params, StreamOpenParams& open) {
    params.requireObject();
    open.simulation = readName(params["simulation"]);
    const Member what = params["what"];
    open.what = what.text();
    constexpr std::array<std::string_view, 5> kKinds{"turtle", "string", "statistics", "geometry", "queries"};
    if (std::find(kKinds.begin(), kKinds.end(), open.what) == kKinds.end()) {
      what.failExpected("one of turtle, string, statistics, geometry, queries");
    }
    if (const Member format = params["format"]; !format.isAbsent()) {
      open.format = format.text();
      if (open.format != "glb" && open.format != "columns") {
        format.failExpected("one of glb, columns");
      }
    }
    if (const Member every = params["every"]; !every.isAbsent()) {
      open.every = static_cast<std::uint64_t>(every.integer(1, kMaximumExactInteger));
    }
    if (const Member credits = params["credits"]; !credits.isAbsent()) {
      open.credits = static_cast<std::uint64_t>(credits.integer(1, kMaximumExactInteger));
    }
    if (const Member hertz = params["maxHz"]; !hertz.isAbsent()) {
      open.maximumHertz = hertz.number();
      if (open.maximumHertz < kMinimumHertz || open.maximumHertz > kMaximumHertz) {
        hertz.failExpected("a number of frames a second from 0.001 to 1000");
      }
    }
    open.isDelta = !params["delta"].isAbsent() && params["delta"].boolean();
    open.isInBlocks = !params["bin"].isAbsent() && params["bin"].boolean();
    if (const Member precision = params["precision"]; !precision.isAbsent()) {
      const std::string& name = precision.text();
      if (name != "single" && name != "double") {
        precision.failExpected("one of single, double");
      }
      open.isSinglePrecision = name == "single";
    }
    readSelection(params["select"], open.select);
  });
}

Expected<StreamAckParams> decodeStreamAckParams(const Payload& payload) {
  return decodePayload<StreamAckParams>(payload, [](const Member& params, StreamAckParams& ack) {
    params.requireObject();
    ack.stream = readName(params["stream"]);
    readOptionalCount(params["sequence"], ack.sequence);
    if (const Member credits = params["credits"]; !credits.isAbsent()) {
      ack.credits = credits.count();
    }
  });
}

Expected<CancelParams> decodeCancelParams(const Payload& payload) {
  return decodePayload<CancelParams>(payload, [](const Member& params, CancelParams& cancel) {
    params.requireObject();
    const Member id = params["id"];
    cancel.request =
        id.isText() ? MessageId::of(id.text()) : MessageId::of(id.integer(-kMaximumExactInteger, kMaximumExactInteger));
  });
}

Expected<HelloResult> decodeHelloResult(const Payload& payload) {
  return decodePayload<HelloResult>(payload, [](const Member& result, HelloResult& hello) {
    result.requireObject();
    hello.protocol = result["protocol"].integer(0, kMaximumExactInteger);
    hello.session = result["session"].textOrEmpty();
    hello.server = result["server"].textOrEmpty();
    hello.roles = readTexts(result["roles"]);
    hello.capabilities = readTexts(result["capabilities"]);
    readLimits(result["limits"], hello.limits);
  });
}

}  // namespace espalier::protocol
