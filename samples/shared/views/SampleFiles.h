#pragma once

#include <osgText/Font>

#include <string>

namespace midair::samples
{

/// Returns the path of \a name ("models/star.obj") below the samples' folder: that of the installed
/// samples where the program is installed, else that of the sources.
std::string sampleFile(const std::string& name);

/// Returns the font of pictures and signs: DejaVu Sans (Debian: fonts-dejavu-core), else OSG's own.
osg::ref_ptr<osgText::Font> labelFont();

/// From now on this program opens `sim:?board=autd3` as well: AUTD3 units that are emulated in it.
void registerEmulatedDevices();

} // namespace midair::samples
