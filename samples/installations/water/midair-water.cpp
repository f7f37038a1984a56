/// A sheet of water that a hand makes waves in and feels as it moves.
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"

#include <osgMidair/HapticSurface>

#include <osg/Geometry>
#include <osg/Material>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <random>
#include <utility>
#include <vector>

namespace
{

using namespace midair::samples;
using namespace midair;

/// A sheet of water over a rectangle around the z axis: heights on a grid that follow the wave
/// equation with damping, h'' = c^2 (h_xx + h_yy) - d h', in steps of equal length, so that a run
/// doesn't depend on the frame rate.
class WaterSurface
{
public:
    static constexpr int kColumns = 49;
    static constexpr int kRows = 33;
    static constexpr double kStep_m = 0.003;   ///< of the grid
    static constexpr double kSpeed_m_s = 0.10; ///< of the waves
    static constexpr double kDamping_Hz = 0.9;
    static constexpr double kMost_m = 0.012; ///< limit of heights
    static constexpr double kHalfWidth_m = 0.5 * (kColumns - 1) * kStep_m;
    static constexpr double kHalfDepth_m = 0.5 * (kRows - 1) * kStep_m;
    static constexpr double kDent_m = 0.007;   ///< radius of a finger's dent
    static constexpr double kLongest_s = 0.25; ///< longest step that is caught up

    WaterSurface() :
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

    osg::Geometry* geometry() const { return _geometry; }

    /// Advances to \a time_s, by at most a quarter of a second.
    void advance(double time_s)
    {
        _time_s = std::max(_time_s, time_s - kLongest_s);
        for (; _time_s + kTimeStep_s <= time_s; _time_s += kTimeStep_s)
            step();
        show();
    }

    /// Presses the water around (\a x, \a y) down to at most \a height_m.
    void press(double x, double y, double height_m)
    {
        for (int row = 1; row + 1 < kRows; ++row)
            for (int column = 1; column + 1 < kColumns; ++column)
            {
                const double dx = column * kStep_m - kHalfWidth_m - x;
                const double dy = row * kStep_m - kHalfDepth_m - y;
                const double share = (dx * dx + dy * dy) / (kDent_m * kDent_m);
                if (share > 1.0) continue;
                // Underside of a fingertip: deepest in the middle.
                const double most = std::clamp(
                    height_m + kDent_m * (1.0 - std::sqrt(1.0 - share)), -kMost_m, kMost_m);
                double& here = _heights[at(column, row)];
                here = std::min(here, most);
            }
    }

    /// Adds a drop at (\a x, \a y).
    void drop(double x, double y, double depth_m) { press(x, y, -depth_m); }

    /// Returns the heights on the grid, row by row.
    const std::vector<double>& heights() const { return _heights; }
    /// Returns the height at (\a x, \a y), m, of such heights, interpolated over the triangles.
    static double heightOf(const std::vector<double>& heights, double x, double y)
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

    /// Returns the surface's largest distance from rest, m.
    double swell() const
    {
        double most = 0.0;
        for (const double height : _heights)
            most = std::max(most, std::abs(height));
        return most;
    }

private:
    static constexpr double kTimeStep_s = 1.0 / 240.0;

    static std::size_t at(int column, int row)
    {
        return static_cast<std::size_t>(row * kColumns + column);
    }
    // Leapfrog; stable because c * dt / dx = 0.14 is below 1/sqrt(2). The rim stays at rest.
    void step()
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

    void show()
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

