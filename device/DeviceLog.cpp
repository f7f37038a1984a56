#include "device/DeviceLog.h"

#include <memory>
#include <mutex>
#include <utility>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

class ReceiverSink : public spdlog::sinks::base_sink<std::mutex>
{
public:
    using Receiver = std::function<void(bool, const std::string&)>;

    explicit ReceiverSink(Receiver receiver) : _receiver(std::move(receiver)) {}

private:
    void sink_it_(const spdlog::details::log_msg& message) override
    {
        _receiver(message.level >= spdlog::level::warn,
                  std::string(message.payload.data(), message.payload.size()));
    }
    void flush_() override {}

    Receiver _receiver;
};

std::shared_ptr<spdlog::logger>& ownLogger()
{
    // Never destroyed: devices may be closed while the program ends.
    static auto* const logger = new std::shared_ptr<spdlog::logger>;
    return *logger;
}

} // namespace

spdlog::logger& deviceLog()
{
    return ownLogger() ? *ownLogger() : *spdlog::default_logger_raw();
}

void logDeviceError(const std::string& line)
{
    deviceLog().error("{}", line);
}

void logDeviceNote(const std::string& line)
{
    deviceLog().info("{}", line);
}

void sendDeviceLogTo(std::function<void(bool isWarning, const std::string& line)> receiver)
{
    ownLogger() = std::make_shared<spdlog::logger>(
        "osgMidair", std::make_shared<ReceiverSink>(std::move(receiver)));
}

} // namespace midair::device
