#include "engine-bridge/hands/HandSource.h"

#include "device/DeviceUri.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/extending/HandSourceRegistry.h"
#include "plugin/extending/RegisteredNames.h"
#include "plugin/hands/HandConversion.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/RecordedUri.h"

#include <osgMidair/HandSource>

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Adapts a hand source of the bridge.
template<typename Source>
class BridgedHands : public HandSource
{
public:
    template<typename... Args>
    explicit BridgedHands(Args&&... args) : _source(std::forward<Args>(args)...)
    {
    }

    bool getHands(double time, std::vector<Hand>& hands) override
    {
        if (!_begun) _origin = time;
        _begun = true;
        const bool any = _source.frameAt(time - _origin, _frame);
        hands.clear();
        for (const midair::bridge::Hand& hand : _frame.hands)
            hands.push_back(fromBridge(hand));
        return any;
    }

    std::string getStatus() const override { return _source.status(); }

protected:
    Source _source;

private:
    midair::bridge::HandFrame _frame;
    bool _begun = false;
    double _origin = 0.0; ///< scene time of the first call, s
};

using RecordedHands = BridgedHands<midair::bridge::RecordedHandSource>;

class OpenXrHands : public BridgedHands<midair::bridge::OpenXrHandSource>
{
public:
    using BridgedHands::BridgedHands;

    bool setHorizon(double ahead) override { return _source.setHorizon(ahead); }
    std::vector<std::string> takeMessages() override { return _source.takeMessages(); }
};

osg::ref_ptr<HandSource> openOpenXr(const std::string& text)
{
    using midair::bridge::OpenXrSpace;
    midair::device::DeviceUri uri(text, "hand source");
    uri.rejectPath();
    midair::bridge::OpenXrOptions options;
    options.loader = uri.takeText("loader", options.loader);
    const std::string space = uri.takeText("space", "");
    if (!space.empty() && space != "stage" && space != "local")
        throw uri.error("space=" + space + " should be stage or local");
    if (!space.empty()) options.space = space == "stage" ? OpenXrSpace::STAGE : OpenXrSpace::LOCAL;
    Eigen::Isometry3d placement = midair::bridge::OpenXrHandSource::upright();
    const std::string matrix = uri.takeText("matrix", "");
    osg::Matrixd given;
    midair::bridge::PoseAndStretch parts;
    if (!matrix.empty())
    {
        if (!parseMatrix(matrix, given) ||
            !midair::bridge::decompose(midair::bridge::toEigen(given), parts) ||
            !parts.stretch.isIdentity(0.02))
            throw uri.error(
                "matrix=" + matrix +
                " should be 16 numbers of a rigid matrix, row by row, translation last");
        placement = parts.pose;
    }
    uri.rejectUnknown();
    return new OpenXrHands(options, placement);
}

/// Returns what stands before the colon of \a uri; empty if there is none.
std::string schemeOf(const std::string& uri)
{
    const std::size_t colon = uri.find(':');
    return colon == std::string::npos ? "" : uri.substr(0, colon);
}

/// Opens a source that the application registered. It is the application's code: what it throws is
/// an error.
osg::ref_ptr<HandSource>
openOwn(const HandSourceFactory& make, const std::string& uri, std::string& error)
{
    osg::ref_ptr<HandSource> source;
    std::string why;
    const std::string thrown =
        midair::base::thrownBy([&] { source = make(uri.substr(uri.find(':') + 1), why); });
    if (thrown.empty() && source) return source;
    if (!thrown.empty()) why = "what makes it has thrown " + thrown;
    error = "hand source \"" + uri + "\": " + (why.empty() ? "it could not be made" : why);
    return nullptr;
}

} // namespace

void InjectedHands::setHands(const std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _hands = hands;
    _set_s = midair::base::steadySeconds();
    ++_set;
}

bool InjectedHands::getHands(double /*time*/, std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    hands = _hands;
    for (Hand& hand : hands)
        hand.age += midair::base::steadySeconds() - _set_s;
    return !hands.empty();
}

std::string InjectedHands::getStatus() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return fmt::format("hands set by the application, {} times so far", _set);
}

osg::ref_ptr<HandSource> openHandSource(const std::string& uri, std::string& error)
{
    const std::string openXr = "openxr:";
    if (uri.empty() || uri == "none") return nullptr;
    try
    {
        if (const auto recorded = RecordedUri::parse(uri))
            return new RecordedHands(recorded->file, recorded->loops);
        if (uri.compare(0, openXr.size(), openXr) == 0) return openOpenXr(uri);
        if (uri == "mouse" || uri == "mouse:") return new MouseSource;
        if (const HandSourceFactory own = HandSourceRegistry::find(schemeOf(uri)))
            return openOwn(own, uri, error);
        const std::string names = registeredNames("hands");
        error =
            "hand source \"" + uri + "\" is not known; recorded:FILE, recorded:FILE?loop" +
            (names.empty() ? ", mouse: and openxr: are" : ", mouse:, openxr:, " + names + " are");
    }
    catch (const std::runtime_error& wrong) // InputError from recordings, DeviceError from URIs
    {
        error = wrong.what();
    }
    return nullptr;
}

Hand openHand(int id, const osg::Vec3d& tip, const osg::Quat& orientation)
{
    return fromBridge(midair::bridge::openHandWithIndexTipAt(
        id,
        Eigen::Vector3d(tip.x(), tip.y(), tip.z()),
        Eigen::Quaterniond(orientation.w(), orientation.x(), orientation.y(), orientation.z())));
}

} // namespace osgMidair
