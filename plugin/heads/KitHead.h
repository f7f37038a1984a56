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
    const Eigen::Quaterniond q(head.pose.linear());
    return {midair::bridge::toOsg(Eigen::Vector3d(head.pose.translation())),
            osg::Quat(q.x(), q.y(), q.z(), q.w()),
            head.age_s};
}

/// A head source of an application of the kit's, as trackers take it.
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

/// Opens what a scene's setting `heads` names; as midair::bridge::openHead(), and "mouse:".
std::shared_ptr<midair::bridge::HeadSource> openSceneHead(const std::string& text);

/// As midair::bridge::unknownHead() for the setting `heads`.
std::string unknownSceneHead(const std::string& text);

} // namespace osgMidair
