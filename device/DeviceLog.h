#pragma once

#include <functional>
#include <string>

namespace spdlog
{
class logger;
}

namespace midair::device
{

/// The log for what happens to devices by itself, such as an unplug: spdlog's default logger until
/// sendDeviceLogTo() is called. Any thread.
spdlog::logger& deviceLog();
/// Logs \a line as an error, for those who don't link the logger themselves. Any thread.
void logDeviceError(const std::string& line);
void logDeviceNote(const std::string& line); ///< the same, as information

/// From now on \a receiver gets each line of deviceLog() in place of spdlog's default logger, on
/// the thread that it comes from; true: it is more than information. To be called once, before
/// devices are opened.
void sendDeviceLogTo(std::function<void(bool isWarning, const std::string& line)> receiver);

} // namespace midair::device
