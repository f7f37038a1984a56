#pragma once

#include <osg/Node>

#include <string>

namespace midair::bridge
{

/// Returns a phrase about effects of \a node on drawn vertices that haptics ignores ("has a shader
/// that ..; its children are felt as they are stored"); empty: none known. Not for every frame.
std::string notFeltOf(const osg::Node& node);

} // namespace midair::bridge
