#pragma once

#include <functional>
#include <string_view>

namespace espalier::command {

/// Tells the service manager a state, as sd_notify(3) does: "READY=1". Nothing happens when no service manager started
/// the program (NOTIFY_SOCKET is not set).
void notifyService(std::string_view state);

/// A function that gives the service manager a sign of life. Null when it wants none (WATCHDOG_USEC is not set).
[[nodiscard]] std::function<void()> watchdogSignal();

}  // namespace espalier::command
