#pragma once

#include "haptics/points/ControlPointSelector.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/tolerance/ToleranceStudy.h"

#include <osgMidair/FieldSettings>

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
    /// Two threads, because nothing else runs, and more points than for moving objects.
    SolveArguments()
    {
        settings.threads = 2;
        settings.maxPoints = 2000;
    }

    haptics::FieldSettings settings; ///< temperature, solver, cap, cycle, ..
    std::string model;
    std::string pointsFile;
    std::string earsFile; ///< listening places; empty: only those around the array
    std::string array = "octagon";
    std::string reflectorsFile; ///< reflectors besides those of the array; empty: none
    /// OBJ file of a rigid body, "reflectors" or "hand"; empty: none
    std::string scattererFile;
    std::vector<double> scattererAt_m; ///< where a hand's fingertip points; empty: above the points
    int scattererElements = 10000;     ///< 1000 .. 10000; of a hand, at most
    bool noCache = false;              ///< neither read nor keep the matrices of bodies
    bool noCorrection = false;         ///< solve for free air, and only tell what is in it
    std::string directivity;
    std::string out = "out";
    std::vector<double> position{0.0, 0.0, 0.0};
    std::vector<double> rotation_deg{0.0, 0.0, 0.0};
    double size_m = 0.0;
    double spacing_m = 0.0;
    double pressure_Pa = 0.0;
    haptics::Crowding crowding = haptics::Crowding::THIN;
    bool crowdingGiven = false;   ///< else points of a file are kept, even crowded ones
    bool evenGiven = false;       ///< else a single field isn't evened out
    std::vector<double> probes;   ///< x, y, z of each, metres, array frame
    bool probePoints = false;     ///< probe the control points, too
    double probePatch_m = 0.0;    ///< radius around each of probes; 0: only these
    double probeDuration_s = 1.0; ///< above 0, at most 3600
    double probeRate_Hz = 20e3;   ///< 1 .. 1e6; samples per second
    double ringing_s = -1.0;      ///< 0 .. 0.01; in place of the array's; -1: the array's
    double modulation_Hz = 0.0;   ///< 0 .. 500; amplitude modulation of the whole field
    bool certify = false;
    bool hasTolerance = false;           ///< study deviations of array and air
    haptics::ToleranceOptions tolerance; ///< runs in one thread
    bool outline = false;
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
};

/// Adds the options to \a app. Those for settings take effect after parsing.
void addOptions(CLI::App& app, SolveArguments& arguments);

/// Adds --tolerance and its options to \a app.
void addToleranceOptions(CLI::App& app, SolveArguments& arguments);

/// Writes
///     deviation,value,unit,draws,rms,rms_p90,loudness,loudness_p10,focus,focus_p10,
///     expected_rms,expected_focus
/// to \a path: first the nominal array, then each value. Figures without a theory are empty. Throws
/// base::InputError.
void writeTolerance(const std::string& path, const haptics::ToleranceStudy& study);

/// Prints the results for each value, and the total time.
void printTolerance(const haptics::ToleranceStudy& study);

} // namespace midair::samples
