#pragma once

#include <osgMidair/HandSource>

#include <osg/ref_ptr>

#include <string>

namespace osgMidair
{

/// \{ The hands that an OpenXR runtime tracks ("openxr:?..", in this process or in a helper), and
/// those that come by OSC ("osc:?.."). Throw midair::device::DeviceError or
/// midair::base::InputError if \a uri is not understood.
osg::ref_ptr<HandSource> openOpenXr(const std::string& uri);
osg::ref_ptr<HandSource> openOsc(const std::string& uri);
/// \}

} // namespace osgMidair
