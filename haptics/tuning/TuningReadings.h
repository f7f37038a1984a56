#pragma once

#include "haptics/tuning/TuningPlan.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Text of numbers with ranges, "3, 7-12 and 5 more", at most \a most of them.
std::string rangesText(const std::vector<int>& ascending, int most = 12);

/// What a microphone read of each row of a plan.
struct TuningReadings
{
    bool areLevels = false;    ///< no phases: the values are real
    Eigen::VectorXcd values;   ///< one a row, any linear unit; NaN: none
    std::vector<int> missing;  ///< rows that no line is of
    std::vector<int> unclear;  ///< rows whose reading was nan or inf; not counted as missing
    std::vector<int> repeated; ///< rows of several readings, whose mean counts
    std::vector<int> foreign;  ///< indices that the plan doesn't have
    bool isTorn = false;       ///< the last line had no end and is left out
    std::string planSum;       ///< of the plan that they belong to, as they say; may be empty

    /// What of the above there is, a sentence a line; empty for readings that are complete.
    std::vector<std::string> notes() const;
};

/// Returns what identifies a plan's file in its readings: the CRC-32C of its text, eight digits.
std::string planSum(const std::string& planText);

/// Reads lines of "index,re,im" or "index,level", in any order. Throws InputError,
/// "source:line: what it is; what it should be", for a line that is neither, for a mixture of both,
/// and where complex readings are needed and levels given.
TuningReadings
readingsFromCsv(const std::string& text, const std::string& source, const TuningPlan& plan);

/// Reads "re,im" or a level as an instrument writes it; nan and inf are NaN. Returns false for
/// anything else. \a isLevel: whether it was one number.
bool parseReading(const std::string& text, std::complex<double>& value, bool& isLevel);

} // namespace midair::haptics
