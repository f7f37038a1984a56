/// A sheet of water that a hand makes waves in, and that is felt as it moves.

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/VisitorHand.h"
#include "samples/installations/water/WaterSurface.h"

#include <osgMidair/HapticSurface>

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

class Water : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"water",
                "A sheet of water with waves, which a hand makes and feels.",
                "Dip a finger into the water"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--rain", _rain_s, "A drop falls every so often, s; 0: never")
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
    // The skin's lowest place is that far below the surface where they touch.
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
    /// Share of a finger's depth that the water gives way by: the rest is felt.
    static constexpr double kYield = 0.4;
    static constexpr std::size_t kKept = 40; ///< frames whose waves are known

    /// Control points of the newest field against the water of its frame.
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
    std::deque<std::pair<double, std::vector<double>>> _waves; ///< by the time of their frame
    osgMidair::HapticScene* _haptics = nullptr;
    osg::ref_ptr<const osgMidair::HapticField> _seen;
};

} // namespace

int main(int argc, char** argv)
{
    Water water;
    return runInstallation(water, argc, argv);
}
