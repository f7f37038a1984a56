#pragma once

#include <osgText/Font>

namespace midair::samples
{

/// Returns the font of pictures and signs: DejaVu Sans (Debian: fonts-dejavu-core), else OSG's own.
osg::ref_ptr<osgText::Font> labelFont();

} // namespace midair::samples
