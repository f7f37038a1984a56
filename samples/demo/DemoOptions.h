#pragma once

#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// What the main sample was asked for.
struct DemoOptions
{
    std::string model; ///< a file that OSG reads; empty: the paper's star
    double size_m = 0.12;
    /// What was said of the scene and of the object's property: names and texts as
    /// HapticSettings::set() and HapticProperty::set() know them, in the order given. What isn't
    /// here is the scene file's, or the kit's default.
    std::vector<std::pair<std::string, std::string>> scene;
    std::vector<std::pair<std::string, std::string>> object;
    double pressure_Pa =
        0.0; ///< peak that is wanted of the object; 0: as loud as it accurately can
    std::vector<std::string> overlays; ///< shown ones; empty: all
    bool still = false;                ///< the object stays in the middle
    int frames = 0; ///< 0: 240 without a display, until the window is closed with one
    std::string out = "build/out";
    bool headless = false;
    bool benchmark = false;
    int width = 1200;
    int height = 800;
};

/// False where the program is done already: help was asked for, or an option is wrong; \a status is
/// then its exit status.
bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status);

} // namespace midair::samples
