#pragma once

#include <string>
#include <vector>

namespace midair::samples
{

/// What the main sample was asked for.
struct DemoOptions
{
    std::string model; ///< a file that OSG reads; empty: the paper's star
    double size_m = 0.12;
    std::string array;  ///< empty: the scene file's, else the octagon
    std::string device; ///< empty: the scene file's as far as it is granted, else sim:
    std::string solver; ///< empty: the kit's default
    double temperature_C = 20.0;
    std::string sampling;        ///< surface, edges, vertices; empty: the kit's default
    double spacing_m = 0.0;      ///< 0: one wavelength
    double pressure_Pa = 0.0;    ///< 0: as loud as it accurately can
    double maxPressure_Pa = 0.0; ///< cap at every control point; 0: none
    double loudness = 1.0;       ///< above 1: louder than it accurately can
    int cycle = 1;               ///< fields for shifted points in turn, where the object rests
    int cycleSteps = 0;
    int subsets = 1;            ///< of the points, in turn
    double modulation_Hz = 0.0; ///< of the object; 0: steady
    double fieldRate_Hz = 1000.0;
    double monitor_s = 0.0;            ///< so often a field is certified and measured; 0: never
    int maxPoints = 0;                 ///< 0: no limit
    std::vector<std::string> overlays; ///< shown ones; empty: all
    bool still = false;                ///< the object stays in the middle
    int frames = 0; ///< 0: 240 without a display, until the window is closed with one
    std::string out = "build/out";
    bool headless = false;
    bool benchmark = false;
    int width = 1200;
    int height = 800;
};

/// False where the program is done already: help was asked for, or an option is wrong; \a status is then its exit status.
bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status);

} // namespace midair::samples
