#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// How transducers are told apart by one microphone; CALIBRATION.md has the rule of each.
enum class TuningMethod
{
    SINGLE,   ///< one transducer at a time, complex readings
    HADAMARD, ///< all at once with signs of Hadamard's matrix, complex readings
    LEVELS,   ///< one at a time in four phases beside reference transducers, levels alone
    FOCUS     ///< foci of a tuned array at and around the microphone: the check afterwards
};

/// Returns "single", "hadamard", "levels" or "focus".
const char* tuningMethodName(TuningMethod method);

/// True for methods whose readings are complex, against the drive's clock; else levels will do.
inline bool needsPhases(TuningMethod method)
{
    return method == TuningMethod::SINGLE || method == TuningMethod::HADAMARD;
}

/// What one row of a plan plays. The members that its method doesn't name are 0.
struct TuningRow
{
    int place = 0; ///< of TuningPlan::places
    /// single, levels: the transducer. hadamard: the row of the matrix. focus: the transducer, or
    /// -1 for all of them, focused.
    int element = 0;
    int phaseLevel = 0;         ///< 0 .. 255, of the transducer
    int dutyLevel = 0;          ///< 0 .. 255, of all that the row drives but the reference; 0: off
    int referenceFirst = 0;     ///< levels: the first transducer of the reference
    int referenceStep = 0;      ///< levels: from each of its transducers to the next
    int referenceDutyLevel = 0; ///< levels: 0: off
    Eigen::Vector3d focus = Eigen::Vector3d::Zero(); ///< focus: where, metres
};

/// One field as rows play it, each m long: phase level L is e^{+j 2 pi L/256}, duty level L the
/// amplitude base::dutyAmplitude(L).
struct TuningDrive
{
    std::vector<std::uint8_t> phase;
    std::vector<std::uint8_t> duty;
};

/// Rows that are played one after the other while a microphone stands at each of the places in
/// turn, and what a program that plays or reads them has to know.
struct TuningPlan
{
    TuningMethod method = TuningMethod::SINGLE;
    std::string array; ///< its name, for people
    int transducers = 0;
    double soundSpeed_m_s = 343.2; ///< that foci were planned with
    std::vector<int> off;          ///< never driven: dead in the array's file; ascending
    Eigen::Matrix3Xd places;       ///< 3 x P, where the microphone is meant to be, array frame
    std::vector<TuningRow> rows;   ///< ascending by place

    int size() const { return static_cast<int>(rows.size()); }
    /// Throws InputError if it isn't for an array of as many transducers as \a other has.
    void requireFor(const TransducerArray& other) const;
    bool isOff(int element) const;
    /// Order of Hadamard's matrix: the least power of two above the number of transducers.
    int order() const;
};

/// What plans are made with.
struct TuningPlanOptions
{
    TuningMethod method = TuningMethod::SINGLE;
    Eigen::Matrix3Xd places; ///< 3 x P, P >= 1, finite, metres, array frame
    int dutyLevel = 255;     ///< 1 .. 255: of every transducer that is driven
    double temperature_C = 20.0;
};

/// Returns the plan of \a options. Throws InputError for a place that is not finite or nearer than
/// 5 mm to a transducer, and where no transducer is left to drive.
TuningPlan makeTuningPlan(const TransducerArray& array, const TuningPlanOptions& options);

/// Returns what row \a row of \a plan drives. \a array: the tuned array, for foci; other methods
/// need none.
TuningDrive driveOf(const TuningPlan& plan, const TuningRow& row, const TransducerArray* array);

/// Returns the text of a plan's file.
std::string toCsv(const TuningPlan& plan);
/// Reads what toCsv() writes; \a source: its name in messages. Throws InputError: "source:line:
/// what it is; what it should be".
TuningPlan tuningPlanFromCsv(const std::string& text, const std::string& source);

/// Returns the places in \a text, a line of x, y, z in metres each; lines that begin with # and a
/// first line of names are passed over. Throws InputError.
Eigen::Matrix3Xd placesFromCsv(const std::string& text, const std::string& source);

} // namespace midair::haptics
