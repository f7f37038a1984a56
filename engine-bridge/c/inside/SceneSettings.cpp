#include "engine-bridge/c/inside/SceneSettings.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/rendering/ContactSettings.h"
#include "engine-bridge/settings/SharedRows.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>
#include <array>
#include <string>
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
    std::vector<std::array<double, 3>> read;
    if (!parsePlaces(text, read)) return false;
    places.resize(3, static_cast<Eigen::Index>(read.size()));
    for (std::size_t l = 0; l < read.size(); ++l)
        places.col(static_cast<Eigen::Index>(l)) =
            Eigen::Map<const Eigen::Vector3d>(read[l].data());
    return true;
}

bridge::HologramOptions optionsOf(const SceneSettings& given, const device::UserCaps& caps)
{
    bridge::HologramOptions options;
    SceneSettings settings = given;
    settings.maxPressure = device::stricterPressure(settings.maxPressure, caps.maxPressure_Pa);
    settings.maxAmplitude = std::min(settings.maxAmplitude, caps.maxAmplitude);
    settings.earLimit = device::stricterPressure(settings.earLimit, caps.earLimit_dB);
    settings.earPoints = device::joinedPlaces(settings.earPoints, caps.earPoints);
    std::vector<std::string> wrong = caps.wrong;
    if (!readPlaces(settings.earPoints, options.earPoints))
        wrong.push_back("earPoints is \"" + settings.earPoints + "\", should be " +
                        kPlacesExpected + "; nothing is played");
    for (const std::string& why : wrong)
    {
        settings.maxAmplitude = 0.0;
        options.notes.push_back({MessageCode::SETTINGS_SILENCED, why});
    }
    options.medium = haptics::mediumOf(settings);
    options.solver = settings.solver;
    assignPart<haptics::SolverSettings>(options.solverOptions, settings);
    assignPart<haptics::SequenceSettings>(options, settings);
    assignPart<haptics::PlayingSettings>(options, settings);
    options.contacts = bridge::contactsOf(settings, settings.render);
    options.solverFactory = bridge::makeAnySolver;
    options.owner = "a scene of libmidair";
    return options;
}

} // namespace midair::capi
