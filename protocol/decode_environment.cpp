#include "protocol/base64.h"
#include "protocol/bulk_text.h"
#include "protocol/codec.h"
#include "protocol/column_storage.h"
#include "protocol/environment_blocks.h"
#include "protocol/forest_fields.h"
#include "protocol/json_tree.h"

namespace espalier::protocol {
namespace {

void readOptionalNumber(const Field& field, std::optional<double>& number) {
  if (!field.isAbsent()) {
    number = field.number();
  }
}

template <typename Add>
void readNumbers(const Field& field, Add&& add) {
  if (!field.isAbsent()) {
    const std::size_t count = field.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      add(field.element(i).number());
    }
  }
}

void readQuery(const Field& field, QueryCollector& queries) {
  field.requireObject();
  if (const Field id = field["id"]; id.count() != queries.count()) {
    id.fail("expected " + std::to_string(queries.count()) + ": queries are numbered from 0 in order");
  }
  queries.begin(field["plant"].isAbsent() ? 0 : static_cast<std::uint32_t>(field["plant"].integer(0, 0xFFFFFFFF)),
                field["module"].isAbsent() ? 0 : field["module"].count(),
                !field["transient"].isAbsent() && field["transient"].boolean(), field["symbol"].text());
  readNumbers(field["parameters"], [&](double value) { queries.parameter(value); });
  queries.endParameters();
  if (const Field position = field["position"]; !position.isAbsent()) {
    queries.position(readVector(position));
  }
  if (const Field heading = field["heading"]; !heading.isAbsent()) {
    queries.heading(readVector(heading));
  }
  if (const Field left = field["left"]; !left.isAbsent()) {
    queries.left(readVector(left));
  }
  if (const Field up = field["up"]; !up.isAbsent()) {
    queries.up(readVector(up));
  }
  if (const Field width = field["width"]; !width.isAbsent()) {
    queries.width(width.number());
  }
  if (const Field scale = field["scale"]; !scale.isAbsent()) {
    queries.scale(scale.number());
  }
  if (const Field following = field["following"]; !following.isAbsent()) {
    following.requireObject();
    queries.following(following["symbol"].text());
    readNumbers(following["parameters"], [&](double value) { queries.followingParameter(value); });
  }
}

void readReply(const Field& field, ReplyCollector& replies) {
  field.requireObject();
  replies.begin(static_cast<std::uint32_t>(field["id"].integer(0, 0xFFFFFFFF)));
  if (const Field parameters = field["parameters"]; !parameters.isAbsent()) {
    const std::size_t count = parameters.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      const Field value = parameters.element(i);
      if (value.isNull()) {
        replies.keep();
      } else {
        replies.value(value.number());
      }
    }
  }
  replies.end();
}

/// Each id is below the number of queries and there at most once.
void requireRightIds(const ReplyColumns& replies, std::size_t queryCount, bool isInBlocks) {
  const auto fail = [&](std::size_t index, const std::string& what) {
    const std::string place = std::to_string(index);
    throw FieldFailure{fieldError(isInBlocks ? "bin.id[" + place + "]" : "result.replies[" + place + "].id", what)};
  };
  std::vector<bool> isAnswered(queryCount, false);
  for (std::size_t i = 0; i < replies.id.size(); ++i) {
    const std::uint32_t id = replies.id[i];
    if (id >= queryCount) {
      fail(i, "there is no query " + std::to_string(id) + "; this step has " + std::to_string(queryCount) +
                  " queries, numbered from 0");
    }
    if (isAnswered[id]) {
      fail(i, "query " + std::to_string(id) + " is answered twice; answer each at most once");
    }
    isAnswered[id] = true;
  }
}

void readNeeds(const Field& field, NeedsRecord& needs) {
  if (field.isAbsent()) {
    return;
  }
  const std::size_t count = field.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Field element = field.element(i);
    const std::string& name = element.text();
    if (name == "position") {
      needs.position = true;
    } else if (name == "heading") {
      needs.heading = true;
    } else if (name == "left") {
      needs.left = true;
    } else if (name == "up") {
      needs.up = true;
    } else if (name == "width") {
      needs.width = true;
    } else if (name == "scale") {
      needs.scale = true;
    } else if (name == "parameters") {
      needs.parameters = true;
    } else if (name == "following") {
      needs.following = true;
    } else if (name == "geometry") {
      needs.geometry = true;
    } else {
      element.failExpected("one of position, heading, left, up, width, scale, parameters, following, geometry");
    }
  }
}

std::vector<VariableRecord> readVariables(const Field& field) {
  std::vector<VariableRecord> variables;
  if (field.isAbsent()) {
    return variables;
  }
  const std::size_t count = field.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Field element = field.element(i);
    element.requireObject();
    VariableRecord variable;
    variable.name = element["name"].text();
    if (const Field unit = element["unit"]; !unit.isAbsent()) {
      variable.unit = unit.text();
    }
    variable.type = element["type"].textOrEmpty();
    variables.push_back(std::move(variable));
  }
  return variables;
}

void readWorld(const Field& field, WorldRecord& world) {
  if (field.isAbsent()) {
    return;
  }
  field.requireObject();
  if (const Field unit = field["lengthUnit"]; !unit.isAbsent()) {
    world.lengthUnit = unit.text();
  }
  if (const Field up = field["up"]; !up.isAbsent()) {
    world.up = readVector(up);
  }
  if (const Field north = field["north"]; !north.isAbsent()) {
    world.north = readVector(north);
  }
  if (const Field duration = field["stepDuration"]; !duration.isAbsent()) {
    world.stepDurationDays = duration.number();
  }
  readOptionalNumber(field["latitude"], world.latitudeDegrees);
  readOptionalNumber(field["longitude"], world.longitudeDegrees);
  world.start = field["start"].textOrEmpty();
}

