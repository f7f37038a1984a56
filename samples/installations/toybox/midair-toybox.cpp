/// Toys that bounce in the array: one pushes them with the hand and feels them.

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/installations/toybox/Toys.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace
{

using namespace midair::samples;

/// Five toys under a weak gravity, so that a hand and a field can follow them.
class Toybox : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"toybox",
                "Balls and cubes that bounce in the array: push them, and feel them.",
                "Push the toys with your hand"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--gravity", _gravity, "How the toys fall, m/s^2")
            ->check(CLI::Range(0.0, 20.0))
            ->capture_default_str();
        app.add_option("--toss", _toss_s, "Every so often a toy is tossed up, s; 0: never")
            ->check(CLI::Range(0.0, 3600.0))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
        settings.prediction = osgMidair::HapticSettings::KALMAN;
    }

    void build(Stage& stage) override
    {
        stage.lit.addChild(glassBox(
            {}, osg::Vec3d(Toys::kHalfWidth_m, Toys::kHalfDepth_m, Toys::kHalfHeight_m) * 2.0));
        _toys = std::make_unique<Toys>(stage.haptics, _gravity, stage.seed);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.30, -0.50, 0.30}, {0.0, -0.012, 0.0}, osg::Z_AXIS, 19.5};
    }

    // A flat hand that comes in from the visitor's side, sweeps the box twice and leaves.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 8.0;
        constexpr double kInside_s = 6.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > kInside_s) return false;
        const double in = std::min({1.0, t / 0.8, (kInside_s - t) / 0.8});
        const osg::Vec3d tip(0.05 * std::sin(2.0 * osg::PI * t / 3.0),
                             -0.14 + 0.16 * in,
                             -0.032 + 0.012 * std::sin(2.0 * osg::PI * t / 1.7));
        hands.push_back(osgMidair::openHand(1, tip, osg::Quat(osg::PI_2, osg::X_AXIS)));
        return true;
    }

    void update(const Moment& now) override
    {
        const bool tosses = _toss_s > 0.0 && now.isSomebodyThere && now.time_s >= _nextToss_s;
        if (tosses) _nextToss_s = now.time_s + _toss_s;
        _toys->update(tosses);
    }

    void touched(const osgMidair::Touch& touch) override
    {
        if (Toy* toy = _toys->find(touch.node)) ++toy->touches;
        stroked(touch);
    }
    void stroked(const osgMidair::Touch& touch) override
    {
        if (Toy* toy = _toys->find(touch.node)) toy->force_N = std::max(toy->force_N, touch.force);
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        figures["tossed"] = _toys->tosses();
        figures["broughtBack"] = _toys->returns();
        for (const Toy& toy : _toys->all())
            figures["toys"].push_back({{"name", toy.name},
                                       {"pushes", toy.pushes},
                                       {"pushedWay_mm", 1e3 * toy.way_m},
                                       {"touches", toy.touches},
                                       {"largestForce_mN", 1e3 * toy.force_N}});
    }

private:
    double _gravity = 1.6;
    double _toss_s = 2.0;
    double _nextToss_s = 1.0;
    std::unique_ptr<Toys> _toys;
};

} // namespace

int main(int argc, char** argv)
{
    Toybox toybox;
    return runInstallation(toybox, argc, argv);
}
