#include "engine-bridge/c/inside/SceneSettings.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/rendering/ContactSettings.h"
#include "engine-bridge/settings/SharedRows.h"
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

} // namespace

const SettingTable<SceneSettings>& sceneTable()
{
    static const SettingTable<S> table(
        joined<S>({{Row<S>("enabled", &S::enabled, "false: the array is silent").safety()},
                   inherited<S>(haptics::fieldSettings().rows()),
                   bridge::reachRows<S>(),
                   {bridge::earPointsRow<S>()}, // midair_set() judges the text
                   bridge::contactRows<S>({static_cast<int>(bridge::Render::OBJECT),
                                           static_cast<int>(bridge::Render::CONTACT),
                                           static_cast<int>(bridge::Render::AUTO)})}));
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
    options.contacts = bridge::contactsOf(settings, settings.render);
    options.solverFactory = bridge::makeAnySolver;
    options.owner = "a scene of libmidair";
    return options;
}

} // namespace midair::capi
