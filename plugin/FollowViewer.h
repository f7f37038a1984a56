#pragma once

#include <osg/OperationThread>
#include <osg/observer_ptr>

#include <vector>

namespace osgGA
{
class GUIActionAdapter;
}

namespace osgMidair
{

class HapticScene;

/// Has \a scene collected after each update traversal of the viewer behind \a adapter, once a frame however many of its
/// views show it, and silent while none of them does. Null where there is no osgViewer, or one of \a known follows it already;
/// else the operation that was added to the viewer.
osg::ref_ptr<osg::Operation>
followViewerOf(osgGA::GUIActionAdapter* adapter,
               HapticScene& scene,
               const std::vector<osg::observer_ptr<osg::Operation>>& known);

} // namespace osgMidair