    std::vector<double> _heights;
    std::vector<double> _before;
    std::vector<double> _next;
    double _time_s = 0.0;
    osg::ref_ptr<osg::Geometry> _geometry;
    osg::ref_ptr<osg::Vec3Array> _vertices;
    osg::ref_ptr<osg::Vec3Array> _normals;
};

class Water : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"water",
                "A sheet of water: a hand makes waves and feels them.",
                "Dip a finger into the water"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--rain", _rain_s, "Interval between raindrops, s; 0: never")
            ->check(CLI::Range(0.0, 3600.0))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
    }

    void build(Stage& stage) override
    {
        _lot.seed(stage.seed);
        _haptics = &stage.haptics;
        osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface;
        surface->setName("water");
        surface->setTouchEvents(true);
        surface->setMaterial("skin");
        surface->setSpacing(0.012);
        surface->addChild(_water.geometry());
        paint(*surface, {0.16F, 0.48F, 0.72F, 1.0F});
        auto* material = dynamic_cast<osg::Material*>(
            surface->getStateSet()->getAttribute(osg::StateAttribute::MATERIAL));
        if (material)
        {
            material->setSpecular(osg::Material::FRONT_AND_BACK, {0.9F, 0.95F, 1.0F, 1.0F});
            material->setShininess(osg::Material::FRONT_AND_BACK, 90.0F);
        }
        stage.haptics.addChild(surface);
        stage.lit.addChild(glassBox({0.0, 0.0, -0.008}, {0.144, 0.096, 0.016}));
    }

    Viewpoint viewpoint() const override
    {
        return {{0.44, -0.28, 0.34}, {0.0, -0.008, 0.004}, osg::Z_AXIS, 14.0};
    }

    // A finger that dips in, draws a loop and leaves.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 7.0;
        constexpr double kInside_s = 5.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > kInside_s) return false;
        const double in = std::min(eased(t, 0.2, 0.6), 1.0 - eased(t, kInside_s - 0.6, kInside_s));
        const double angle = 2.0 * osg::PI * t / 3.0;
        hands.push_back(pointingHand(
            {0.035 * std::sin(angle), 0.018 * std::sin(2.0 * angle), 0.045 - 0.042 * in}, 0.5));
        return true;
    }

    void update(const Moment& now) override
    {
        for (const auto& [x, y, height] : _fingers)
            _water.press(x, y, height);
        _fingers.clear();
        if (_rain_s > 0.0 && now.time_s >= _nextDrop_s)
        {
            std::uniform_real_distribution<double> aside(-1.0, 1.0);
            const double x = 0.055 * aside(_lot);
            _water.drop(x, 0.035 * aside(_lot), 0.006);
            _nextDrop_s = now.time_s + _rain_s;
            ++_drops;
        }
        compare();
        _water.advance(now.time_s);
        _swell_m = std::max(_swell_m, _water.swell());
        _waves.emplace_back(now.time_s, _water.heights());
        if (_waves.size() > kKept) _waves.pop_front();
    }

    void touched(const osgMidair::Touch& touch) override
    {
        ++_dips;
        stroked(touch);
    }
    // Distance of the skin's lowest point below the surface at a touch.
    void stroked(const osgMidair::Touch& touch) override
    {
        if (touch.depth <= 0.0) return;
        _fingers.push_back(
            {touch.position.x(), touch.position.y(), touch.position.z() - kYield * touch.depth});
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        figures["dips"] = _dips;
        figures["drops"] = _drops;
        figures["swell_mm"] = 1e3 * _swell_m;
        figures["fieldsCompared"] = _compared;
        figures["pointsCompared"] = _points;
        figures["pointsOffSurface_mm"] = 1e3 * _off_m;
        figures["pointsOffRest_mm"] = 1e3 * _offRest_m;
    }

private:
    /// Share of a finger's depth by which the water gives way; the rest is felt.
    static constexpr double kYield = 0.4;
    static constexpr std::size_t kKept = 40; ///< frames whose waves are stored

    /// Compares control points of the newest field with the water of its frame.
    void compare()
    {
        const osg::ref_ptr<const osgMidair::HapticField> field = _haptics->getField();
        if (!field || field == _seen) return;
        _seen = field;
        const auto frame = std::find_if(_waves.begin(),
                                        _waves.end(),
                                        [&](const auto& wave)
                                        { return wave.first == field->getSimulationTime(); });
        if (frame == _waves.end() || field->getNumFields() != 1) return;
        ++_compared;
        for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
        {
            ++_points;
            const double height =
                WaterSurface::heightOf(frame->second, point.position.x(), point.position.y());
            _off_m = std::max(_off_m, std::abs(point.position.z() - height));
            _offRest_m = std::max(_offRest_m, std::abs(point.position.z()));
        }
    }

    struct Finger
    {
        double x;
        double y;
        double height;
    };

    double _rain_s = 1.5;
    double _nextDrop_s = 0.3;
    double _swell_m = 0.0;
    double _off_m = 0.0;
    double _offRest_m = 0.0;
    std::uint64_t _dips = 0;
    std::uint64_t _drops = 0;
    std::uint64_t _compared = 0;
    std::uint64_t _points = 0;
    std::mt19937 _lot;
    WaterSurface _water;
    std::vector<Finger> _fingers;
    std::deque<std::pair<double, std::vector<double>>> _waves; ///< by time of the frame
    osgMidair::HapticScene* _haptics = nullptr;
    osg::ref_ptr<const osgMidair::HapticField> _seen;
};

} // namespace

int main(int argc, char** argv)
{
    Water water;
    return runInstallation(water, argc, argv);
}
