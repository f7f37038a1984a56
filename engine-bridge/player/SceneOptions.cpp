#include "engine-bridge/player/SceneOptions.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/sensations/SensationLibrary.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/Words.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>

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
    contacts.tracker.hold_s = contacts.shares.hold_s = settings.contactHold;
    return contacts;
}

/// Overrides the numbers of \a material with those that are not 0 in \a settings.
void replaceNumbers(HapticMaterial& material, const ObjectSettings& settings)
{
    const auto replace = [](double own, double& value)
    {
        if (own != 0.0) value = own;
    };
    replace(settings.stiffness, material.stiffness_N_m);
    replace(settings.contactForce, material.mostForce_N);
    replace(settings.softness, material.radiusGrowth);
    replace(settings.roughness, material.roughness);
    replace(settings.texturePeriod, material.texturePeriod_m);
    replace(settings.lowVibration, material.lowVibration);
    replace(settings.highVibration, material.highVibration);
    constexpr double kLeastRadius_m = 1e-3; // that grows
    if (settings.softness > 0.0 && !(material.radius_m > 0.0)) material.radius_m = kLeastRadius_m;
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

const MaterialLibrary& materials()
{
    static const MaterialLibrary library = MaterialLibrary::ofUser();
    return library;
}

ObjectMaterial materialOf(const ObjectSettings& settings)
{
    ObjectMaterial made;
    if (!settings.material.empty())
    {
        const HapticMaterial* named = materials().find(settings.material);
        if (named)
            made.material = *named;
        else
        {
            made.isUnknown = true;
            made.problem = "material \"" + settings.material + "\" is unknown" +
                           base::didYouMean(settings.material, materials().names());
            return made;
        }
    }
    replaceNumbers(made.material, settings);
    made.material.isValid(&made.problem);
    return made;
}

HapticProperties propertiesOf(const ObjectSettings& settings, const HapticMaterial& material)
{
    using S = ObjectSettings;
    HapticProperties p;
    p.pressure = settings.pressure;
    p.pressureInPa = settings.pressureUnit == S::PASCAL;
    p.spacing_m = settings.spacing;
    p.sampling = settings.sampling == S::EDGES      ? haptics::Sampling::EDGES
                 : settings.sampling == S::VERTICES ? haptics::Sampling::VERTICES
                                                    : haptics::Sampling::SURFACE;
    p.side = settings.side == S::FRONT  ? Side::FRONT
             : settings.side == S::BACK ? Side::BACK
                                        : Side::BOTH;
    p.priority = settings.priority;
    p.modulationFrequency_Hz = settings.modulationFrequency;
    p.modulationDepth = settings.modulationDepth;
    p.render = settings.render == S::INHERIT
                   ? Render::INHERIT
                   : renderOf(static_cast<SceneSettings::Render>(settings.render));
    p.material = material;
    p.sensation = sensationOf(settings).properties;
    return p;
}

SceneSettings restricted(SceneSettings settings, const device::UserCaps& limits)
{
    using device::stricterCap;
    settings.maxPressure = stricterCap(limits.maxPressure_Pa, settings.maxPressure);
    settings.maxAmplitude = std::min(limits.maxAmplitude, settings.maxAmplitude);
    settings.earLimit = stricterCap(limits.earLimit_dB, settings.earLimit);
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
