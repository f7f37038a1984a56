#pragma once

#include <osg/Node>

#include <string>

namespace midair::bridge
{

/// What the graphics card makes of stored vertices because of \a node that isn't felt, as a phrase
/// for messages ("has a shader that ..; what is below it is felt as it is stored"); empty: nothing
/// that is known. Not for every frame.
std::string notFeltOf(const osg::Node& node);

} // namespace midair::bridge