std::string readBytes(const Field& field) {
  auto bytes = fromBase64(field.text());
  if (!bytes) {
    field.fail("expected base64");
  }
  return std::move(*bytes);
}

}  // namespace

Decoded<OpenParams> decodeOpenParams(const Payload& payload) {
  return decodePayload<OpenParams>(payload, [](const Field& params, OpenParams& open) {
    params.requireObject();
    open.simulation = params["simulation"].text();
    if (const Field plants = params["plants"]; !plants.isAbsent()) {
      open.plants = static_cast<std::uint32_t>(plants.integer(0, 0xFFFFFFFF));
    }
    if (const Field symbols = params["symbols"]; !symbols.isAbsent()) {
      const std::size_t count = symbols.arraySize();
      for (std::size_t i = 0; i < count; ++i) {
        open.symbols.push_back(symbols.element(i).text());
      }
    }
    if (const Field configuration = params["configuration"]; !configuration.isAbsent()) {
      configuration.requireObject();
      open.configurationJson = configuration.json().empty() ? std::string() : configuration.dump();
    }
    if (const Field seed = params["seed"]; !seed.isAbsent()) {
      open.seed = seed.wide();
    }
    if (const Field resume = params["resume"]; !resume.isAbsent()) {
      open.resumeStep = resume.count();
    }
    readWorld(params["world"], open.world);
    open.bounds = readBounds(params);
  });
}

Decoded<EnvironmentStepParams> decodeEnvironmentStepParams(const Payload& payload) {
  if (payload.bulk() != nullptr && payload.bulk()->step) {
    return *payload.bulk()->step;
  }
  return decodePayload<EnvironmentStepParams>(payload, [&](const Field& params, EnvironmentStepParams& step) {
    params.requireObject();
    step.simulation = params["simulation"].text();
    step.step = params["step"].count();
    if (const Field iteration = params["iteration"]; !iteration.isAbsent()) {
      step.iteration = static_cast<std::uint32_t>(iteration.integer(0, 0xFFFFFFFF));
    }
    if (const Field time = params["time"]; !time.isAbsent()) {
      step.timeDays = time.number();
    }
    if (const Field geometry = params["geometry"]; !geometry.isAbsent()) {
      step.geometry = readGeometry(geometry, payload);
    }
    if (payload.blocks() != nullptr) {
      step.queries = readQueryBlocks(params, payload);
      return;
    }
    const Field queries = params["queries"];
    const std::size_t count = queries.arraySize();
    QueryCollector collector;
    for (std::size_t i = 0; i < count; ++i) {
      readQuery(queries.element(i), collector);
    }
    step.queries = collector.take();
  });
}

Decoded<RestoreStateParams> decodeRestoreStateParams(const Payload& payload) {
  return decodePayload<RestoreStateParams>(payload, [](const Field& params, RestoreStateParams& restore) {
    params.requireObject();
    restore.simulation = params["simulation"].text();
    restore.state = readBytes(params["state"]);
  });
}

Decoded<DescribeResult> decodeDescribeResult(const Payload& payload) {
  return decodePayload<DescribeResult>(payload, [](const Field& result, DescribeResult& description) {
    result.requireObject();
    description.name = result["name"].textOrEmpty();
    description.summary = result["summary"].textOrEmpty();
    readNeeds(result["needs"], description.needs);
    description.inputs = readVariables(result["inputs"]);
    description.outputs = readVariables(result["outputs"]);
    description.isStateful = !result["stateful"].isAbsent() && result["stateful"].boolean();
    description.canCheckpoint = !result["checkpoint"].isAbsent() && result["checkpoint"].boolean();
    if (const Field geometry = result["geometry"]; !geometry.isAbsent()) {
      if (geometry.text() != "whole" && geometry.text() != "difference") {
        geometry.failExpected("whole or difference");
      }
      description.takesDifferences = geometry.text() == "difference";
    }
  });
}

Decoded<ReplyColumns> decodeReplies(const Payload& payload, std::size_t queryCount) {
  const bool isBulk = payload.bulk() != nullptr && payload.bulk()->replies;
  const auto read = [&](const Field& result) {
    if (payload.blocks() != nullptr) {
      return readReplyBlocks(payload, queryCount);
    }
    result.requireObject();
    const Field list = result["replies"];
    const std::size_t count = list.arraySize();
    ReplyCollector collector;
    for (std::size_t i = 0; i < count; ++i) {
      readReply(list.element(i), collector);
    }
    return collector.take();
  };
  Payload none;
  return decodePayload<ReplyColumns>(isBulk ? none : payload, [&](const Field& result, ReplyColumns& replies) {
    replies = isBulk ? *payload.bulk()->replies : read(result);
    requireRightIds(replies, queryCount, payload.blocks() != nullptr);
  });
}

Decoded<std::string> decodeSaveResult(const Payload& payload) {
  return decodePayload<std::string>(payload, [](const Field& result, std::string& state) {
    result.requireObject();
    state = readBytes(result["state"]);
  });
}

}  // namespace espalier::protocol
