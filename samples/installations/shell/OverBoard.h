#pragma once

#include "samples/installations/shell/Installation.h"

#include <osg/Matrix>

#include <cstdint>

namespace midair::samples
{

/// A display's picture that can be felt above one board. The world's origin is the picture's
/// centre.
class OverBoard : public Installation
{
public:
    void addOptions(CLI::App& app) override
    {
        app.add_option("--height", _height_m, "Height of the picture's centre above the board, m")
            ->check(CLI::Range(0.08, 0.3))
            ->capture_default_str();
    }
    std::string arrayOf(const std::string& /*device*/) const override { return "board"; }
    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
        settings.calibration = osg::Matrix::translate(0.0, 0.0, _height_m);
    }
    double ground_m() const override { return -_height_m; }

    void touched(const osgMidair::Touch& /*touch*/) override
    {
        ++_fingers;
        ++_touches;
    }
    void left(const osgMidair::Touch& /*touch*/) override { --_fingers; }
    void report(nlohmann::ordered_json& figures) const override
    {
        figures["touches"] = _touches;
        figures["height_mm"] = 1e3 * _height_m;
    }

protected:
    double height_m() const { return _height_m; }
    bool isTouched() const { return _fingers > 0; }

private:
    double _height_m = 0.15;
    int _fingers = 0;
    std::uint64_t _touches = 0;
};

} // namespace midair::samples
