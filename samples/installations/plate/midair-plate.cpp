/// A star that floats before a plate of micro mirrors, as a real image: nothing is where it is seen
/// but air, which is felt. The world's origin is the middle of the picture, over one board.

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace
{

using namespace midair::samples;

class Plate : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"plate",
                "A star that floats before a plate of micro mirrors, over one board: --display "
                "samples/displays/plate.display.json.",
                "Touch the star: nothing is there but air"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--height", _height_m, "Of the picture's middle over the board, m")
            ->check(CLI::Range(0.08, 0.3))
            ->capture_default_str();
        app.add_option("--model", _model, "What floats there [the star]")->type_name("FILE");
        app.add_option("--size", _size_m, "Its largest extent, m")
            ->check(CLI::Range(0.02, 0.2))
            ->capture_default_str();
    }

    std::string arrayOf(const std::string& /*device*/) const override { return "board"; }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
        settings.calibration = osg::Matrix::translate(0.0, 0.0, _height_m);
    }

    void build(Stage& stage) override
    {
        const std::string file = _model.empty() ? sampleFile("models/star.obj") : _model;
        _surface = new osgMidair::HapticSurface(loadShownObject(file, _size_m, true).model);
        _surface->setName("star");
        _surface->setTouchEvents(true);
        _surface->setMaterial("glass");
        if (_model.empty()) paint(*_surface->getChild(0), kGold);
        _turning->setDataVariance(osg::Object::DYNAMIC);
        _turning->addChild(_surface);
        stage.haptics.addChild(_turning);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.18, -0.60, 0.16}, {0.01, 0.0, -0.005}, osg::Z_AXIS, 14.0};
    }

    double ground_m() const override { return -_height_m; }

    // From the visitor's side, along the star's front.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 7.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > 5.2) return false;
        const double in = eased(t, 0.2, 0.9) - eased(t, 4.4, 5.1);
        hands.push_back(pointingHand({0.010 + 0.012 * std::sin(1.7 * t),
                                      -0.005 - 0.12 * (1.0 - in),
                                      -0.004 + 0.008 * std::sin(2.1 * t)},
                                     -0.35));
        return true;
    }

    // While a finger is on it the star stays, turned to the visitor.
    void update(const Moment& now) override
    {
        if (_fingers == 0) _phase += now.step_s / kSwing_s;
        _turning->setMatrix(
            osg::Matrix::rotate(kSwing_rad * std::sin(2.0 * osg::PI * _phase), osg::Z_AXIS));
        _held_s += _fingers > 0 ? now.step_s : 0.0;
        _pointsAtMost = std::max(_pointsAtMost, now.statistics.points);
    }

    void touched(const osgMidair::Touch& /*touch*/) override
    {
        ++_fingers;
        ++_touches;
    }
    void left(const osgMidair::Touch& /*touch*/) override { --_fingers; }

    void report(nlohmann::ordered_json& figures) const override
    {
        figures["touches"] = _touches;
        figures["held_s"] = _held_s;
        figures["pointsAtMost"] = _pointsAtMost;
        figures["height_mm"] = 1e3 * _height_m;
    }

private:
    static constexpr double kSwing_s = 8.0;
    static constexpr double kSwing_rad = 0.45;
    inline static const osg::Vec4 kGold = {0.95F, 0.74F, 0.25F, 1.0F};

    double _height_m = 0.15;
    std::string _model;
    double _size_m = 0.07;
    double _phase = 0.0;
    double _held_s = 0.0;
    int _fingers = 0;
    int _pointsAtMost = 0;
    std::uint64_t _touches = 0;
    osg::ref_ptr<osg::MatrixTransform> _turning = new osg::MatrixTransform;
    osg::ref_ptr<osgMidair::HapticSurface> _surface;
};

} // namespace

int main(int argc, char** argv)
{
    Plate plate;
    return runInstallation(plate, argc, argv);
}
