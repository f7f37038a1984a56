#include "engine-bridge/playing/DeviceOpener.h"

#include "device/DeviceLog.h"
#include "device/limits/DeviceClaim.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

/// What the thread and its owner share.
struct DeviceOpener::Shared
{
    Shared(Open itsOpen, double itsPause_s) : open(std::move(itsOpen)), pause_s(itsPause_s) {}

    void run();
    bool awaitTry(std::unique_lock<std::mutex>& lock);

    const Open open;
    const double pause_s;
    /// Nobody waits for the thread any more.
    const std::shared_ptr<std::atomic<bool>> isLeft = std::make_shared<std::atomic<bool>>(false);
    std::mutex mutex; ///< guards what follows
    std::condition_variable wake;
    bool stop = false;
    bool isTrying = true;
    double began_s = base::steadySeconds(); ///< of the try
    int tries = 1;
    std::unique_ptr<device::ArrayDevice> device; ///< open, and not taken yet
    std::uint64_t failed = 0;
    std::string why;
};

void DeviceOpener::Shared::run()
{
    double rest_s = pause_s;
    device::openFor(isLeft);
    std::unique_lock<std::mutex> lock(mutex);
    for (;;)
    {
        lock.unlock();
        std::unique_ptr<device::ArrayDevice> opened;
        std::string reason;
        try
        {
            opened = open();
        }
        catch (...)
        {
            reason = base::whatWasThrown();
        }
        lock.lock();
        isTrying = false;
        const bool isOpen = opened != nullptr;
        if (!stop) device = std::move(opened);
        if (!isOpen)
        {
            ++failed;
            why = reason.empty() ? "no device was given" : std::move(reason);
        }
        wake.notify_all();
        if (isOpen || stop || rest_s <= 0.0)
        {
            lock.unlock();
            return; // closes what nobody wants any more
        }
        if (wake.wait_for(lock, std::chrono::duration<double>(rest_s), [this] { return stop; }))
            return;
        rest_s = std::min(2.0 * rest_s, kMostPause_s);
        isTrying = true;
        began_s = base::steadySeconds();
        ++tries;
    }
}

// Returns false if the try that is under way hasn't ended when nobody should wait any more.
bool DeviceOpener::Shared::awaitTry(std::unique_lock<std::mutex>& lock)
{
    const double rest_s = began_s + kPatience_s - base::steadySeconds();
    return wake.wait_for(
        lock, std::chrono::duration<double>(std::max(rest_s, 0.0)), [this] { return !isTrying; });
}

DeviceOpener::DeviceOpener(Open open, double pause_s) :
    _shared(std::make_shared<Shared>(std::move(open), pause_s)),
    _thread([shared = _shared] { shared->run(); })
{
}

DeviceOpener::~DeviceOpener()
{
    bool ended = false;
    {
        std::unique_lock<std::mutex> lock(_shared->mutex);
        _shared->stop = true;
        _shared->wake.notify_all();
        ended = _shared->awaitTry(lock);
        *_shared->isLeft = !ended;
    }
    if (ended)
    {
        _thread.join();
        return;
    }
    _thread.detach();
    device::logDeviceError(
        fmt::format("device: opening it hasn't ended for {:g} s and isn't waited for any more; if "
                    "it opens after all, it is silenced and closed at once",
                    kPatience_s));
}

bool DeviceOpener::await()
{
    std::unique_lock<std::mutex> lock(_shared->mutex);
    return _shared->tries > 1 || _shared->awaitTry(lock);
}

bool DeviceOpener::isFirstTry() const
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    return _shared->tries == 1 && _shared->isTrying;
}

std::unique_ptr<device::ArrayDevice> DeviceOpener::take(std::uint64_t& failed, std::string& why)
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    failed = std::exchange(_shared->failed, 0);
    if (failed > 0) why = _shared->why;
    return std::move(_shared->device);
}

} // namespace midair::bridge
