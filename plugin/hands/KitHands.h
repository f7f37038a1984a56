#pragma once

#include "engine-bridge/hands/HandSource.h"

#include <osgMidair/HandSource>

#include <osg/ref_ptr>

#include <memory>
#include <string>
#include <vector>

namespace osgMidair
{

/// A hand source of an application of the kit's, as trackers take it.
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

/// Opens what a scene's setting `hands` names; as midair::bridge::openHands(), and "mouse:".
std::shared_ptr<midair::bridge::HandSource> openSceneHands(const std::string& uri);

/// As midair::bridge::unknownHands() for the setting `hands`.
std::string unknownSceneHands(const std::string& uri);

} // namespace osgMidair
