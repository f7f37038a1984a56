/// A star that floats in front of a plate of micro mirrors as a real image and can be felt there.
/// The world's origin is the centre of the picture, above one board.

#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/OverBoard.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace
{

using namespace midair::samples;

class Plate : public OverBoard
{
public:
    InstallationTitle title() const override
    {
        return {"plate",
                "A star that floats in front of a plate of micro mirrors, above one board: "
                "--display samples/displays/plate.display.json.",
                "Touch the star: it is only air"};
    }

    void addOptions(CLI::App& app) override
    {
        OverBoard::addOptions(app);
        app.add_option("--model", _model, "Model to show [the star]")->type_name("FILE");
        app.add_option("--size", _size_m, "Its largest extent, m")
            ->check(CLI::Range(0.02, 0.2))
            ->capture_default_str();
    }

    void build(Stage& stage) override
    {
        const std::string file = _model.empty() ? sampleFile("models/star.obj") : _model;
        const ShownObject star = loadShownObject(file, _size_m, true);
        star.felt->setName("star");
        if (star.surface)
        {
            star.surface->setTouchEvents(true);
            star.surface->setMaterial("glass");
        }
        if (_model.empty()) paint(*star.model, kGold);
        _turning->setDataVariance(osg::Object::DYNAMIC);
        _turning->addChild(star.felt);
        stage.haptics.addChild(_turning);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.18, -0.60, 0.16}, {0.01, 0.0, -0.005}, osg::Z_AXIS, 14.0};
    }

    // Comes from the visitor's side and moves along the star's front.
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

    // The star stops, facing the visitor, while a finger touches it.
    void update(const Moment& now) override
    {
        if (!isTouched()) _phase += now.step_s / kSwing_s;
        _turning->setMatrix(
            osg::Matrix::rotate(kSwing_rad * std::sin(2.0 * osg::PI * _phase), osg::Z_AXIS));
        _held_s += isTouched() ? now.step_s : 0.0;
        _pointsAtMost = std::max(_pointsAtMost, now.statistics.points);
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        OverBoard::report(figures);
        figures["held_s"] = _held_s;
        figures["pointsAtMost"] = _pointsAtMost;
    }

private:
    static constexpr double kSwing_s = 8.0;
    static constexpr double kSwing_rad = 0.45;
    inline static const osg::Vec4 kGold = {0.95F, 0.74F, 0.25F, 1.0F};

    std::string _model;
    double _size_m = 0.07;
    double _phase = 0.0;
    double _held_s = 0.0;
    int _pointsAtMost = 0;
    osg::ref_ptr<osg::MatrixTransform> _turning = new osg::MatrixTransform;
};

} // namespace

int main(int argc, char** argv)
{
    Plate plate;
    return runInstallation(plate, argc, argv);
}
