#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningPlan.h"

#include <string>

namespace midair::samples
{

/// Exit status of midair-tune, for scripts.
enum TuneExit
{
    TUNED = 0,
    MORE_TO_DO = 1, ///< stopped, or the microphone has to be moved: the same command goes on
    WRONG_INPUT = 2,
    DEVICE_FAILED = 3,
    REFUSED = 4 ///< by the fit or the check, with the reason; nothing was written
};

/// Options of "midair-tune run".
struct RunOptions
{
    std::string device;
    std::string readings = "-";
    std::string out = "readings.csv";
    double settle_s = 1e-3;     ///< >= 0, after a row sounds until it is read
    double integrate_s = 4e-3;  ///< >= 0, until the instrument has its value
    double patience_s = 10.0;   ///< > 0, that the device and the instrument may take for a row
    double clip = 0.0;          ///< a level at which the microphone clips; 0: not known
    bool isFreeRunning = false; ///< the instrument writes by its own clock
    bool goesToAllPlaces = false;
    bool begins = false; ///< reads the place anew
    bool isQuiet = false;
};

/// Plays the rows of a plan that have no reading yet, up to the end of a place, and writes what the
/// instrument says. \a array: what drives and boards are those of, and for plans of foci the tuned
/// one. Returns a TuneExit. Throws base::InputError and device::DeviceError; the device is silent
/// whatever happens.
int runPlan(const RunOptions& options,
            const haptics::TuningPlan& plan,
            const std::string& planSum,
            const haptics::TransducerArray& array);

} // namespace midair::samples
