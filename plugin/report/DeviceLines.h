#pragma once

namespace osgMidair
{

/// From now on the lines that devices log come to tellDeviceLines() and not to the standard output.
/// To be called before a device is opened; only the first call does something. Any thread.
void collectDeviceLines();

/// Passes what devices have logged since the last call on to osg::notify(). Devices log from their
/// own threads, and osg::notify() is for one: to be called by the update thread.
void tellDeviceLines();

} // namespace osgMidair
