#pragma once

#include <functional>
#include <string>

namespace spdlog
{
class logger;
}

namespace midair::device
{

/// Log for spontaneous device events, such as an unplug: spdlog's default logger until
/// sendDeviceLogTo() is called. Any thread.
spdlog::logger& deviceLog();
/// Logs \a line as an error, for code that doesn't link the logger. Any thread.
void logDeviceError(const std::string& line);
void logDeviceNote(const std::string& line); ///< the same, as information

/// Sends each line of deviceLog() to \a receiver instead of spdlog's default logger, on the thread
/// that logs it; \a isWarning: above information. Call it once, before devices are opened.
void sendDeviceLogTo(std::function<void(bool isWarning, const std::string& line)> receiver);

} // namespace midair::device
