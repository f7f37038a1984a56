#include "plugin/hands/TrackedHands.h"

#include "device/DeviceUri.h"
#include "engine-bridge/hands/helper/HelperHandSource.h"
#include "engine-bridge/hands/helper/HelperProcess.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "engine-bridge/hands/osc/OscHandSource.h"
#include "plugin/hands/BridgedHands.h"
#include "plugin/hands/OscUri.h"
#include "plugin/settings/Assignments.h"

#include <stdexcept>

namespace osgMidair
{

namespace
{

using midair::device::DeviceUri;

/// A source of the bridge that has messages.
template<typename Source>
class TrackedHands : public BridgedHands<Source>
{
public:
    using BridgedHands<Source>::BridgedHands;

    bool setHorizon(double ahead) override { return this->_source.setHorizon(ahead); }
    std::vector<std::string> takeMessages() override { return this->_source.takeMessages(); }
};

/// The parameter matrix=.., a rigid matrix; \a otherwise if there is none.
Eigen::Isometry3d takePlacement(DeviceUri& uri, const Eigen::Isometry3d& otherwise)
{
    const std::string matrix = uri.takeText("matrix", "");
    if (matrix.empty()) return otherwise;
    osg::Matrixd given;
    midair::bridge::PoseAndStretch parts;
    if (!parseMatrix(matrix, given) ||
        !midair::bridge::decompose(midair::bridge::toEigen(given), parts) ||
        !parts.stretch.isIdentity(0.02))
        throw uri.error("matrix=" + matrix +
                        " should be 16 numbers of a rigid matrix, row by row, translation last");
    return parts.pose;
}

/// The helper opens what \a uri names without a helper, and sends those hands, in the scene's
/// world.
osg::ref_ptr<HandSource> openHelper(const DeviceUri& uri, const std::string& given)
{
    const std::string file = given.empty() ? midair::bridge::programBeside("midair-hands") : given;
    if (file.empty())
        throw uri.error(
            "the helper midair-hands is neither beside this program nor where the kit's "
            "programs are; helper=FILE names it");
    std::string own;
    std::size_t begin = uri.text().find('?') + 1;
    while (begin < uri.text().size())
    {
        const std::size_t end = std::min(uri.text().find('&', begin), uri.text().size());
        const std::string one = uri.text().substr(begin, end - begin);
        begin = end + 1;
        if (one.rfind("process=", 0) == 0 || one.rfind("helper=", 0) == 0) continue;
        own += (own.empty() ? "?" : "&") + one;
    }
    midair::bridge::HelperOptions options;
    options.command = {file,
                       "relay",
                       "openxr:" + own,
                       "--socket",
                       std::to_string(midair::bridge::HelperProcess::kSocket)};
    return new TrackedHands<midair::bridge::HelperHandSource>(options);
}

} // namespace

osg::ref_ptr<HandSource> openOpenXr(const std::string& text)
{
    using midair::bridge::OpenXrSpace;
    DeviceUri uri(text, "hand source");
    uri.rejectPath();
    midair::bridge::OpenXrOptions options;
    options.loader = uri.takeText("loader", options.loader);
    const std::string space = uri.takeText("space", "");
    if (!space.empty() && space != "stage" && space != "local")
        throw uri.error("space=" + space + " should be stage or local");
    if (!space.empty()) options.space = space == "stage" ? OpenXrSpace::STAGE : OpenXrSpace::LOCAL;
    const Eigen::Isometry3d placement =
        takePlacement(uri, midair::bridge::OpenXrHandSource::upright());
    const std::string process = uri.takeText("process", "own");
    const std::string helper = uri.takeText("helper", "");
    if (process != "own" && process != "helper")
        throw uri.error("process=" + process + " should be own or helper");
    if (!helper.empty() && process != "helper")
        throw uri.error("helper=" + helper + " takes process=helper");
    uri.rejectUnknown();
    if (process == "helper") return openHelper(uri, helper);
    return new TrackedHands<midair::bridge::OpenXrHandSource>(options, placement);
}

osg::ref_ptr<HandSource> openOsc(const std::string& text)
{
    DeviceUri uri(text, "hand source");
    const midair::bridge::OscOptions options = takeOscOptions(uri);
    const Eigen::Isometry3d placement = takePlacement(uri, Eigen::Isometry3d::Identity());
    uri.rejectUnknown();
    try
    {
        return new TrackedHands<midair::bridge::OscHandSource>(options, placement);
    }
    catch (const midair::base::InputError& wrong)
    {
        throw uri.error(wrong.what());
    }
}

} // namespace osgMidair
