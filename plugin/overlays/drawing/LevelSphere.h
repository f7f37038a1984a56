#pragma once

#include <osg/Vec3>

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace osgMidair
{

/// A sphere around the y axis with a level at its corners, as a map: a finer grid between them, and
/// lines of equal level. Corners are numbered ring by ring from pole to pole; the last of each ring
/// repeats its first. Levels of 0 or below are omitted.
class LevelSphere
{
public:
    static constexpr int kRings = 13; ///< of corners, poles included
    static constexpr int kAround = 24;
    static constexpr int kFiner = 4; ///< grid cells from a corner to the next

    /// A grid of rows() x columns() places.
    struct Grid
    {
        std::vector<osg::Vec3> places;   ///< row by row
        std::vector<float> levels_dB;    ///< 0: omitted
        std::vector<unsigned int> faces; ///< three indices each; without omitted ones
        static constexpr int rows() { return (kRings - 1) * kFiner + 1; }
        static constexpr int columns() { return kAround * kFiner + 1; }
    };
    /// A line of equal level in pieces.
    struct Contour
    {
        float level_dB = 0.0F;
        std::vector<std::pair<osg::Vec3, osg::Vec3>> pieces;
        std::vector<osg::Vec3> labels; ///< label positions, all around
    };

    /// Returns the corners, 3 x (kRings (kAround + 1)), on a sphere of \a radius_m.
    static Eigen::Matrix3Xd corners(double radius_m);
    /// Returns the grid between the corners with interpolated levels, where all four surrounding
    /// corners have one.
    static Grid gridOf(const Eigen::VectorXf& levels_dB, double radius_m);
    /// Returns the lines at multiples of \a step_dB (> 0), from the lowest to the highest.
    static std::vector<Contour> contoursOf(const Grid& grid, float step_dB);
};

} // namespace osgMidair
