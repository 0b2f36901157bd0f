#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/decoding/column_storage.h"
#include "protocol/decoding/decode_payload.h"
#include "protocol/decoding/environment_blocks.h"
#include "protocol/decoding/forest_members.h"

namespace espalier::protocol {
namespace {

template <typename Add>
void readNumbers(const Member& member, Add&& add) {
  if (!member.isAbsent()) {
    const std::size_t count = member.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      add(member.element(i).number());
    }
  }
}

void readQuery(const Member& member, QueryCollector& queries) {
  member.requireObject();
  if (const Member id = member["id"]; id.count() != queries.count()) {
    id.fail("expected " + std::to_string(queries.count()) + ": queries are numbered from 0 in order");
  }
  queries.begin(member["plant"].isAbsent() ? 0 : static_cast<std::uint32_t>(member["plant"].integer(0, 0xFFFFFFFF)),
                member["module"].isAbsent() ? 0 : member["module"].count(),
                !member["transient"].isAbsent() && member["transient"].boolean(), member["symbol"].text());
  readNumbers(member["parameters"], [&](double value) { queries.parameter(value); });
  queries.endParameters();
  if (const Member position = member["position"]; !position.isAbsent()) {
    queries.position(readVector(position));
  }
  if (const Member heading = member["heading"]; !heading.isAbsent()) {
    queries.heading(readVector(heading));
  }
  if (const Member left = member["left"]; !left.isAbsent()) {
    queries.left(readVector(left));
  }
  if (const Member up = member["up"]; !up.isAbsent()) {
    queries.up(readVector(up));
  }
  if (const Member width = member["width"]; !width.isAbsent()) {
    queries.width(width.number());
  }
  if (const Member scale = member["scale"]; !scale.isAbsent()) {
    queries.scale(scale.number());
  }
  if (const Member following = member["following"]; !following.isAbsent()) {
    following.requireObject();
    queries.following(following["symbol"].text());
    readNumbers(following["parameters"], [&](double value) { queries.followingParameter(value); });
  }
}

void readReply(const Member& member, ReplyCollector& replies) {
  member.requireObject();
  replies.begin(static_cast<std::uint32_t>(member["id"].integer(0, 0xFFFFFFFF)));
  if (const Member parameters = member["parameters"]; !parameters.isAbsent()) {
    const std::size_t count = parameters.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      const Member value = parameters.element(i);
      if (value.isNull()) {
        replies.keep();
      } else {
        replies.value(value.number());
      }
    }
  }
  replies.end();
}

void readNotes(const Member& member, std::vector<std::string>& notes) {
  const std::size_t count = member.isAbsent() ? 0 : member.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    addNote(member.element(i).text(), notes);
  }
}

