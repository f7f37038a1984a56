#pragma once

#include <osg/MatrixTransform>

#include <string>

namespace midair::samples
{

/// A model that any OSG plugin reads, brought to a size, in its own middle, and lit so that its
/// shape shows.
struct DemoObject
{
    std::string name;              ///< file name without folders
    osg::ref_ptr<osg::Node> model; ///< metres; centred on its bounding box's middle
    osg::ref_ptr<osg::Node> edges; ///< outline and creases, drawn over the field; not to be felt
    osg::Vec3d extent_m;
    bool flat = false; ///< drawn see-through, because the field's slice lies in it
};

/// Reads \a path and scales it to the largest extent \a size_m (0: as it is). Throws
/// std::runtime_error that names the file.
DemoObject loadDemoObject(const std::string& path, double size_m);

/// Two lights (key and fill) as children of the group that is returned, for \a scene below it.
osg::ref_ptr<osg::Group> lit(osg::Node* scene);

} // namespace midair::samples
