#pragma once

namespace osgGA
{
class GUIActionAdapter;
}

namespace osgMidair
{

/// Shows the viewer behind \a adapter on the display that OSG_MIDAIR_DISPLAY names, if it names
/// one. What is wrong with it is told by osg::notify(). To be called once for a viewer.
void showOnDisplayOfUser(osgGA::GUIActionAdapter* adapter);

} // namespace osgMidair
