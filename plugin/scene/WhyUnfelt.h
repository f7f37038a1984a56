#pragma once

#include <osg/Node>

#include <string>

namespace osgMidair
{

/// Why a marked node has no mesh.
struct WhyUnfelt
{
    std::string text;      ///< goes on after the node's path; empty: it was said already
    bool isHidden = false; ///< something below it is hidden, and is felt once it is shown
};

/// Looks at all below \a root, hidden or not, for what would be its mesh, and says why there is
/// none. For a node without a mesh, not for every frame. \a isTold: what of it can't be felt was
/// said when its mesh was read.
WhyUnfelt whyUnfelt(osg::Node& root, bool isTold);

} // namespace osgMidair
