#include "engine-bridge/extending/ArrayDriver.h"

#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/extending/DriverDevice.h"
#include "haptics/base/ThrownBy.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Arguments for opening a driver.
struct Asked
{
    std::string path;
    std::map<std::string, std::string> options;
    ArrayDriver::Layout layout;
};

/// Silences a driver that is released before playing. Returns a suffix for the reason if that
/// failed.
std::string silenced(ArrayDriver& driver)
{
    const std::string thrown = base::thrownBy([&] { driver.silence(); });
    if (thrown.empty()) return {};
    return "; its silence() has thrown " + thrown + ", too, so the array may play";
}

/// Opens a driver and returns its properties; null, with the reason in \a why, if it can't be made
/// or opened. This is application code: its exceptions become reasons.
std::optional<DriverDevice::Opened>
openDriver(const ArrayDriverFactory& make, const Asked& asked, std::string& why)
{
    std::shared_ptr<ArrayDriver> driver;
    bool isOpen = false;
    DriverDevice::Opened opened;
    const std::string thrown = base::thrownBy(
        [&]
        {
            driver = make();
            isOpen = driver && driver->open(asked.path, asked.options, asked.layout, why);
            if (isOpen) opened = DriverDevice::ask(driver);
        });
    if (thrown.empty() && isOpen) return opened;
    const std::string unsilenced = isOpen ? silenced(*driver) : std::string();
    if (!thrown.empty())
        why = "its driver has thrown " + thrown + unsilenced;
    else if (!driver)
        why = "its driver could not be made";
    else if (why.empty())
        why = "its driver could not open it";
    return std::nullopt;
}

} // namespace

bool registerDriver(const std::string& scheme, ArrayDriverFactory make, std::string& error)
{
    if (!make)
    {
        error = "the scheme \"" + scheme + "\" was registered without a factory";
        return false;
    }
    const auto open = [make = std::move(make)](device::DeviceUri& uri,
                                               const device::DeviceLayout& layout)
        -> std::unique_ptr<device::ArrayDevice>
    {
        const std::string name = uri.scheme() + ":" + uri.path();
        if (DriverDevice::isLeftBehind(name))
            throw uri.error("its last driver was closed but hasn't returned yet");
        std::string why;
        const ArrayDriver::Layout levels{static_cast<unsigned int>(layout.transducers),
                                         layout.board};
        auto opened = openDriver(make, {uri.path(), uri.takeRest(), levels}, why);
        if (!opened) throw uri.error(why);
        const std::shared_ptr<ArrayDriver> driver = opened->driver;
        try
        {
            return std::make_unique<DriverDevice>(std::move(*opened), name, layout.transducers);
        }
        catch (const device::DeviceError& error)
        {
            throw device::DeviceError(error.what() + silenced(*driver));
        }
    };
    return device::registerScheme({scheme, open}, error);
}

} // namespace midair::bridge
