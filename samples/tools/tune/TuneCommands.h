#pragma once

#include "haptics/tuning/RehearsedInstrument.h"
#include "haptics/tuning/TuningFit.h"
#include "samples/tools/tune/TuneRun.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// What the commands of midair-tune are given.
struct TuneArguments
{
    std::string array = "octagon";
    std::string plan = "plan.csv";
    std::string out;
    std::string method = "single";
    std::vector<double> mic_m; ///< x, y, z of each place
    std::string placesFile;
    int dutyLevel = 255;
    std::string readings = "readings.csv";
    std::string picture;
    std::string truth;
    std::string tuned;
    bool serves = false;
    RunOptions run;
    haptics::TuningFitOptions fit;
    haptics::RehearsalOptions rehearsal;
};

// The commands; each returns a TuneExit and throws base::InputError or device::DeviceError.
int planTuning(const TuneArguments& arguments);
int runTuning(const TuneArguments& arguments);
int fitArray(const TuneArguments& arguments);
int checkArray(const TuneArguments& arguments);
int rehearse(const TuneArguments& arguments);

/// Draws the picture of a fit into \a path (.svg, .png, .pdf): a map of the array, each side seen
/// from where it emits to, with the phases of its transducers, the reversed and the dead ones, and
/// the histograms of phases and gains. Returns what went wrong, or an empty text.
std::string drawTuning(const haptics::TuningFit& fit, const std::string& path);

} // namespace midair::samples
