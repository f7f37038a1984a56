#include "device/DeviceUri.h"
#include "device/opening/DeviceRegistry.h"
#include "haptics/base/ThrownBy.h"
#include "plugin/extending/DriverDevice.h"

#include <osgMidair/DeviceDriver>

#include <memory>
#include <utility>

namespace osgMidair
{

namespace
{

/// What a driver is to open.
struct Asked
{
    std::string path;
    std::map<std::string, std::string> options;
    DeviceDriver::Layout layout;
};

/// Returns the open driver; null, with the reason in \a why, if it can't be made or opened. It is
/// an application's code: what it throws is a reason.
osg::ref_ptr<DeviceDriver> openDriver(const DeviceDriverFactory& make,
                                      const Asked& asked,
                                      DriverDevice::Ability& ability,
                                      std::string& why)
{
    osg::ref_ptr<DeviceDriver> driver;
    bool isOpen = false;
    const std::string thrown = midair::base::thrownBy(
        [&]
        {
            driver = make();
            isOpen = driver && driver->open(asked.path, asked.options, asked.layout, why);
            if (isOpen) ability = DriverDevice::abilityOf(*driver);
        });
    if (thrown.empty() && isOpen) return driver;
    if (isOpen) midair::base::thrownBy([&] { driver->silence(); });
    if (!thrown.empty())
        why = "its driver has thrown " + thrown;
    else if (!driver)
        why = "its driver could not be made";
    else if (why.empty())
        why = "its driver could not open it";
    return nullptr;
}

} // namespace

bool registerDevice(const std::string& scheme, DeviceDriverFactory make, std::string& error)
{
    if (!make)
    {
        error = "the scheme \"" + scheme + "\" has nothing that makes its driver";
        return false;
    }
    const auto open = [make = std::move(make)](midair::device::DeviceUri& uri,
                                               const midair::device::DeviceLayout& layout)
        -> std::unique_ptr<midair::device::ArrayDevice>
    {
        const DeviceDriver::Layout asked{static_cast<unsigned int>(layout.transducers),
                                         layout.board};
        std::string why;
        DriverDevice::Ability ability;
        const osg::ref_ptr<DeviceDriver> driver =
            openDriver(make, {uri.path(), uri.takeRest(), asked}, ability, why);
        if (!driver) throw uri.error(why);
        return std::make_unique<DriverDevice>(
            driver, ability, uri.scheme() + ":" + uri.path(), layout.transducers);
    };
    return midair::device::registerScheme({scheme, open}, error);
}

} // namespace osgMidair
