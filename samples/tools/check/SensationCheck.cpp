#include "samples/tools/check/SensationCheck.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationFigures.h"
#include "haptics/sensation/SensationReader.h"
#include "samples/shared/SensationOnDevice.h"
#include "samples/shared/SettingOptions.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// Returns "; ultraino: takes 100 fields a second: the brush is an outline"; empty if the device
/// plays each field, if only the hardware knows, or if the scene's messages tell what is wrong with
/// it.
std::string onItsDevice(const CheckedScene& scene,
                        haptics::SensationPlayer& player,
                        const haptics::SensationFigures& figures)
{
    const std::string& device = scene.granted.device;
    try
    {
        const auto store = storeOf(device, scene.transducers, scene.granted.fieldRate);
        const std::string made = store ? onDevice(player, figures, *store) : std::string();
        return made.empty() ? made : fmt::format("; {} {}", device, made);
    }
    catch (const device::DeviceError&)
    {
        return {};
    }
}

/// Returns "40 x 40 x 0 mm, 8.8 m/s, 14 fields a turn at 1000 a second", and what the scene's
/// device makes of it; empty if it can't be read.
std::string figuresOf(const osgMidair::HapticProperty& property, const CheckedScene& scene)
{
    try
    {
        auto pattern =
            std::make_shared<const haptics::Sensation>(haptics::loadSensation(property.sensation));
        haptics::SensationPlayer player(std::move(pattern));
        const haptics::SensationFigures figures = haptics::measureSensation(player);
        const Eigen::Vector3d size_mm = figures.high_mm - figures.low_mm;
        if (!size_mm.allFinite()) return "its sensation is silent";
        std::string text = fmt::format(
            "as authored, its sensation is {:.0f} x {:.0f} x {:.0f} mm large, {:.1f} m/s fast",
            size_mm.x(),
            size_mm.y(),
            size_mm.z(),
            figures.speed_m_s);
        const double rate_Hz = scene.granted.fieldRate;
        const double perTurn = figures.pointsPerTurn(rate_Hz);
        if (std::isfinite(perTurn))
            text += fmt::format(", with {:.0f} fields a turn at {:g} a second", perTurn, rate_Hz);
        if (figures.duration_ms)
            text += fmt::format(", and ends after {:g} ms", *figures.duration_ms);
        return text + onItsDevice(scene, player, figures);
    }
    catch (const base::InputError&)
    {
        return {}; // the scene's messages have the reason
    }
}

} // namespace

bool isSensation(const CheckedObject& object)
{
    return !base::trimmed(object.property.sensation).empty();
}

bool judgeSensation(CheckedObject& object, const CheckedScene& scene)
{
    using Property = osgMidair::HapticProperty;
    const Property& property = object.property;
    std::string figures = figuresOf(property, scene);
    if (!figures.empty()) object.notes.push_back(std::move(figures));
    const bool isBroken = std::any_of(scene.messages.begin(),
                                      scene.messages.end(),
                                      [&object](const CheckedMessage& one) {
                                          return one.message.path == object.path &&
                                                 one.message.code == "property.invalid";
                                      });
    if (object.points > 0 || object.feltFrames > 0) return true;
    const bool needsHand =
        property.attach.rfind("hand:", 0) == 0 || property.trigger == Property::TOUCH_BEGIN ||
        property.trigger == Property::TOUCH_STAY || property.trigger == Property::TOUCH_END;
    if (isBroken) return false;
    if (property.trigger == Property::PROGRAM && property.plays == 0)
        object.warnings.push_back("not tested: it plays when the program says so");
    else if (needsHand && isRecording(scene.granted.hands))
        object.faults.push_back("no recorded hand makes it play");
    else if (needsHand)
        object.warnings.push_back(
            "not tested: it needs a hand. Add a hand recording: -O hands=recorded:FILE");
    else
        return false;
    return true;
}

} // namespace midair::samples
