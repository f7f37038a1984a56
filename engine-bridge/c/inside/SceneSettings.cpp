#include "engine-bridge/c/inside/SceneSettings.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <vector>

namespace midair::base
{

template struct Setting<capi::SceneSettings>;
template bool
isSame(const Member<capi::SceneSettings>&, const capi::SceneSettings&, const capi::SceneSettings&);

} // namespace midair::base

namespace midair::capi
{

namespace
{

using namespace base;

using S = SceneSettings;

constexpr std::size_t kMostPlaces = 64;

std::vector<Setting<S>> hands()
{
    return {Row<S>("reach", &S::reach, "solve only points this near to a hand; 0: all")
                .range(0.0, 10.0, "m")
                .safety(),
            Row<S>("shadows",
                   &S::shadows,
                   "hands and obstacles block sound, which the solver takes into account")};
}

// midair_set() judges the text.
std::vector<Setting<S>> ears()
{
    return {Row<S>("earPoints",
                   &S::earPoints,
                   "listening places besides those around the array: x y z; x y z .. in m, array "
                   "frame",
                   6)
                .safety()};
}

std::vector<Setting<S>> contacts()
{
    return {
        Row<S>("render",
               EnumMember<&S::render>::choice(),
               "what is played of objects: the whole, foci on the skin where hands touch, or auto: "
               "these while hands are known well enough",
               7)
            .words({{"object", "OBJECT", static_cast<int>(bridge::Render::OBJECT)},
                    {"contact", "CONTACT", static_cast<int>(bridge::Render::CONTACT)},
                    {"auto", "AUTO", static_cast<int>(bridge::Render::AUTO)}}),
        Row<S>("contactRate", &S::contactRate, "turns a second of the foci of a contact", 7)
            .range(0.0, 100.0, "Hz"),
        Row<S>("contactStep", &S::contactStep, "longest step of a focus from field to field", 7)
            .range(5e-5, 5e-3, "m"),
        Row<S>("contactFoci", &S::contactFoci, "most foci of a contact", 7).range(1, 10),
        Row<S>("contactMask",
               &S::contactMask,
               "transducers behind the finger are off, so that its other side isn't pressed",
               7),
        Row<S>("trackerError",
               &S::trackerError,
               "error of the hands' places, by which auto decides",
               7)
            .range(0.0, 0.1, "m")};
}

/// Reads "30 0 60 cm", a unit behind it counting for all three.
bool readPlace(const std::string& text, Eigen::Vector3d& place)
{
    std::istringstream words(text);
    std::vector<std::string> parts;
    for (std::string part; words >> part;)
        parts.push_back(part);
    if (parts.size() != 3 && parts.size() != 4) return false;
    const std::string unit = parts.size() == 4 ? parts[3] : "";
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!parseQuantity(parts[axis] + unit, "m", place[static_cast<Eigen::Index>(axis)]))
            return false;
    return true;
}

/// Lowers a cap of \a settings to the one that the user's environment has. Returns false for one
/// that isn't understood, with what is wrong in \a error.
bool keepUsersCap(const char* name, SceneSettings& settings, std::string& error)
{
    const Setting<S>& row = *sceneTable().find(name);
    const std::string variable = "OSG_MIDAIR_" + haptics::fieldSettings().find(name)->variable;
    const auto text = userVariable(variable);
    if (!text) return true;
    S users;
    if (!row.assign(users, *text) || !row.holds(users))
    {
        error =
            variable + " is \"" + *text + "\", should be " + row.expected() + "; nothing is played";
        return false;
    }
    settings.maxPressure = device::stricterPressure(settings.maxPressure, users.maxPressure);
    settings.maxAmplitude = std::min(settings.maxAmplitude, users.maxAmplitude);
    settings.earLimit = device::stricterPressure(settings.earLimit, users.earLimit);
    return true;
}

bridge::ContactRendererOptions contactsOf(const SceneSettings& settings)
{
    bridge::ContactRendererOptions contacts;
    contacts.shares.render = settings.render;
    contacts.shares.trackerError_m = settings.trackerError;
    contacts.tracker.path.rate_Hz = settings.contactRate;
    contacts.tracker.path.largestStep_m = settings.contactStep;
    contacts.tracker.path.mostFoci = settings.contactFoci;
    contacts.field.mask = settings.contactMask;
    return contacts;
}

} // namespace

const SettingTable<SceneSettings>& sceneTable()
{
    static const SettingTable<S> table(
        joined<S>({{Row<S>("enabled", &S::enabled, "false: the array is silent").safety()},
                   inherited<S>(haptics::fieldSettings().rows()),
                   hands(),
                   ears(),
                   contacts()}));
    return table;
}

bool readPlaces(const std::string& text, Eigen::Matrix3Xd& places)
{
    std::vector<Eigen::Vector3d> read;
    std::istringstream all(text);
    for (std::string one; std::getline(all, one, ';');)
    {
        if (trimmed(one).empty()) continue;
        if (read.size() == kMostPlaces || !readPlace(one, read.emplace_back())) return false;
    }
    places.resize(3, static_cast<Eigen::Index>(read.size()));
    for (std::size_t l = 0; l < read.size(); ++l)
        places.col(static_cast<Eigen::Index>(l)) = read[l];
    return true;
}

bridge::HologramOptions optionsOf(const SceneSettings& given)
{
    bridge::HologramOptions options;
    SceneSettings settings = given;
    for (const char* cap : {"maxPressure", "maxAmplitude", "earLimit"})
    {
        std::string error;
        if (keepUsersCap(cap, settings, error)) continue;
        settings.maxAmplitude = 0.0;
        options.notes.push_back({MessageCode::SETTINGS_SILENCED, error});
    }
    options.medium = haptics::mediumOf(settings);
    options.solver = settings.solver;
    assignPart<haptics::SolverSettings>(options.solverOptions, settings);
    assignPart<haptics::SequenceSettings>(options, settings);
    assignPart<haptics::PlayingSettings>(options, settings);
    readPlaces(settings.earPoints, options.earPoints);
    options.contacts = contactsOf(settings);
    options.solverFactory = bridge::makeAnySolver;
    options.owner = "a scene of libmidair";
    return options;
}

} // namespace midair::capi