/// Each id is below the number of queries and there at most once.
void requireRightIds(const ReplyColumns& replies, std::size_t queryCount, bool isInBlocks) {
  const auto fail = [&](std::size_t index, const std::string& what) {
    const std::string place = std::to_string(index);
    throw MemberFailure{memberError(isInBlocks ? "bin.id[" + place + "]" : "result.replies[" + place + "].id", what)};
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

void readNeeds(const Member& member, NeedsRecord& needs) {
  if (member.isAbsent()) {
    return;
  }
  const std::size_t count = member.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Member element = member.element(i);
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

std::vector<VariableRecord> readVariables(const Member& member) {
  std::vector<VariableRecord> variables;
  if (member.isAbsent()) {
    return variables;
  }
  const std::size_t count = member.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Member element = member.element(i);
    element.requireObject();
    VariableRecord variable;
    variable.name = element["name"].text();
    if (const Member unit = element["unit"]; !unit.isAbsent()) {
      variable.unit = unit.text();
    }
    variable.type = element["type"].textOrEmpty();
    variables.push_back(std::move(variable));
  }
  return variables;
}

std::string readBytes(const Member& member) {
  auto bytes = fromBase64(member.text());
  if (!bytes) {
    member.fail("expected base64");
  }
  return std::move(*bytes);
}

}  // namespace

Expected<OpenParams> decodeOpenParams(const Payload& payload) {
  return decodePayload<OpenParams>(payload, [](const Member& params, OpenParams& open) {
    params.requireObject();
    open.simulation = params["simulation"].text();
    if (const Member plants = params["plants"]; !plants.isAbsent()) {
      open.plants = static_cast<std::uint32_t>(plants.integer(0, 0xFFFFFFFF));
    }
    if (const Member symbols = params["symbols"]; !symbols.isAbsent()) {
      const std::size_t count = symbols.arraySize();
      for (std::size_t i = 0; i < count; ++i) {
        open.symbols.push_back(symbols.element(i).text());
      }
    }
    if (const Member configuration = params["configuration"]; !configuration.isAbsent()) {
      configuration.requireObject();
      open.configurationJson = configuration.json().empty() ? std::string() : configuration.dump();
    }
    if (const Member seed = params["seed"]; !seed.isAbsent()) {
      open.seed = seed.wide();
    }
    if (const Member resume = params["resume"]; !resume.isAbsent()) {
      open.resumeStep = resume.count();
    }
    if (const Member world = params["world"]; !world.isAbsent()) {
      open.world = readWorld(world);
    }
    open.bounds = readBounds(params);
  });
}

Expected<EnvironmentStepParams> decodeEnvironmentStepParams(const Payload& payload) {
  if (payload.bulk() != nullptr && payload.bulk()->step) {
    return *payload.bulk()->step;
  }
  return decodePayload<EnvironmentStepParams>(payload, [&](const Member& params, EnvironmentStepParams& step) {
    params.requireObject();
    step.simulation = params["simulation"].text();
    step.step = params["step"].count();
    if (const Member iteration = params["iteration"]; !iteration.isAbsent()) {
      step.iteration = static_cast<std::uint32_t>(iteration.integer(0, 0xFFFFFFFF));
    }
    if (const Member time = params["time"]; !time.isAbsent()) {
      step.timeDays = time.number();
    }
    if (const Member geometry = params["geometry"]; !geometry.isAbsent()) {
      step.geometry = readGeometry(geometry, payload);
    }
    if (payload.blocks() != nullptr) {
      step.queries = readQueryBlocks(params, payload);
      return;
    }
    const Member queries = params["queries"];
    const std::size_t count = queries.arraySize();
    QueryCollector collector;
    for (std::size_t i = 0; i < count; ++i) {
      readQuery(queries.element(i), collector);
    }
    step.queries = collector.take();
  });
}

Expected<RestoreStateParams> decodeRestoreStateParams(const Payload& payload) {
  return decodePayload<RestoreStateParams>(payload, [](const Member& params, RestoreStateParams& restore) {
    params.requireObject();
    restore.simulation = params["simulation"].text();
    restore.state = readBytes(params["state"]);
  });
}

Expected<DescribeResult> decodeDescribeResult(const Payload& payload) {
  return decodePayload<DescribeResult>(payload, [](const Member& result, DescribeResult& description) {
    result.requireObject();
    description.name = result["name"].textOrEmpty();
    description.summary = result["summary"].textOrEmpty();
    readNeeds(result["needs"], description.needs);
    description.inputs = readVariables(result["inputs"]);
    description.outputs = readVariables(result["outputs"]);
    description.isStateful = !result["stateful"].isAbsent() && result["stateful"].boolean();
    description.canCheckpoint = !result["checkpoint"].isAbsent() && result["checkpoint"].boolean();
    if (const Member geometry = result["geometry"]; !geometry.isAbsent()) {
      if (geometry.text() != "whole" && geometry.text() != "difference") {
        geometry.failExpected("whole or difference");
      }
      description.takesDifferences = geometry.text() == "difference";
    }
  });
}

Expected<ReplyColumns> decodeReplies(const Payload& payload, std::size_t queryCount) {
  const bool isBulk = payload.bulk() != nullptr && payload.bulk()->replies;
  const auto read = [&](const Member& result) {
    if (payload.blocks() != nullptr) {
      return readReplyBlocks(payload, queryCount);
    }
    result.requireObject();
    const Member list = result["replies"];
    const std::size_t count = list.arraySize();
    ReplyCollector collector;
    for (std::size_t i = 0; i < count; ++i) {
      readReply(list.element(i), collector);
    }
    return collector.take();
  };
  Payload none;
  return decodePayload<ReplyColumns>(isBulk ? none : payload, [&](const Member& result, ReplyColumns& replies) {
    replies = isBulk ? *payload.bulk()->replies : read(result);
    if (result.isObject()) {
      readNotes(result["notes"], replies.notes);
    }
    requireRightIds(replies, queryCount, payload.blocks() != nullptr);
  });
}

Expected<std::string> decodeSaveResult(const Payload& payload) {
  return decodePayload<std::string>(payload, [](const Member& result, std::string& state) {
    result.requireObject();
    state = readBytes(result["state"]);
  });
}

}  // namespace espalier::protocol
