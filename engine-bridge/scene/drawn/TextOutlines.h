#pragma once

#include <osg/Drawable>
#include <osg/Vec3d>
#include <osgText/TextBase>

#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Returns \a drawable as a text; null if it is none.
const osgText::TextBase* textOf(const osg::Drawable& drawable);

/// Returns true for a text that turns or scales with the camera on screen.
bool followsScreen(const osgText::TextBase& text);

/// Lines between places.
struct TextOutlines
{
    std::vector<osg::Vec3d> places;
    std::vector<std::pair<int, int>> lines; ///< indices of places
    std::string problem;                    ///< problem of a part; empty: none
};

/// Returns the outlines of the characters of \a text as drawn, in the drawable's coordinates. For
/// the thread that may read nodes.
TextOutlines textOutlines(const osgText::TextBase& text);

} // namespace midair::bridge
