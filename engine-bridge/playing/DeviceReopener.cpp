#include "engine-bridge/playing/DeviceReopener.h"

#include "haptics/base/ThrownBy.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace midair::bridge
{

DeviceReopener::DeviceReopener(Open open, double pause_s) :
    _open(std::move(open)),
    _thread([this, pause_s] { run(pause_s); })
{
}

DeviceReopener::~DeviceReopener()
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _stop = true;
    }
    _wake.notify_all();
    _thread.join();
}

std::unique_ptr<device::ArrayDevice> DeviceReopener::take(std::uint64_t& failed, std::string& why)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    failed = std::exchange(_failed, 0);
    if (failed > 0) why = _why;
    return std::move(_device);
}

void DeviceReopener::run(double pause_s)
{
    std::unique_lock<std::mutex> lock(_mutex);
    while (!_wake.wait_for(lock, std::chrono::duration<double>(pause_s), [this] { return _stop; }))
    {
        lock.unlock();
        std::unique_ptr<device::ArrayDevice> device;
        std::string why;
        try
        {
            device = _open();
        }
        catch (...)
        {
            why = base::whatWasThrown();
        }
        lock.lock();
        _device = std::move(device);
        if (_device) return;
        ++_failed;
        _why = std::move(why);
        pause_s = std::min(2.0 * pause_s, kMostPause_s);
    }
}

} // namespace midair::bridge
