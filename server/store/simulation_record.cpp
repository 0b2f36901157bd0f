#include "server/store/simulation_record.h"

#include "protocol/codec.h"
#include "protocol/json_text.h"

namespace espalier::server {

std::string toText(const SimulationRecord& record) {
  const protocol::CreateParams& create = record.create;
  protocol::JsonWriter params;
  params.beginObject();
  if (create.models.empty()) {
    params.key("model").beginObject().key("loaded").text("snapshot").endObject();
  } else {
    params.key("models").beginArray();
    for (const protocol::NamedModel& model : create.models) {
      params.beginObject().key("name").text(model.name).key("colour").integer(model.colour);
      params.key("model").beginObject().key("loaded").text("snapshot").endObject().endObject();
    }
    params.endArray();
  }
  params.key("name").text(create.name).key("seed").integer(record.seed).key("seedGiven").boolean(record.hasSeed);
  if (!create.environmentJson.empty()) {
    params.key("environment").raw(create.environmentJson);
  }
  if (create.derivationLength) {
    params.key("derivationLength").integer(*create.derivationLength);
  }
  writePlants(params, create.plants);
  writeSeeds(params, create.seeds);
  params.key("limits").beginObject();
  if (create.maximumModules) {
    params.key("modules").integer(*create.maximumModules);
  }
  if (create.maximumQueries) {
    params.key("queries").integer(*create.maximumQueries);
  }
  params.endObject();
  if (create.iterations > 1) {
    params.key("coupling").beginObject().key("iterations").integer(create.iterations);
    params.key("tolerance").number(create.tolerance).endObject();
  }
  if (create.bounds) {
    write(params, *create.bounds);
  }
  if (create.world) {
    write(params, *create.world);
  }
  params.key("save");
  write(params, create.save);
  params.key("trace").boolean(create.isTraced);
  params.key("countProductions").boolean(create.countsProductions).endObject();
  return protocol::encodeNotification("simulation.create", params.take());
}

tl::expected<SimulationRecord, std::string> toRecord(const std::string& id, std::string_view text) {
  while (!text.empty() && text.back() == '\n') {
    text.remove_suffix(1);
  }
  const auto message = protocol::decodeMessage(text);
  if (!message) {
    return tl::unexpected(message.error().error.message);
  }
  const protocol::Payload& payload = message->payload;
  auto decoded = protocol::decodeCreateParams(payload);
  if (!decoded) {
    return tl::unexpected(decoded.error().message);
  }
  SimulationRecord record;
  record.id = id;
  record.create = std::move(*decoded);
  record.seed = record.create.seed.value_or(0);
  record.hasSeed = protocol::memberOf(payload.toText(), "seedGiven") == "true";
  return record;
}

}  // namespace espalier::server
