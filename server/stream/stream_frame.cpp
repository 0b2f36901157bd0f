#include "server/stream/stream_frame.h"

#include <algorithm>

#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/stream/chain_difference.h"
#include "server/stream/geometry_frame.h"
#include "server/stream/text_difference.h"
#include "server/stream/translate_stream.h"

namespace espalier::server {
namespace {

/// Whether two streams get the same frames.
bool wantTheSame(const protocol::StreamOpenParams& a, const protocol::StreamOpenParams& b) {
  return a.what == b.what && a.format == b.format && a.select == b.select && a.isInBlocks == b.isInBlocks &&
         a.isSinglePrecision == b.isSinglePrecision && a.isDelta == b.isDelta;
}

core::SimulationError nonFiniteError(std::uint64_t step) {
  return {.code = core::SimulationErrorCode::NonFinite,
          .message = "The turtle went to a position that is NaN or infinite. Correct the model.",
          .step = step};
}

/// A difference of most rows would be longer than all of them.
bool isShort(const TurtleChange& change) {
  return 2 * change.kept.size() + 10 * change.fresh->rows() < 10 * change.rows;
}

}  // namespace

tl::expected<protocol::Body, core::SimulationError> turtleBody(const simulation::Simulation& simulation,
                                                               const protocol::StreamOpenParams& params) {
  const auto made = simulation.turtleRecords();
  if (!made) {
    return tl::unexpected(made.error());
  }
  auto symbols = std::make_shared<const std::vector<std::string>>(simulation.symbolNames());
  try {
    return encodeTurtle(std::make_shared<const TurtleFrame>(makeTurtleFrame(*made, std::move(symbols), params.select)),
                        params);
  } catch (const protocol::NonFiniteNumber&) {
    return tl::unexpected(nonFiniteError(simulation.completedSteps()));
  }
}

std::uint64_t FrameBase::bytes() const {
  return (chain == nullptr ? 0 : chain->bytes) + (turtle == nullptr ? 0 : turtle->bytes()) +
         (geometry == nullptr ? 0 : geometry->bytes()) + (text == nullptr ? 0 : text->size());
}

tl::expected<StreamFrame, core::SimulationError> FrameMaker::make(const protocol::StreamOpenParams& params,
                                                                  const FrameBase& base) {
  const auto found = std::find_if(made_.begin(), made_.end(), [&](const Made& made) {
    return wantTheSame(made.params, params) && made.base == base;
  });
  if (found != made_.end()) {
    return found->frame;
  }
  auto frame = makeNew(params, base);
  if (frame) {
    made_.push_back({params, base, *frame});
  }
  return frame;
}

tl::expected<StreamFrame, core::SimulationError> FrameMaker::makeNew(const protocol::StreamOpenParams& params,
                                                                     const FrameBase& base) {
  if (params.what == "statistics") {
    protocol::JsonWriter body;
    write(body, toStatistics(drawing_.view().statistics, milliseconds_));
    return StreamFrame{protocol::Body(body.take()), true, {}};
  }
  if (params.what == "string") {
    return makeText(params, base);
  }
  try {
    if (params.what == "geometry") {
      return makeGeometry(params, base);
    }
    if (params.what == "queries") {
      return StreamFrame{encodeQueries(queries_, *symbols_, params), true, {}};
    }
    return makeTurtle(params, base);
  } catch (const protocol::NonFiniteNumber&) {
    return tl::unexpected(nonFiniteError(drawing_.view().completedSteps));
  }
}

tl::expected<StreamFrame, core::SimulationError> FrameMaker::makeTurtle(const protocol::StreamOpenParams& params,
                                                                        const FrameBase& base) {
  StreamFrame result;
  if (params.isDelta && params.select == protocol::StreamSelection{}) {
    auto made = chain();
    if (!made) {
      return tl::unexpected(std::move(made.error()));
    }
    result.base.chain = *made;
    if (base.chain != nullptr && result.base.chain != nullptr && base.chain->programs == result.base.chain->programs) {
      TurtleChange change = differenceOf(*base.chain, *result.base.chain, symbols_);
      if (isShort(change)) {
        result.isKey = false;
        result.body = encodeTurtle(std::move(change), params);
        return result;
      }
    }
  }
  auto made = turtle(params.select);
  if (!made) {
    return tl::unexpected(std::move(made.error()));
  }
  const auto& frame = *made;
  if (params.isDelta && result.base.chain == nullptr) {
    result.base.turtle = frame;
    if (base.turtle != nullptr && *base.turtle->symbols == *frame->symbols) {
      TurtleDifference difference = differenceOf(*base.turtle, *frame);
      TurtleChange change{frame->rows(), std::move(difference.kept),
                          std::make_shared<const TurtleFrame>(rowsOf(*frame, difference.fresh))};
      if (isShort(change)) {
        result.isKey = false;
        result.body = encodeTurtle(std::move(change), params);
        return result;
      }
    }
  }
  result.body = encodeTurtle(frame, params);
  return result;
}

tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> FrameMaker::chain() {
  // one for all viewers
  if (!chain_) {
    auto made = drawing_.recordChain();
    if (!made) {
      return tl::unexpected(std::move(made.error()));
    }
    chain_ = std::move(*made);
  }
  return *chain_;
}

tl::expected<std::shared_ptr<const TurtleFrame>, core::SimulationError> FrameMaker::turtle(
    const protocol::StreamSelection& select) {
  const auto found =
      std::find_if(turtles_.begin(), turtles_.end(), [&](const Turtle& made) { return made.select == select; });
  if (found != turtles_.end()) {
    return found->frame;
  }
  if (chain_ && *chain_ != nullptr && select == protocol::StreamSelection{}) {
    turtles_.push_back({select, std::make_shared<const TurtleFrame>(makeTurtleFrame(**chain_, symbols_))});
    return turtles_.back().frame;
  }
  if (!records_) {
    auto made = drawing_.turtleRecords();
    if (!made) {
      return tl::unexpected(std::move(made.error()));
    }
    records_ = std::move(*made);
  }
  auto frame = std::make_shared<const TurtleFrame>(makeTurtleFrame(*records_, symbols_, select));
  turtles_.push_back({select, frame});
  return frame;
}

tl::expected<StreamFrame, core::SimulationError> FrameMaker::makeGeometry(const protocol::StreamOpenParams& params,
                                                                          const FrameBase& base) {
  if (params.format == "glb") {
    auto body = geometryBody(drawing_);
    if (!body) {
      return tl::unexpected(std::move(body.error()));
    }
    return StreamFrame{std::move(*body), true, {}};
  }
  auto made = geometry(params.select);
  if (!made) {
    return tl::unexpected(std::move(made.error()));
  }
  const auto& frame = *made;
  StreamFrame result;
  if (params.isDelta) {
    result.base.geometry = frame;
    if (auto change = encodeDifference(frame, base.geometry.get(), params)) {
      result.isKey = false;
      result.body = std::move(*change);
      return result;
    }
  }
  result.body = encodeGeometry(frame, params);
  return result;
}

tl::expected<std::shared_ptr<const GeometryFrame>, core::SimulationError> FrameMaker::geometry(
    const protocol::StreamSelection& select) {
  const auto found =
      std::find_if(geometries_.begin(), geometries_.end(), [&](const Geometry& made) { return made.select == select; });
  if (found != geometries_.end()) {
    return found->frame;
  }
  auto made = makeGeometryFrame(drawing_, symbols_, select);
  if (!made) {
    return tl::unexpected(std::move(made.error()));
  }
  geometries_.push_back({select, std::make_shared<const GeometryFrame>(std::move(*made))});
  return geometries_.back().frame;
}

StreamFrame FrameMaker::makeText(const protocol::StreamOpenParams& params, const FrameBase& base) {
  const std::uint32_t plant = params.select.plants.empty() ? 0 : params.select.plants.front();
  auto found = std::find_if(texts_.begin(), texts_.end(), [plant](const auto& made) { return made.first == plant; });
  if (found == texts_.end()) {
    texts_.emplace_back(plant, std::make_shared<const std::string>(
                                   plant < drawing_.view().plants.size() ? drawing_.stringText(plant) : std::string()));
    found = std::prev(texts_.end());
  }
  const std::shared_ptr<const std::string>& text = found->second;
  StreamFrame frame;
  protocol::JsonWriter body;
  if (params.isDelta) {
    frame.base.text = text;
    const auto isPlain = [](char c) { return static_cast<unsigned char>(c) < 0x80U; };
    // where bytes are characters
    if (base.text != nullptr && std::all_of(text->begin(), text->end(), isPlain) &&
        std::all_of(base.text->begin(), base.text->end(), isPlain)) {
      body.key("pieces").beginArray();
      for (const TextPiece& piece : differenceOf(*base.text, *text)) {
        if (piece.count > 0) {
          body.beginArray().integer(std::uint64_t{piece.from}).integer(std::uint64_t{piece.count}).endArray();
        } else {
          body.text(piece.own);
        }
      }
      body.endArray();
      if (body.view().size() < text->size()) {
        frame.isKey = false;
        frame.body = protocol::Body(body.take());
        return frame;
      }
      body = {};
    }
  }
  body.key("string").text(*text);
  frame.body = protocol::Body(body.take());
  return frame;
}

}  // namespace espalier::server
