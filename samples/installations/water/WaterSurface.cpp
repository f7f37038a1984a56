#include "samples/installations/water/WaterSurface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::samples
{

namespace
{

constexpr double kHalfWidth_m = 0.5 * (WaterSurface::kColumns - 1) * WaterSurface::kStep_m;
constexpr double kHalfDepth_m = 0.5 * (WaterSurface::kRows - 1) * WaterSurface::kStep_m;
constexpr double kDent_m = 0.007;   ///< radius of what a finger presses down
constexpr double kLongest_s = 0.25; ///< that is made up for at once

} // namespace

WaterSurface::WaterSurface() :
    _heights(static_cast<std::size_t>(kColumns * kRows), 0.0),
    _before(_heights),
    _next(_heights),
    _geometry(new osg::Geometry),
    _vertices(new osg::Vec3Array),
    _normals(new osg::Vec3Array(static_cast<unsigned int>(kColumns * kRows)))
{
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column)
            _vertices->push_back(osg::Vec3(static_cast<float>(column * kStep_m - kHalfWidth_m),
                                           static_cast<float>(row * kStep_m - kHalfDepth_m),
                                           0.0F));
    osg::ref_ptr<osg::DrawElementsUInt> triangles = new osg::DrawElementsUInt(GL_TRIANGLES);
    for (int row = 0; row + 1 < kRows; ++row)
        for (int column = 0; column + 1 < kColumns; ++column)
            for (const auto& [i, j] :
                 {std::pair<int, int>{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                triangles->push_back(static_cast<unsigned int>(at(column + i, row + j)));
    _geometry->setDataVariance(osg::Object::DYNAMIC);
    _geometry->setUseVertexBufferObjects(true);
    _geometry->setVertexArray(_vertices);
    _geometry->setNormalArray(_normals, osg::Array::BIND_PER_VERTEX);
    _geometry->addPrimitiveSet(triangles);
    show();
}

// Leapfrog; stable as c * dt / dx = 0.14 is below 1/sqrt(2). The rim stays at rest.
void WaterSurface::step()
{
    constexpr double kCourant = kSpeed_m_s * kTimeStep_s / kStep_m;
    static_assert(kCourant < 0.7, "the waves would grow without end");
    constexpr double kLoss = kDamping_Hz * kTimeStep_s;
    for (int row = 1; row + 1 < kRows; ++row)
        for (int column = 1; column + 1 < kColumns; ++column)
        {
            const double here = _heights[at(column, row)];
            const double curve = _heights[at(column - 1, row)] + _heights[at(column + 1, row)] +
                                 _heights[at(column, row - 1)] + _heights[at(column, row + 1)] -
                                 4.0 * here;
            const double next = here + (1.0 - kLoss) * (here - _before[at(column, row)]) +
                                kCourant * kCourant * curve;
            _next[at(column, row)] = std::clamp(next, -kMost_m, kMost_m);
        }
    std::swap(_before, _heights);
    std::swap(_heights, _next);
}

void WaterSurface::advance(double time_s)
{
    _time_s = std::max(_time_s, time_s - kLongest_s);
    for (; _time_s + kTimeStep_s <= time_s; _time_s += kTimeStep_s)
        step();
    show();
}

void WaterSurface::press(double x, double y, double height_m)
{
    for (int row = 1; row + 1 < kRows; ++row)
        for (int column = 1; column + 1 < kColumns; ++column)
        {
            const double dx = column * kStep_m - kHalfWidth_m - x;
            const double dy = row * kStep_m - kHalfDepth_m - y;
            const double share = (dx * dx + dy * dy) / (kDent_m * kDent_m);
            if (share > 1.0) continue;
            // The underside of a fingertip: deepest in its middle.
            const double most =
                std::clamp(height_m + kDent_m * (1.0 - std::sqrt(1.0 - share)), -kMost_m, kMost_m);
            double& here = _heights[at(column, row)];
            here = std::min(here, most);
        }
}

void WaterSurface::drop(double x, double y, double depth_m)
{
    press(x, y, -depth_m);
}

double WaterSurface::heightOf(const std::vector<double>& heights, double x, double y)
{
    const double u = std::clamp((x + kHalfWidth_m) / kStep_m, 0.0, kColumns - 1.000001);
    const double v = std::clamp((y + kHalfDepth_m) / kStep_m, 0.0, kRows - 1.000001);
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const double a = u - column;
    const double b = v - row;
    const double low = heights[at(column, row)];
    const double high = heights[at(column + 1, row + 1)];
    if (a >= b)
    {
        const double right = heights[at(column + 1, row)];
        return low + a * (right - low) + b * (high - right);
    }
    const double up = heights[at(column, row + 1)];
    return low + b * (up - low) + a * (high - up);
}

double WaterSurface::swell() const
{
    double most = 0.0;
    for (const double height : _heights)
        most = std::max(most, std::abs(height));
    return most;
}

void WaterSurface::show()
{
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column)
        {
            const std::size_t here = at(column, row);
            (*_vertices)[here].z() = static_cast<float>(_heights[here]);
            const auto height = [&](int i, int j)
            {
                return _heights[at(std::clamp(column + i, 0, kColumns - 1),
                                   std::clamp(row + j, 0, kRows - 1))];
            };
            osg::Vec3 normal(static_cast<float>(height(-1, 0) - height(1, 0)),
                             static_cast<float>(height(0, -1) - height(0, 1)),
                             static_cast<float>(2.0 * kStep_m));
            normal.normalize();
            (*_normals)[here] = normal;
        }
    _vertices->dirty();
    _normals->dirty();
    _geometry->dirtyBound();
}

} // namespace midair::samples
