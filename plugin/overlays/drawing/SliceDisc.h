#pragma once

#include <osg/Geometry>
#include <osg/Image>
#include <osg/Texture2D>

namespace osgMidair
{

/// Makes a texture of \a image, which changes.
osg::ref_ptr<osg::Texture2D> makeSliceTexture(osg::Image* image);

/// Makes \a disc a square of four vertices with \a texture, whose shape is in the texture. The
/// caller sets the vertices.
void setUpSliceDisc(osg::Geometry& disc, osg::Texture2D* texture);

} // namespace osgMidair
