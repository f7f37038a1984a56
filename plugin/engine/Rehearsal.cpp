#include "plugin/engine/Rehearsal.h"

#include "device/DeviceUri.h"
#include "device/opening/DeviceRegistry.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "plugin/hands/KitHands.h"
#include "plugin/settings/Grants.h"

#include <stdexcept>
#include <string>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;

namespace
{

/// Returns what is wrong with \a device; empty: it names kinds that this program has.
std::string unknownDevice(const std::string& device)
{
    try
    {
        for (const std::string& one : midair::device::splitDeviceList(device))
        {
            const midair::device::DeviceUri uri(one);
            if (!midair::device::isKnownScheme(uri.scheme()))
                return uri.error("unknown kind \"" + uri.scheme() + ":\"").what();
        }
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

std::vector<Message> rehearse(HapticSettings& settings)
{
    std::vector<Message> wrong;
    if (!Grants::isHarmlessDevice(settings.device))
    {
        const std::string why = unknownDevice(settings.device);
        if (!why.empty())
            wrong.emplace_back(MessageCode::DEVICE_OPEN, why + "; sim: plays in its place");
        settings.device = "sim:";
    }
    if (!midair::bridge::RecordedUri::parse(settings.hands))
    {
        const std::string why = unknownSceneHands(settings.hands);
        if (!why.empty()) wrong.emplace_back(MessageCode::HANDS_OPEN, why);
        settings.hands.clear();
    }
    return wrong;
}

} // namespace osgMidair
