#include "engine/simulation/model_set.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "engine/core/check.h"
#include "engine/language/checks/model_queries.h"
#include "engine/simulation/forest.h"

namespace espalier::simulation {

ModelSet::ModelSet(Programs programs) : programs_(std::move(programs)) {
  ESPALIER_CHECK(!programs_.empty());
  for (const auto& program : programs_) {
    ESPALIER_CHECK(program->compatibility == compatibility());
    interpreters_.push_back(std::make_unique<turtle::Interpreter>(*program));
  }
  numberSymbols();
  mergeViews();
}

void ModelSet::numberSymbols() {
  // the first Program's numbers stay; names that only others have follow
  std::unordered_map<std::string, core::SymbolId> numbers;
  for (const auto& program : programs_) {
    std::vector<core::SymbolId>& common = commonSymbol_.emplace_back();
    for (const language::Symbol& symbol : program->symbols) {
      const auto [found, isNew] = numbers.try_emplace(symbol.name, static_cast<core::SymbolId>(symbolNames_.size()));
      // a Program's own symbols all have different names, so that the first one's keep their numbers
      if (isNew) {
        symbolNames_.push_back(symbol.name);
      }
      common.push_back(found->second);
      if (symbol.isQuery && symbol.name == language::kSeedName) {
        seed_ = found->second;
      } else if (symbol.isQuery && symbol.name == language::kDeathName) {
        death_ = found->second;
      }
    }
  }
  ESPALIER_CHECK(symbolNames_.size() < core::kNoSymbol);
}

void ModelSet::mergeViews() {
  view_ = first().view;
  offsets_.resize(programs_.size());
  const auto largestId = [](const files::ViewSettings& view) {
    int largest = 0;
    for (const files::Contour& contour : view.contours) {
      largest = std::max(largest, contour.id);
    }
    return largest;
  };
  for (std::size_t model = 1; model < programs_.size(); ++model) {
    const files::ViewSettings& view = programs_[model]->view;
    offsets_[model] = {.surface = static_cast<std::uint32_t>(view_.surfaces.size()),
                       .triangleSurface = static_cast<std::uint32_t>(view_.triangleSurfaces.size()),
                       .contour = largestId(view_)};
    view_.surfaces.insert(view_.surfaces.end(), view.surfaces.begin(), view.surfaces.end());
    view_.triangleSurfaces.insert(view_.triangleSurfaces.end(), view.triangleSurfaces.begin(),
                                  view.triangleSurfaces.end());
    for (files::Contour contour : view.contours) {
      contour.id += offsets_[model].contour;
      view_.contours.push_back(std::move(contour));
    }
  }
}

bool ModelSet::hasQueries() const {
  return std::any_of(programs_.begin(), programs_.end(), [](const auto& program) { return program->hasQueries; });
}

bool ModelSet::writesFiles() const {
  return std::any_of(programs_.begin(), programs_.end(), [](const auto& program) { return !program->files.empty(); });
}

std::optional<std::uint64_t> ModelSet::modelSeed() const {
  for (const auto& program : programs_) {
    for (const language::LSystem& system : program->systems) {
      if (system.seed) {
        return static_cast<std::uint64_t>(*system.seed);
      }
    }
  }
  return std::nullopt;
}

std::uint64_t ModelSet::longestDerivation() const {
  std::uint64_t length = 0;
  for (const auto& program : programs_) {
    length = std::max<std::uint64_t>(length, program->derivationLength);
  }
  return length;
}

void ModelSet::toCommonSymbols(std::uint32_t model, std::size_t firstQuery, turtle::QueryBatch& queries) const {
  if (model == 0) {
    return;
  }
  const std::vector<core::SymbolId>& common = commonSymbol_[model];
  for (std::size_t query = firstQuery; query < queries.size(); ++query) {
    queries.symbol[query] = common[queries.symbol[query]];
    if (query < queries.following.size() && queries.following[query] != core::kNoSymbol) {
      queries.following[query] = common[queries.following[query]];
    }
  }
}

void ModelSet::toCommonSymbols(std::uint32_t model, std::span<turtle::TurtleRecord> records) const {
  if (model == 0) {
    return;
  }
  for (turtle::TurtleRecord& record : records) {
    record.symbol = commonSymbol_[model][record.symbol];
  }
}

void ModelSet::toCommonNumbers(std::uint32_t model, std::int32_t colourShift, const turtle::SceneMark& mark,
                               turtle::Scene& scene) const {
  if (model == 0 && colourShift == 0) {
    return;
  }
  const auto recolour = [colourShift](auto& elements, std::size_t first) {
    for (std::size_t i = first; i < elements.size(); ++i) {
      elements[i].colour += colourShift;
    }
  };
  recolour(scene.segments, mark.segments);
  recolour(scene.polygons, mark.polygons);
  recolour(scene.balls, mark.balls);
  recolour(scene.surfaces, mark.surfaces);
  recolour(scene.patches, mark.patches);
  recolour(scene.labels, mark.labels);
  const Offsets& offsets = offsets_[model];
  for (std::size_t i = mark.surfaces; i < scene.surfaces.size(); ++i) {
    turtle::SurfaceInstance& instance = scene.surfaces[i];
    instance.surface += instance.isTriangleSurface ? offsets.triangleSurface : offsets.surface;
  }
  for (std::size_t i = mark.cylinders; i < scene.cylinders.size(); ++i) {
    for (turtle::CylinderPoint& point : scene.cylinders[i].points) {
      point.colour += colourShift;
      point.contour += point.contour == 0 ? 0 : offsets.contour;
    }
  }
}

}  // namespace espalier::simulation
