#include "clients/espalier/output/growth_outputs.h"

#include <filesystem>
#include <utility>

#include "clients/espalier/messages.h"
#include "server/remote/disk_files.h"

namespace espalier::command {

struct GrowthOutputs::File {
  File(const std::string& name, const turtle::ExportFormat& format, const turtle::GrowthRange& range)
      : content(name),
        target{.fileName = std::filesystem::path(name).filename().string(),
               .sink = content,
               .openCompanion = [this](const std::string& companion) -> core::ByteSink& { return open(companion); },
               .progress = {}},
        growth(format.beginGrowth(target, range)) {}

  core::ByteSink& open(const std::string& companion) {
    companions.push_back(std::make_unique<server::AtomicFile>(
        std::filesystem::path(content.name()).replace_filename(companion).string()));
    return *companions.back();
  }

  server::AtomicFile content;
  std::vector<std::unique_ptr<server::AtomicFile>> companions;  // pictures that its meshes wear
  turtle::ExportTarget target;
  std::unique_ptr<turtle::GrowthExport> growth;
};

bool isGrowthFile(const OutputOptions& options, const std::string& file) {
  const turtle::ExportFormat* const format = formatOf(options, file);
  return format != nullptr && format->beginGrowth != nullptr && file.find('%') == std::string::npos;
}

GrowthOutputs::GrowthOutputs(const OutputOptions& options, std::uint64_t first, std::uint64_t last)
    : options_(options) {
  for (const std::string& file : options.files) {
    if (isGrowthFile(options, file)) {
      files_.push_back(std::make_unique<File>(file, *formatOf(options, file),
                                              turtle::GrowthRange{.firstStep = first, .lastStep = last, .every = 1}));
    }
  }
}

GrowthOutputs::~GrowthOutputs() = default;

bool GrowthOutputs::addFrame(const simulation::Simulation& simulation) {
  if (files_.empty()) {
    return true;
  }
  const auto drawn = simulation.scene();
  if (!drawn) {
    printError(formatSimulationError(drawn.error()));
    return false;
  }
  const turtle::ExportInput input{.scene = *drawn,
                                  .view = simulation.view(),
                                  .palette = &simulation.options().palette,
                                  .detail = options_.detail,
                                  .threads = options_.picture.threads,
                                  .lengthUnit = lengthUnitOf(options_, simulation),
                                  .stepDurationDays = simulation.options().world.stepDurationDays,
                                  .rsml = options_.rootLabels.get()};
  for (const auto& file : files_) {
    if (const auto problem = file->growth->addFrame(input, simulation.completedSteps())) {
      printError("cannot write '" + file->content.name() + "': " + *problem);
      return false;
    }
  }
  ++frameCount_;
  return true;
}

bool GrowthOutputs::finish(bool isQuiet) {
  for (const auto& file : files_) {
    file->growth->finish();
    std::optional<std::string> problem;
    for (const auto& companion : file->companions) {
      problem = problem ? problem : companion->commit();
    }
    problem = problem ? problem : file->content.commit();
    if (problem) {
      printError(*problem);
      return false;
    }
    if (!isQuiet) {
      printNote("wrote " + file->content.name() + " (" + std::to_string(frameCount_) + " steps)");
    }
  }
  return true;
}

}  // namespace espalier::command
