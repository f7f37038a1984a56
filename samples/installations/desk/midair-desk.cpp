/// A demonstration for one board on a desk: a ring that breathes above the palm, and two buttons
/// that change it.

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"

#include <osgMidair/HapticSurface>

#include <osg/Geometry>
#include <osg/LineWidth>
#include <osg/MatrixTransform>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace
{

using namespace midair::samples;

constexpr int kCorners = 32; ///< of the ring

/// A button beside the ring, which a finger can touch.
struct Button
{
    std::string name;
    double x_m = 0.0;
    osg::ref_ptr<osgMidair::HapticSurface> surface;
    std::uint64_t presses = 0;
    int fingers = 0;
};

class Desk : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"desk",
                "A ring above one board on a desk: an AUTD3 unit or a SonicSurface.",
                "Hold your palm over the board"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--height", _height_m, "Height of the ring above the board, m")
            ->check(CLI::Range(0.08, 0.25))
            ->capture_default_str();
    }

    // The array that matches the device.
    std::string arrayOf(const std::string& device) const override
    {
        return device.find("sonicsurface") != std::string::npos ? "sonicsurface" : "autd3";
    }

    // A board on a serial line plays some 60 fields a second; the ring moves slowly enough for
    // that.
    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::OBJECT;
        settings.motionTolerance = 0.02;
        // SonicSurface emitters are only on or off, so a cap could only silence it.
        if (settings.array == "sonicsurface") settings.maxPressure = 0.0;
    }

    void build(Stage& stage) override
    {
        addRing(stage);
        for (Button& button : _buttons)
            addButton(stage, button);
        const osg::ref_ptr<osg::MatrixTransform> board =
            new osg::MatrixTransform(osg::Matrix::translate(0.0, 0.0, -0.010));
        board->addChild(
            solid(new osg::Box({}, 0.200F, 0.170F, 0.008F), {0.20F, 0.24F, 0.30F, 1.0F}));
        stage.lit.addChild(board);
    }

    Viewpoint viewpoint() const override
    {
        // The hand is below the invitation.
        return {{0.55, -0.45, _height_m + 0.25},
                {-0.03, -0.04, 0.66 * _height_m + 0.015},
                osg::Z_AXIS,
                23.0};
    }

    std::vector<std::string> overlays() const override { return {"hands", "array"}; }

    // Presses one button after the other and puts the palm into the ring in between.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 9.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > 6.0) return false;
        const double side = -1.0 + eased(t, 1.7, 2.0) + eased(t, 3.7, 4.0);
        const double in = std::fmod(t, 2.0);
        const double pressed = eased(in, 0.3, 0.7) - eased(in, 1.3, 1.7);
        // The finger pad is 7 mm below the centre of the tip.
        hands.push_back(pointingHand(
            {side * kAside_m, -0.012, _height_m + 0.005 + 0.03 * (1.0 - pressed)}, 0.3));
        return true;
    }

    void update(const Moment& now) override
    {
        const double rate_Hz = _isQuick ? 0.8 : 0.25;
        _phase += rate_Hz * now.step_s;
        placeRing();
        _pointsAtMost = std::max(_pointsAtMost, now.statistics.points);
    }

    void touched(const osgMidair::Touch& touch) override
    {
        for (Button& button : _buttons)
            if (button.surface == touch.node && ++button.fingers == 1) press(button);
    }
    void left(const osgMidair::Touch& touch) override
    {
        for (Button& button : _buttons)
            if (button.surface == touch.node) --button.fingers;
    }

    std::string caption() const override
    {
        return std::string(_isQuick ? "quick" : "slow") +
               (_isTrembling ? ", trembling" : ", steady");
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        for (const Button& button : _buttons)
            figures["presses"][button.name] = button.presses;
        figures["ring_mm"] = {1e3 * _least_m, 1e3 * _most_m};
        figures["height_mm"] = 1e3 * _height_m;
        figures["pointsAtMost"] = _pointsAtMost;
    }

private:
    static constexpr double kAside_m = 0.05; ///< position of the buttons
    /// limit of a SonicSurface's serial line: two fields per period, 89 fields a second
    static constexpr double kTremble_Hz = 40.0;

    void addRing(Stage& stage)
    {
        osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
        for (int i = 0; i < kCorners; ++i)
        {
            const double angle = 2.0 * osg::PI * i / kCorners;
            corners->push_back(osg::Vec3(
                static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0F));
        }
        osg::ref_ptr<osg::Geometry> line = new osg::Geometry;
        line->setVertexArray(corners);
        line->addPrimitiveSet(new osg::DrawArrays(GL_LINE_LOOP, 0, kCorners));
        line->setColorArray(new osg::Vec4Array(1, &kShownColors[1]), osg::Array::BIND_OVERALL);
        line->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
        line->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(5.0F));
        _felt = new osgMidair::HapticSurface;
        _felt->setName("ring");
        _felt->addChild(line);
        _ring->setDataVariance(osg::Object::DYNAMIC);
        _ring->addChild(_felt);
        placeRing(); // an array is opened before the first frame, and sees it
        stage.haptics.addChild(_ring);
    }

    void placeRing()
    {
        const double radius = 0.018 + 0.006 * std::sin(2.0 * osg::PI * _phase);
        _least_m = std::min(_least_m, radius);
        _most_m = std::max(_most_m, radius);
        _ring->setMatrix(osg::Matrix::scale(radius, radius, 1.0) *
                         osg::Matrix::translate(0.0, 0.0, _height_m));
    }

    void addButton(Stage& stage, Button& button) const
    {
        button.surface = new osgMidair::HapticSurface;
        button.surface->setName(button.name);
        button.surface->setTouchEvents(true);
        button.surface->setRender(osgMidair::HapticProperty::CONTACT);
        button.surface->setMaterial("glass");
        button.surface->addChild(
            solid(new osg::Cylinder({}, 0.011F, 0.004F), kShownColors[button.x_m < 0.0 ? 0 : 2]));
        const osg::ref_ptr<osg::MatrixTransform> placed =
            new osg::MatrixTransform(osg::Matrix::translate(button.x_m, 0.0, _height_m - 0.002));
        placed->addChild(button.surface);
        stage.haptics.addChild(placed);
    }

    void press(Button& button)
    {
        ++button.presses;
        if (&button == &_buttons[0])
            _isQuick = !_isQuick;
        else
        {
            _isTrembling = !_isTrembling;
            _felt->setModulationFrequency(_isTrembling ? kTremble_Hz : 0.0);
        }
    }

    double _height_m = 0.15;
    double _phase = 0.0;
    double _least_m = 1.0;
    double _most_m = 0.0;
    int _pointsAtMost = 0;
    bool _isQuick = false;
    bool _isTrembling = false;
    osg::ref_ptr<osg::MatrixTransform> _ring = new osg::MatrixTransform;
    osg::ref_ptr<osgMidair::HapticSurface> _felt;
    std::array<Button, 2> _buttons = {Button{"quick", -kAside_m, nullptr, 0, 0},
                                      Button{"trembling", kAside_m, nullptr, 0, 0}};
};

} // namespace

int main(int argc, char** argv)
{
    Desk desk;
    return runInstallation(desk, argc, argv);
}
