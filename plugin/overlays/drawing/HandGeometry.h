#pragma once

#include "engine-bridge/hands/Hand.h"
#include "plugin/overlays/drawing/HandSkin.h"

#include <osg/Geometry>

#include <bitset>
#include <vector>

namespace osgMidair
{

/// Bones of a hand that touch an object.
using TouchingBones = std::bitset<midair::bridge::kHandBones>;

/// Uniform (float) of a camera or a node: 1: hands below are black and clear (alpha 0) but still
/// hide what is behind them.
constexpr const char* kHandsHide = "osgMidairHides";

/// Makes the geometry of \a state opaque and drawn first.
void drawHands(osg::StateSet& state);

/// A hand, lit by lights 0 and 1 of the scene. It is opaque, and drawn first.
class HandGeometry
{
public:
    /// \a isLeft: it is a left hand.
    explicit HandGeometry(bool isLeft);

    osg::Geometry& geometry() { return *_geometry; }
    bool isLeft() const { return _isLeft; }

    /// Shows \a hand of \a capsules; \a touching is orange. Returns false, and shows nothing, if it
    /// has no skin.
    bool show(const std::vector<midair::bridge::HandCapsule>& capsules,
              int hand,
              const TouchingBones& touching);
    void hide() { _geometry->setNodeMask(0); }

private:
    void paint(const TouchingBones& touching);

    const bool _isLeft;
    osg::ref_ptr<osg::Geometry> _geometry;
    TouchingBones _painted;
    HandSkin _skin;
};

} // namespace osgMidair
