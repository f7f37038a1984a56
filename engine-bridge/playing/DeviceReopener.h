#pragma once

#include "device/ArrayDevice.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace midair::bridge
{

/// Tries again and again to open a device that could not be opened, on a thread of its own, so that
/// neither a frame nor a solve waits for it. The pauses between the tries double, up to
/// kMostPause_s.
class DeviceReopener
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;
    static constexpr double kMostPause_s = 30.0;

    /// \a open is called in the thread, for the first time after \a pause_s (> 0).
    DeviceReopener(Open open, double pause_s);
    /// Waits for a try that is under way.
    ~DeviceReopener();

    DeviceReopener(const DeviceReopener&) = delete;
    DeviceReopener& operator=(const DeviceReopener&) = delete;

    /// Returns the device if it is open by now, and then tries no more; else null. \a failed:
    /// number of tries that have failed since the last call; if any, \a why is the reason of the
    /// last one.
    std::unique_ptr<device::ArrayDevice> take(std::uint64_t& failed, std::string& why);

private:
    void run(double pause_s);

    const Open _open;
    std::mutex _mutex; ///< guards the members below
    std::condition_variable _wake;
    bool _stop = false;
    std::unique_ptr<device::ArrayDevice> _device; ///< open, and not taken yet
    std::uint64_t _failed = 0;
    std::string _why;
    std::thread _thread; ///< last: it uses all other members
};

} // namespace midair::bridge
