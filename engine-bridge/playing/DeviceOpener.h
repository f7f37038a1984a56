#pragma once

#include "device/ArrayDevice.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace midair::bridge
{

/// Opens a device on a separate thread and retries until it succeeds, so that no frame or solve
/// waits for it. The pauses between tries double, up to kMostPause_s.
class DeviceOpener
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;
    static constexpr double kMostPause_s = 30.0;
    /// Longest wait for a try, from its start.
    static constexpr double kPatience_s = 3.0;

    /// \a open is called in the thread at once, and after a throw again after \a pause_s; 0: not
    /// again.
    DeviceOpener(Open open, double pause_s);
    /// Waits for a running try like await(). A hanging try is left to its thread, which closes the
    /// device as soon as it opens; the log reports it.
    ~DeviceOpener();

    DeviceOpener(const DeviceOpener&) = delete;
    DeviceOpener& operator=(const DeviceOpener&) = delete;

    /// Waits at most kPatience_s for the end of the first try. Returns false if it hasn't ended.
    bool await();

    /// Returns the device once it is open, and then stops trying; otherwise null. \a failed: number
    /// of failed tries since the last call; if there are any, \a why is the reason of the last one.
    std::unique_ptr<device::ArrayDevice> take(std::uint64_t& failed, std::string& why);

private:
    struct Shared;

    std::shared_ptr<Shared> _shared; ///< outlives this object if its thread hangs
    std::thread _thread;
};

} // namespace midair::bridge
