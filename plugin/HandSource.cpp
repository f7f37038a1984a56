#include "engine-bridge/HandSource.h"

#include "HandConversion.h"
#include "haptics/InputError.h"

#include <osgMidair/HandSource>

namespace osgMidair
{

namespace
{

class RecordedHands : public HandSource
{
public:
    RecordedHands(const std::string& file, bool loop) : _source(file, loop) {}

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

private:
    midair::bridge::RecordedHandSource _source;
    midair::bridge::HandFrame _frame;
    bool _begun = false;
    double _origin = 0.0; ///< s, of the scene's clock
};

} // namespace

void InjectedHands::setHands(const std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _hands = hands;
    ++_set;
}

bool InjectedHands::getHands(double /*time*/, std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    hands = _hands;
    return !hands.empty();
}

std::string InjectedHands::getStatus() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return "hands set by the application, " + std::to_string(_set) + " times so far";
}

osg::ref_ptr<HandSource> openHandSource(const std::string& uri, std::string& error)
{
    const std::string recorded = "recorded:";
    const std::string loop = "?loop";
    if (uri.empty()) return nullptr;
    if (uri.compare(0, recorded.size(), recorded) != 0)
    {
        error =
            "hand source \"" + uri + "\" is not known; recorded:FILE and recorded:FILE?loop are";
        return nullptr;
    }
    std::string file = uri.substr(recorded.size());
    const bool loops = file.size() > loop.size() &&
                       file.compare(file.size() - loop.size(), loop.size(), loop) == 0;
    if (loops) file.resize(file.size() - loop.size());
    try
    {
        return new RecordedHands(file, loops);
    }
    catch (const midair::haptics::InputError& wrong)
    {
        error = wrong.what();
        return nullptr;
    }
}

Hand openHand(int id, const osg::Vec3d& tip, const osg::Quat& orientation)
{
    return fromBridge(midair::bridge::openHandWithIndexTipAt(
        id,
        Eigen::Vector3d(tip.x(), tip.y(), tip.z()),
        Eigen::Quaterniond(orientation.w(), orientation.x(), orientation.y(), orientation.z())));
}

} // namespace osgMidair
