#include <osgMidair/Overlay>

namespace osgMidair
{

Overlay::Overlay()
{
    setDataVariance(DYNAMIC);
}

Overlay::Overlay(const Overlay& other, const osg::CopyOp& copyop) : osg::Group(other, copyop) {}

Overlay::~Overlay() = default;

void Overlay::setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& /*array*/,
                       const midair::haptics::Medium& /*medium*/)
{
}

void Overlay::setResult(const std::shared_ptr<const midair::bridge::HologramResult>& /*result*/) {}

void Overlay::setShown(bool shown)
{
    setNodeMask(shown ? ~0U : 0U);
}

} // namespace osgMidair
