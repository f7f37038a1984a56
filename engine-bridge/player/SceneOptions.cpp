#include "engine-bridge/player/SceneOptions.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>
#include <array>
#include <vector>

namespace midair::bridge
{

namespace
{

ContactRendererOptions contactsOf(const SceneSettings& settings)
{
    ContactRendererOptions contacts;
    contacts.shares.render = renderOf(settings.render);
    contacts.shares.trackerError_m = settings.trackerError;
    contacts.tracker.path.rate_Hz = settings.contactRate;
    contacts.tracker.path.largestStep_m = settings.contactStep;
    contacts.tracker.path.mostFoci = settings.contactFoci;
    contacts.field.mask = settings.contactMask;
    return contacts;
}

} // namespace

Render renderOf(SceneSettings::Render render)
{
    switch (render)
    {
    case SceneSettings::CONTACT:
        return Render::CONTACT;
    case SceneSettings::AUTO:
        return Render::AUTO;
    default:
        return Render::OBJECT;
    }
}

bool readPlaces(const std::string& text, Eigen::Matrix3Xd& places)
{
    std::vector<std::array<double, 3>> read;
    if (!base::parsePlaces(text, read)) return false;
    places.resize(3, static_cast<Eigen::Index>(read.size()));
    for (std::size_t l = 0; l < read.size(); ++l)
        places.col(static_cast<Eigen::Index>(l)) =
            Eigen::Map<const Eigen::Vector3d>(read[l].data());
    return true;
}

SceneSettings restricted(SceneSettings settings, const device::UserCaps& limits)
{
    using device::stricterPressure;
    settings.maxPressure = stricterPressure(limits.maxPressure_Pa, settings.maxPressure);
    settings.maxAmplitude = std::min(limits.maxAmplitude, settings.maxAmplitude);
    settings.earLimit = stricterPressure(limits.earLimit_dB, settings.earLimit);
    settings.earPoints = device::joinedPlaces(settings.earPoints, limits.earPoints);
    return settings;
}

HologramOptions optionsOf(const SceneSettings& given, double temperature_C)
{
    SceneSettings settings = given;
    settings.temperature = temperature_C;
    HologramOptions options;
    options.medium = haptics::mediumOf(settings);
    options.solver = settings.solver;
    base::assignPart<haptics::SolverSettings>(options.solverOptions, settings);
    base::assignPart<haptics::SequenceSettings>(options, settings);
    base::assignPart<haptics::PlayingSettings>(options, settings);
    readPlaces(settings.earPoints, options.earPoints);
    options.contacts = contactsOf(settings);
    options.solverFactory = makeAnySolver;
    return options;
}

} // namespace midair::bridge
