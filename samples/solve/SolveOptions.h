#pragma once

#include "haptics/points/ControlPointSelector.h"
#include "haptics/surface/SurfaceSampler.h"

#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace midair::samples
{

/// Options of midair-solve; lengths in metres.
struct SolveArguments
{
    std::string model;
    std::string pointsFile;
    std::string array = "octagon";
    std::string directivity;
    std::string solver;
    std::string out = "out";
    std::vector<double> position{0.0, 0.0, 0.0};
    std::vector<double> rotation_deg{0.0, 0.0, 0.0};
    double size_m = 0.0;
    double spacing_m = 0.0;
    double pressure_Pa = 0.0;
    double maxPressure_Pa = 0.0;
    double temperature_C = 20.0;
    haptics::Crowding crowding = haptics::Crowding::THIN;
    bool certify = false;
    int cycle = 1;
    int cycleSteps = 0;
    int subsets = 1;
    int sweeps = 0;
    double fieldRate_Hz = 1000.0;
    double loudness = 1.0;
    bool outline = false;
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
};

void addOptions(CLI::App& app, SolveArguments& arguments);

} // namespace midair::samples
