#include "engine-bridge/extending/ArrayDriver.h"

#include <osgMidair/DeviceDriver>

#include <memory>
#include <utility>

namespace osgMidair
{

bool registerDevice(const std::string& scheme, DeviceDriverFactory make, std::string& error)
{
    midair::bridge::ArrayDriverFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<ArrayDriver>
        {
            osg::ref_ptr<DeviceDriver> driver = make();
            ArrayDriver* const called = driver.get();
            if (!called) return nullptr;
            return {called, [driver](ArrayDriver*) mutable { driver = nullptr; }};
        };
    return midair::bridge::registerDriver(scheme, std::move(adapted), error);
}

} // namespace osgMidair
