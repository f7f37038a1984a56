#pragma once

#include "device/ArrayDevice.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace midair::bridge
{

/// Opens a device on a thread of its own, and tries again and again if it can't be opened, so that
/// neither a frame nor a solve waits for it. The pauses between the tries double, up to
/// kMostPause_s.
class DeviceOpener
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;
    static constexpr double kMostPause_s = 30.0;
    /// The longest time from the beginning of a try that anybody waits for its end.
    static constexpr double kPatience_s = 3.0;

    /// \a open is called in the thread at once, and then, if it throws, after \a pause_s; 0: never
    /// again.
    DeviceOpener(Open open, double pause_s);
    /// Waits for a try that is under way, as long as await(). One that hangs is left to the thread,
    /// which closes at once what it opens; the log says so.
    ~DeviceOpener();

    DeviceOpener(const DeviceOpener&) = delete;
    DeviceOpener& operator=(const DeviceOpener&) = delete;

    /// Waits for the end of the first try, at most kPatience_s. Returns false if it hasn't ended.
    bool await();

    /// Returns the device if it is open by now, and then tries no more; else null. \a failed:
    /// number of tries that have failed since the last call; if any, \a why is the reason of the
    /// last one.
    std::unique_ptr<device::ArrayDevice> take(std::uint64_t& failed, std::string& why);

private:
    struct Shared;

    std::shared_ptr<Shared> _shared; ///< outlives this object in a thread that is left behind
    std::thread _thread;
};

} // namespace midair::bridge
