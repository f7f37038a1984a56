#include "plugin/overlays/OverlayPart.h"

#include <osgMidair/Overlay>

namespace osgMidair
{

OverlayPart::~OverlayPart() = default;

OverlayPart& OverlayPart::of(Overlay& overlay)
{
    return *overlay._overlayPart;
}

void OverlayPart::setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& /*array*/,
                           const midair::haptics::Medium& /*medium*/)
{
}

void OverlayPart::setResult(const std::shared_ptr<const midair::bridge::HologramResult>& /*result*/)
{
}

void OverlayPart::setHands(const std::vector<midair::bridge::HandCapsule>& /*capsules*/,
                           const std::vector<midair::bridge::HandContact>& /*contacts*/,
                           double /*time_s*/)
{
}

Overlay::Overlay(std::unique_ptr<OverlayPart> part) : _overlayPart(std::move(part))
{
    setDataVariance(DYNAMIC);
}

Overlay::~Overlay() = default;

void Overlay::setShown(bool shown)
{
    setNodeMask(shown ? ~0U : 0U);
    dirtyBound();
}

// OSG's groups take the bounds of hidden children, too.
osg::BoundingSphere Overlay::computeBound() const
{
    return isShown() ? osg::Group::computeBound() : osg::BoundingSphere();
}

} // namespace osgMidair
