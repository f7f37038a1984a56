#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/scene/Convert.h"

#include <osgMidair/HandSource>

#include <osg/ref_ptr>

#include <memory>
#include <string>
#include <vector>

namespace osgMidair
{

static_assert(Hand::kJoints == midair::bridge::HAND_JOINTS, "one order of joints for both");

inline Hand fromBridge(const midair::bridge::Hand& hand)
{
    Hand result;
    result.id = hand.id;
    result.age = hand.age_s;
    for (std::size_t i = 0; i < Hand::kJoints; ++i)
    {
        const midair::bridge::HandJoint& joint = hand.joints[i];
        result.joints[i] = {midair::bridge::toOsg(joint.position),
                            midair::bridge::toOsg(joint.orientation),
                            joint.radius_m,
                            joint.positionValid,
                            joint.orientationValid};
    }
    return result;
}

inline midair::bridge::Hand toBridge(const Hand& hand)
{
    midair::bridge::Hand result;
    result.id = hand.id;
    result.age_s = hand.age;
    for (std::size_t i = 0; i < Hand::kJoints; ++i)
    {
        const HandJoint& joint = hand.joints[i];
        result.joints[i] = {midair::bridge::toEigen(joint.position),
                            midair::bridge::toEigen(joint.orientation),
                            joint.radius,
                            joint.positionValid,
                            joint.orientationValid};
    }
    return result;
}

/// Adapts a hand source of a kit's application for trackers.
class KitHands : public midair::bridge::HandSource
{
public:
    explicit KitHands(osgMidair::HandSource* source) : _source(source) {}

    /// Returns the source of \a hands; null: it is no KitHands.
    static osgMidair::HandSource* of(const midair::bridge::HandSource* hands)
    {
        const auto* kit = dynamic_cast<const KitHands*>(hands);
        return kit ? kit->_source.get() : nullptr;
    }

    bool frameAt(double time_s, midair::bridge::HandFrame& frame) override;
    bool setHorizon(double ahead_s) override { return _source->setHorizon(ahead_s); }
    std::string status() const override { return _source->getStatus(); }
    std::vector<std::string> takeMessages() override { return _source->takeMessages(); }

private:
    osg::ref_ptr<osgMidair::HandSource> _source;
    std::vector<Hand> _hands;
};

/// Opens the source of a scene's setting `hands`; as midair::bridge::openHands(), and "mouse:".
std::shared_ptr<midair::bridge::HandSource> openSceneHands(const std::string& uri);

/// As midair::bridge::unknownHands() for the setting `hands`.
std::string unknownSceneHands(const std::string& uri);

} // namespace osgMidair
