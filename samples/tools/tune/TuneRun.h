#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningPlan.h"

#include <string>

namespace midair::samples
{

/// Options of "midair-tune run".
struct RunOptions
{
    std::string device;
    std::string readings = "-";
    std::string out = "readings.csv";
    double settle_s = 1e-3;     ///< >= 0, from a row's start to its reading
    double integrate_s = 4e-3;  ///< >= 0, duration of a reading
    double patience_s = 10.0;   ///< > 0, timeout of device and instrument per row
    double clip = 0.0;          ///< level at which the microphone clips; 0: unknown
    bool isFreeRunning = false; ///< the instrument writes by its own clock
    bool goesToAllPlaces = false;
    bool begins = false; ///< read the place anew
    bool isQuiet = false;
};

/// Plays the rows of a plan that have no reading yet, up to the end of a place, and writes the
/// readings. \a array defines drives and boards; for plans of foci it is the tuned array. Returns
/// an ExitCode; EXIT_PROBLEM: it was stopped, or the microphone must be moved; the same command
/// continues. Throws base::InputError and device::DeviceError; the device is always silent at the
/// end.
int runPlan(const RunOptions& options,
            const haptics::TuningPlan& plan,
            const std::string& planSum,
            const haptics::TransducerArray& array);

} // namespace midair::samples
