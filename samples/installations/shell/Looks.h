#pragma once

#include <osg/Node>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osg/Vec3d>
#include <osg/Vec4>

#include <array>

namespace midair::samples
{

/// Colours that stay apart for people who see red and green alike, too (Okabe, Ito 2008).
inline const std::array<osg::Vec4, 6> kShownColors = {osg::Vec4(0.34F, 0.71F, 0.91F, 1.0F),
                                                      osg::Vec4(0.90F, 0.62F, 0.00F, 1.0F),
                                                      osg::Vec4(0.00F, 0.62F, 0.45F, 1.0F),
                                                      osg::Vec4(0.84F, 0.37F, 0.00F, 1.0F),
                                                      osg::Vec4(0.80F, 0.47F, 0.65F, 1.0F),
                                                      osg::Vec4(0.94F, 0.89F, 0.26F, 1.0F)};

/// Gives \a node a matt surface of that colour, with a little gloss.
void paint(osg::Node& node, const osg::Vec4& color);

/// Returns \a shape, painted. \a detail: of its curves; 1 is OSG's own.
osg::ref_ptr<osg::ShapeDrawable>
solid(osg::Shape* shape, const osg::Vec4& color, float detail = 0.8F);

/// Returns a box that is only seen: a translucent floor and the edges. It is centred at \a centre.
osg::ref_ptr<osg::Node> glassBox(const osg::Vec3d& centre, const osg::Vec3d& size);

} // namespace midair::samples
