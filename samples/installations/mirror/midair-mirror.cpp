/// A beating heart behind a half mirror: it is seen where it is felt and beats faster while
/// touched. The world's origin is the centre of the picture, above one board.

#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/OverBoard.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

using namespace midair::samples;

class Mirror : public OverBoard
{
public:
    InstallationTitle title() const override
    {
        return {"mirror",
                "A beating heart behind a half mirror, above one board: --display "
                "samples/displays/mirror.display.json.",
                "Reach behind the mirror, and touch the heart"};
    }

    void build(Stage& stage) override
    {
        _surface = new osgMidair::HapticSurface;
        _surface->setName("heart");
        _surface->setTouchEvents(true);
        _surface->setMaterial("rubber");
        _surface->addChild(
            solid(new osg::Sphere({}, static_cast<float>(kRadius_m)), kResting, 2.0F));
        _beating->setDataVariance(osg::Object::DYNAMIC);
        _beating->addChild(_surface);
        stage.haptics.addChild(_beating);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.16, -0.85, 0.22}, {0.02, 0.0, -0.35 * height_m()}, osg::Z_AXIS, 19.0};
    }

    // Comes from the right, behind the mirror; the fingertip rests on the heart's side.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 6.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > 4.5) return false;
        const double in = eased(t, 0.2, 0.8) - eased(t, 3.8, 4.4);
        const osg::Vec3d tip(kRadius_m + 0.005 + 0.12 * (1.0 - in),
                             -0.006 * std::sin(1.9 * t),
                             0.004 + 0.006 * std::sin(2.3 * t));
        hands.push_back(pointing(osgMidair::openHand(
            1, tip, osg::Quat(2.0 * osg::PI / 3.0, osg::Vec3d(1.0, 1.0, 1.0)))));
        return true;
    }

    void update(const Moment& now) override
    {
        const double wanted_Hz = isTouched() ? kExcited_Hz : kCalm_Hz;
        _rate_Hz += (wanted_Hz - _rate_Hz) * std::min(1.0, now.step_s / kCalming_s);
        const double before = _phase;
        _phase += _rate_Hz * now.step_s;
        if (std::floor(_phase) > std::floor(before)) ++_beats;
        // Two pulses per beat, the second one weaker.
        const double in = _phase - std::floor(_phase);
        const double beat = std::exp(-60.0 * (in - 0.12) * (in - 0.12)) +
                            0.5 * std::exp(-60.0 * (in - 0.42) * (in - 0.42));
        const double size = 1.0 + kSwelling * beat;
        _beating->setMatrix(osg::Matrix::scale(size, size, size));
        _fastest_Hz = std::max(_fastest_Hz, _rate_Hz);
        const double warm = std::clamp((_rate_Hz - kCalm_Hz) / (kExcited_Hz - kCalm_Hz), 0.0, 1.0);
        paint(*_surface->getChild(0), kResting * (1.0 - warm) + kTouched * warm);
    }

    std::string caption() const override
    {
        return fmt::format("{:.0f} beats a minute", 60.0 * _rate_Hz);
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        OverBoard::report(figures);
        figures["beats"] = _beats;
        figures["fastest_perMinute"] = 60.0 * _fastest_Hz;
    }

private:
    static constexpr double kRadius_m = 0.022;
    static constexpr double kSwelling = 0.12;
    static constexpr double kCalm_Hz = 1.0;
    static constexpr double kExcited_Hz = 1.9;
    static constexpr double kCalming_s = 1.5;
    inline static const osg::Vec4 kResting = {0.80F, 0.22F, 0.24F, 1.0F};
    inline static const osg::Vec4 kTouched = {1.00F, 0.62F, 0.22F, 1.0F};

    double _rate_Hz = kCalm_Hz;
    double _fastest_Hz = kCalm_Hz;
    double _phase = 0.0;
    std::uint64_t _beats = 0;
    osg::ref_ptr<osg::MatrixTransform> _beating = new osg::MatrixTransform;
    osg::ref_ptr<osgMidair::HapticSurface> _surface;
};

} // namespace

int main(int argc, char** argv)
{
    Mirror mirror;
    return runInstallation(mirror, argc, argv);
}
