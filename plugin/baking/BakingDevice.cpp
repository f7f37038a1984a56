#include "plugin/baking/BakingDevice.h"

#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/RigidBodyCallback>

#include <osg/ImageStream>
#include <osg/NodeVisitor>
#include <osg/Texture>

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

// Whole periods of this many steps are handed over in one piece; nothing is sent step by step, as
// nobody listens.
constexpr int kSequenceFields = 1 << 14;

/// Finds what moves or looks otherwise by itself as time passes.
class FindLive : public osg::NodeVisitor
{
public:
    FindLive() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { setNodeMaskOverride(~0U); }

    void apply(osg::Node& node) override
    {
        const auto add = [&](const std::string& what)
        {
            const std::string name = node.getName().empty() ? "" : " '" + node.getName() + "'";
            std::string told = fmt::format("{}{}: {}", node.className(), printable(name), what);
            if (std::find(found.begin(), found.end(), told) == found.end())
                found.push_back(std::move(told));
        };
        for (const osg::Callback* callback = node.getUpdateCallback(); callback;
             callback = callback->getNestedCallback())
            if (dynamic_cast<const RigidBodyCallback*>(callback))
                add("a rigid body moves it, in steps by the wall's clock");
        if (std::string(node.libraryName()) == "osgParticle")
            add("particles are drawn by chance, otherwise each time");
        if (hasFilm(node.getStateSet())) add("a film in its texture plays by the wall's clock");
        traverse(node);
    }

    std::vector<std::string> found;

private:
    static bool hasFilm(const osg::StateSet* state)
    {
        if (!state) return false;
        for (unsigned int unit = 0; unit < state->getNumTextureAttributeLists(); ++unit)
        {
            const auto* texture = dynamic_cast<const osg::Texture*>(
                state->getTextureAttribute(unit, osg::StateAttribute::TEXTURE));
            for (unsigned int i = 0; texture && i < texture->getNumImages(); ++i)
                if (dynamic_cast<const osg::ImageStream*>(texture->getImage(i))) return true;
        }
        return false;
    }
};

} // namespace

BakingDevice::BakingDevice(int transducers) : _held(transducers) {}

bool BakingDevice::send(const midair::device::DriveSignal& signal)
{
    if (!signal.fits(_held.transducers()))
    {
        _counters.countRefused();
        return false;
    }
    _held.replace(signal);
    _counters.countPlayed(midair::base::steadySeconds());
    return true;
}

bool BakingDevice::sendSequence(const midair::device::DriveSequence& sequence)
{
    if (!sequence.fits(_held.transducers()))
    {
        _counters.countRefused();
        return false;
    }
    return send(sequence.signals.front());
}

midair::device::DriveAbility BakingDevice::ability() const
{
    midair::device::DriveAbility ability;
    ability.sequenceFields = kSequenceFields;
    return ability;
}

BakedLimits limitsOfDevice(const std::string& uri)
{
    using midair::device::SafetyLimits;
    BakedLimits all;
    for (const std::string& one : midair::device::splitDeviceList(uri))
    {
        midair::device::DeviceUri parsed(one);
        const SafetyLimits limits = midair::device::takeLimits(parsed, {});
        SafetyLimits& kept = all.limits;
        kept.maxAmplitude = std::min(kept.maxAmplitude, limits.maxAmplitude);
        kept.maxPressure_Pa =
            midair::device::stricterPressure(kept.maxPressure_Pa, limits.maxPressure_Pa);
        const auto leave = [&](const char* name, bool isSet)
        {
            if (!isSet) return;
            all.unkept.push_back(
                fmt::format("{} of the device \"{}\" goes by time and isn't in a recording: give "
                            "it to the device that plays, play:FILE?to={}:..?{}=..",
                            name,
                            one,
                            parsed.scheme(),
                            name));
        };
        leave("ramp", limits.ramp_s > 0.0);
        leave("mean-drive", limits.meanDrive < 1.0);
        leave("hold", limits.hold_s > 0.0);
    }
    return all;
}

std::vector<std::string> unbakeable(osg::Node& scene,
                                    const HapticSettings& settings,
                                    const std::vector<FoundObject>& found,
                                    bool hasOwnHands)
{
    std::vector<std::string> all;
    if (hasOwnHands || (!settings.hands.empty() && settings.hands != "none"))
        all.push_back(fmt::format(
            "hands \"{}\": where they will be while the recording is played isn't known",
            hasOwnHands ? "of the program" : printable(settings.hands)));
    if (settings.reach > 0.0)
        all.push_back(fmt::format("reach is {:g} m: only what is near a hand is felt, and there is "
                                  "none, so that nothing would be",
                                  settings.reach));
    const bool isContactByDefault = settings.render != HapticSettings::OBJECT;
    if (isContactByDefault)
        all.emplace_back("render is contact or auto: contacts are where hands touch");
    for (const FoundObject& object : found)
    {
        const auto own = object.property.render;
        if (own == HapticProperty::CONTACT || own == HapticProperty::AUTO)
            all.push_back(object.path + ": its render is contact or auto: contacts are where hands "
                                        "touch");
    }
    if (settings.earCamera)
        all.emplace_back("earCamera: there is no camera, so that no head is known at its place");
    FindLive finder;
    scene.accept(finder);
    std::sort(finder.found.begin(), finder.found.end());
    all.insert(all.end(), finder.found.begin(), finder.found.end());
    return all;
}

} // namespace osgMidair
