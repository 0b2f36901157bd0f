#include "engine/files/length_unit.h"

#if __has_include(<proj.h>)
#define ESPALIER_HAS_PROJ 1
#include <proj.h>
#endif

#include <charconv>
#include <cstring>
#include <string>

#include "engine/core/optional_library.h"

namespace espalier::files {

#ifdef ESPALIER_HAS_PROJ

namespace {

constexpr const char* kLibrary = "libproj.so.25";

/// The functions of PROJ that are used.
struct Functions {
  decltype(&::proj_context_create) makeContext = nullptr;
  decltype(&::proj_context_destroy) freeContext = nullptr;
  decltype(&::proj_log_level) setMessages = nullptr;
  decltype(&::proj_create_from_database) makeSystem = nullptr;
  decltype(&::proj_crs_get_coordinate_system) axesOf = nullptr;
  decltype(&::proj_cs_get_axis_info) axisOf = nullptr;
  decltype(&::proj_destroy) free = nullptr;
};

/// Loads the library; nothing when it is not installed. It stays loaded.
std::optional<Functions> load() {
  core::OptionalLibrary library(kLibrary);
  Functions functions;
  library.find(functions.makeContext, "proj_context_create");
  library.find(functions.freeContext, "proj_context_destroy");
  library.find(functions.setMessages, "proj_log_level");
  library.find(functions.makeSystem, "proj_create_from_database");
  library.find(functions.axesOf, "proj_crs_get_coordinate_system");
  library.find(functions.axisOf, "proj_cs_get_axis_info");
  library.find(functions.free, "proj_destroy");
  return library.isComplete() ? std::optional(functions) : std::nullopt;
}

}  // namespace

std::optional<unsigned> unitOfSystem(unsigned epsg) {
  static const std::optional<Functions> call = load();
  if (!call) {
    return std::nullopt;
  }
  PJ_CONTEXT* const context = call->makeContext();
  call->setMessages(context, PJ_LOG_NONE);
  PJ* const system = call->makeSystem(context, "EPSG", std::to_string(epsg).c_str(), PJ_CATEGORY_CRS, 0, nullptr);
  PJ* const axes = system == nullptr ? nullptr : call->axesOf(context, system);
  const char* code = nullptr;
  std::optional<unsigned> unit;
  if (axes != nullptr &&
      call->axisOf(context, axes, 0, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &code) == 1 &&
      code != nullptr) {
    unsigned known = 0;
    if (std::from_chars(code, code + std::strlen(code), known).ec == std::errc()) {
      unit = known;
    }
  }
  call->free(axes);
  call->free(system);
  call->freeContext(context);
  return unit;
}

#else

std::optional<unsigned> unitOfSystem(unsigned) {
  return std::nullopt;
}

#endif

std::string notInMetres(unsigned unit) {
  const std::string number = "unit " + std::to_string(unit) + " of EPSG";
  switch (unit) {
    case 9101:
    case 9102:
    case 9107:
    case 9110:
    case 9122:
      return "has angles (" + number + ") where a projected system has lengths";
    case 9002:
      return "has lengths in feet (" + number + "), not in metres";
    case 9003:
      return "has lengths in US survey feet (" + number + "), not in metres";
    case 9036:
      return "has lengths in kilometres (" + number + "), not in metres";
    default:
      return "has lengths in the " + number + ", not in metres (" + std::to_string(kMetre) + ")";
  }
}

}  // namespace espalier::files
