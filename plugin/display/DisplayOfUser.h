#pragma once

namespace osgGA
{
class GUIActionAdapter;
}

namespace osgMidair
{

/// Shows the viewer behind \a adapter on the display in OSG_MIDAIR_DISPLAY, if it is set. Errors go
/// to osg::notify(). Call it once per viewer.
void showOnDisplayOfUser(osgGA::GUIActionAdapter* adapter);

} // namespace osgMidair
