#include "plugin/report/DeviceLines.h"

#include "device/DeviceLog.h"

#include <osg/Notify>

#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

namespace
{

constexpr std::size_t kMost = 1000; // lines that wait, if nobody updates a scene any more

struct Lines
{
    std::mutex mutex;
    std::vector<std::pair<bool, std::string>> waiting;
};

// Never destroyed: devices may be closed while the program ends.
Lines& lines()
{
    static auto* const all = new Lines;
    return *all;
}

} // namespace

void collectDeviceLines()
{
    static const bool once = []
    {
        midair::device::sendDeviceLogTo(
            [](bool isWarning, const std::string& line)
            {
                const std::lock_guard<std::mutex> lock(lines().mutex);
                if (lines().waiting.size() < kMost) lines().waiting.emplace_back(isWarning, line);
            });
        return true;
    }();
    (void)once;
}

void tellDeviceLines()
{
    std::vector<std::pair<bool, std::string>> waiting;
    {
        const std::lock_guard<std::mutex> lock(lines().mutex);
        waiting.swap(lines().waiting);
    }
    for (const auto& [isWarning, line] : waiting)
        osg::notify(isWarning ? osg::WARN : osg::NOTICE) << "osgMidair: " << line << std::endl;
}

} // namespace osgMidair
