#pragma once

#include <osg/Geometry>

#include <vector>

namespace midair::samples
{

/// A sheet of water over a rectangle around the z axis: heights on a grid that follow the wave
/// equation with damping, h'' = c^2 (h_xx + h_yy) - d h', in steps of equal length, so that a run
/// repeats whatever the frame rate does.
class WaterSurface
{
public:
    static constexpr int kColumns = 49;
    static constexpr int kRows = 33;
    static constexpr double kStep_m = 0.003;   ///< of the grid
    static constexpr double kSpeed_m_s = 0.10; ///< of the waves
    static constexpr double kDamping_Hz = 0.9;
    static constexpr double kMost_m = 0.012; ///< heights stay within this

    WaterSurface();

    osg::Geometry* geometry() const { return _geometry; }

    /// Goes on to \a time_s, at most a quarter of a second at once.
    void advance(double time_s);
    /// Presses the water down around (\a x, \a y), to \a height_m at most where it is higher.
    void press(double x, double y, double height_m);
    /// A drop falls at (\a x, \a y).
    void drop(double x, double y, double depth_m);

    /// Returns the heights on the grid, row by row.
    const std::vector<double>& heights() const { return _heights; }
    /// Returns the height at (\a x, \a y), m, of such heights; between the grid's places as the
    /// triangles have it.
    static double heightOf(const std::vector<double>& heights, double x, double y);
    /// Returns the largest distance of the surface from rest, m.
    double swell() const;

private:
    static constexpr double kTimeStep_s = 1.0 / 240.0;

    static std::size_t at(int column, int row)
    {
        return static_cast<std::size_t>(row * kColumns + column);
    }
    void step();
    void show();

    std::vector<double> _heights;
    std::vector<double> _before;
    std::vector<double> _next;
    double _time_s = 0.0;
    osg::ref_ptr<osg::Geometry> _geometry;
    osg::ref_ptr<osg::Vec3Array> _vertices;
    osg::ref_ptr<osg::Vec3Array> _normals;
};

} // namespace midair::samples
