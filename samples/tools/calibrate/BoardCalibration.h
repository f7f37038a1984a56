#pragma once

#include <string>

namespace midair::samples
{

/// What midair-calibrate --boards is asked for.
struct BoardSettings
{
    bool isAsked = false;
    std::string array = "octagon"; ///< as it was meant: a name or a file
    std::string measurements;      ///< file, or - for stdin; empty: what to measure is printed
    std::string out;               ///< array file to write; empty: none
    std::string plan;              ///< file to write what to measure into; empty: stdout
    double longest_m = 1.0;        ///< of the tape
    double sigma_m = 1e-3;         ///< standard deviation of a distance
    double temperature_C = 20.0;   ///< for times
    int count = 0;                 ///< distances to measure; 0: one and a half a unknown
};

/// Prints what to measure, or finds the boards from what was measured, prints where they are and
/// writes the array's file. Returns 0, or 1 if the measurements are of no use: the reasons are
/// printed and nothing is written. Throws midair::base::InputError.
int calibrateBoards(const BoardSettings& settings);

} // namespace midair::samples
