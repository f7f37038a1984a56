#pragma once

#include "engine-bridge/heads/HeadSource.h"
#include "engine-bridge/scene/Convert.h"

#include <osgMidair/HeadSource>

#include <osg/ref_ptr>

#include <memory>
#include <string>
#include <vector>

namespace osgMidair
{

inline Head fromBridge(const midair::bridge::Head& head)
{
    return {midair::bridge::toOsg(Eigen::Vector3d(head.pose.translation())),
            midair::bridge::toOsg(Eigen::Quaterniond(head.pose.linear())),
            head.age_s};
}

/// Converts \a head, which is tracked, at \a time_s.
inline midair::bridge::Head toBridge(const Head& head, double time_s)
{
    return {time_s,
            midair::bridge::headPose(midair::bridge::toEigen(head.position),
                                     midair::bridge::toEigen(head.orientation)),
            true,
            head.age};
}

/// Adapts a head source of a kit's application for trackers.
class KitHead : public midair::bridge::HeadSource
{
public:
    explicit KitHead(osgMidair::HeadSource* source) : _source(source) {}

    /// Returns the source of \a head; null: it is no KitHead.
    static osgMidair::HeadSource* of(const midair::bridge::HeadSource* head)
    {
        const auto* kit = dynamic_cast<const KitHead*>(head);
        return kit ? kit->_source.get() : nullptr;
    }

    bool headAt(double time_s, midair::bridge::Head& head) override;
    bool setHorizon(double ahead_s) override { return _source->setHorizon(ahead_s); }
    std::string status() const override { return _source->getStatus(); }
    std::vector<std::string> takeMessages() override { return _source->takeMessages(); }

private:
    osg::ref_ptr<osgMidair::HeadSource> _source;
};

/// Opens the source of a scene's setting `heads`; as midair::bridge::openHead(), and "mouse:".
std::shared_ptr<midair::bridge::HeadSource> openSceneHead(const std::string& text);

/// As midair::bridge::unknownHead() for the setting `heads`.
std::string unknownSceneHead(const std::string& text);

} // namespace osgMidair
