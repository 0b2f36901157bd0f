#include "server/remote/processes/plugin_library.h"

#include <dlfcn.h>

#include <utility>

#include "environment/plugin_process.h"
#include "server/remote/processes/supervised_process.h"

namespace espalier::server {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

/// One instance of a plug-in, without supervision.
tl::expected<Process, std::string> loadInstance(const std::string& library, std::string_view configurationJson) {
  // a name without a folder is meant as it is, not as one of the system's libraries
  const std::string path = library.find('/') == std::string::npos ? "./" + library : library;
  void* const handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* const reason = ::dlerror();
    return tl::unexpected("the plug-in '" + library + "' cannot be loaded (" +
                          (reason == nullptr ? "no reason given" : reason) +
                          "). Check the name, and that it was built for this machine.");
  }
  std::shared_ptr<void> loaded(handle, [](void* held) { ::dlclose(held); });
  using Entry = const espalier_plugin* (*)();
  const auto entry = reinterpret_cast<Entry>(::dlsym(handle, "espalier_plugin_entry"));
  const espalier_plugin* const plugin = entry == nullptr ? nullptr : entry();
  if (plugin == nullptr) {
    return tl::unexpected("'" + library +
                          "' is no plug-in: it exports no function espalier_plugin_entry that returns its table "
                          "(environment/plugin.h).");
  }
  auto made = environment::makePluginProcess(*plugin, std::move(loaded), configurationJson);
  if (!made) {
    return tl::unexpected("the plug-in '" + library + "' cannot be used: " + made.error() + ".");
  }
  return std::move(*made);
}

}  // namespace

tl::expected<Process, std::string> loadPluginProcess(const std::string& library, std::string_view configurationJson,
                                                     std::chrono::milliseconds stepTimeout) {
  auto loaded = loadInstance(library, configurationJson);
  if (!loaded) {
    return loaded;
  }
  const auto again = [library, configuration = std::string(configurationJson)]() -> Process {
    auto fresh = loadInstance(library, configuration);
    return fresh ? std::move(*fresh) : nullptr;
  };
  return supervised(std::move(*loaded), {.stepTimeout = stepTimeout, .again = again});
}

}  // namespace espalier::server
