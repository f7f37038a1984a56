#pragma once

#include "haptics/tuning/TuningPlan.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Returns numbers as ranges, "3, 7-12 and 5 more", at most \a most of them.
std::string rangesText(const std::vector<int>& ascending, int most = 12);

/// Microphone readings of each row of a plan.
struct TuningReadings
{
    bool areLevels = false;    ///< no phases: the values are real
    Eigen::VectorXcd values;   ///< one per row, any linear unit; NaN: none
    std::vector<int> missing;  ///< rows without a line
    std::vector<int> unclear;  ///< rows with reading nan or inf; not counted as missing
    std::vector<int> repeated; ///< rows with several readings, which are averaged
    std::vector<int> foreign;  ///< indices that are not in the plan
    bool isTorn = false;       ///< the last line was incomplete and is left out
    std::string planSum;       ///< checksum of their plan, as given in the readings; may be empty

    /// Describes the above, a sentence per line; empty for complete readings.
    std::vector<std::string> notes() const;
};

/// Returns the identification of a plan's file in its readings: the CRC-32C of its text, eight
/// digits.
std::string planSum(const std::string& planText);

/// Reads lines of "index,re,im" or "index,level", in any order. Throws InputError, "source:line:
/// what it is; what it should be", for other lines, a mixture of both, and levels instead of
/// complex readings.
TuningReadings
readingsFromCsv(const std::string& text, const std::string& source, const TuningPlan& plan);

/// Reads "re,im" or a level as written by an instrument; nan and inf are NaN. Returns false for
/// anything else. \a isLevel: true for a single number.
bool parseReading(const std::string& text, std::complex<double>& value, bool& isLevel);

} // namespace midair::haptics
