#pragma once

#include <osg/MatrixTransform>
#include <osg/Vec4>

#include <string>

namespace midair::samples
{

/// Behind all that is shown.
inline const osg::Vec4 kShownBackground(0.052F, 0.060F, 0.078F, 1.0F);

/// Model read by any OSG plugin, scaled to a size and centred, with materials that show its shape.
struct ShownObject
{
    std::string name;              ///< file name without folders
    osg::ref_ptr<osg::Node> model; ///< metres; the centre of its bounding box is at the origin
    osg::ref_ptr<osg::Node> edges; ///< outline and creases, drawn over the field; not felt
    osg::Vec3d extent_m;
    bool flat = false; ///< drawn transparent, because the field's slice is in its plane
};

/// Reads \a path and scales it to a largest extent of \a size_m (0: unchanged). \a isOpaque: what
/// is flat is drawn as all else. Throws std::runtime_error that names the file.
ShownObject loadShownObject(const std::string& path, double size_m, bool isOpaque = false);

/// Returns a group with two lights (key and fill) and \a scene below it.
osg::ref_ptr<osg::Group> lit(osg::Node* scene);

} // namespace midair::samples
