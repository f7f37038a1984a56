#include "engine-bridge/playing/DeviceOpener.h"

#include "device/DeviceLog.h"
#include "device/limits/DeviceClaim.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

/// State shared between the thread and its owner.
struct DeviceOpener::Shared
{
    Shared(Open itsOpen, double itsPause_s) : open(std::move(itsOpen)), pause_s(itsPause_s) {}

    void run() MIDAIR_EXCLUDES(mutex);
    // Waits for the running try; returns false if it takes longer than the patience.
    bool awaitTry(base::Lock& lock) MIDAIR_REQUIRES(mutex)
    {
        const double until_s = began_s + kPatience_s;
        while (isTrying && base::steadySeconds() < until_s)
            base::steadyClock().wait(wake, lock, until_s);
        return !isTrying;
    }

    const Open open;
    const double pause_s;
    /// The owner no longer waits for the thread.
    const std::shared_ptr<std::atomic<bool>> isLeft = std::make_shared<std::atomic<bool>>(false);
    base::Mutex mutex;
    base::Condition wake;
    bool stop MIDAIR_GUARDED_BY(mutex) = false;
    bool isTrying MIDAIR_GUARDED_BY(mutex) = true;
    double began_s MIDAIR_GUARDED_BY(mutex) = base::steadySeconds(); ///< start of the try
    int tries MIDAIR_GUARDED_BY(mutex) = 1;
    /// open, and not taken yet
    std::unique_ptr<device::ArrayDevice> device MIDAIR_GUARDED_BY(mutex);
    std::uint64_t failed MIDAIR_GUARDED_BY(mutex) = 0;
    std::string why MIDAIR_GUARDED_BY(mutex);
};

void DeviceOpener::Shared::run()
{
    double rest_s = pause_s;
    device::openFor(isLeft);
    base::Lock lock(mutex);
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
        wake.notifyAll();
        if (isOpen || stop || rest_s <= 0.0)
        {
            lock.unlock();
            return; // destroys the device, which is no longer needed
        }
        const double until_s = base::steadySeconds() + rest_s;
        while (!stop && base::steadySeconds() < until_s)
            base::steadyClock().wait(wake, lock, until_s);
        if (stop) return;
        rest_s = std::min(2.0 * rest_s, kMostPause_s);
        isTrying = true;
        began_s = base::steadySeconds();
        ++tries;
    }
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
        base::Lock lock(_shared->mutex);
        _shared->stop = true;
        _shared->wake.notifyAll();
        ended = _shared->awaitTry(lock);
        *_shared->isLeft = !ended;
    }
    if (ended)
    {
        _thread.join();
        return;
    }
    _thread.detach();
    device::logDeviceError(fmt::format("device: opening it has taken {:g} s and is given up; if it "
                                       "opens later, it is silenced and closed at once",
                                       kPatience_s));
}

bool DeviceOpener::await()
{
    base::Lock lock(_shared->mutex);
    return _shared->tries > 1 || _shared->awaitTry(lock);
}

std::unique_ptr<device::ArrayDevice> DeviceOpener::take(std::uint64_t& failed, std::string& why)
{
    const base::Lock lock(_shared->mutex);
    failed = std::exchange(_shared->failed, 0);
    if (failed > 0) why = _shared->why;
    return std::move(_shared->device);
}

} // namespace midair::bridge
