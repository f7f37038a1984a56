#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Methods of distinguishing transducers with one microphone; CALIBRATION.md describes each.
enum class TuningMethod
{
    SINGLE,   ///< one transducer at a time, complex readings
    HADAMARD, ///< all at once with signs of a Hadamard matrix, complex readings
    LEVELS,   ///< one at a time in four phases plus reference transducers, levels only
    FOCUS     ///< foci of a tuned array at and around the microphone: the final check
};

/// Returns "single", "hadamard", "levels" or "focus".
const char* tuningMethodName(TuningMethod method);

/// Returns true for methods with complex readings, relative to the drive's clock; others need
/// levels only.
inline bool needsPhases(TuningMethod method)
{
    return method == TuningMethod::SINGLE || method == TuningMethod::HADAMARD;
}

/// A row of a plan. Members that its method doesn't mention are 0.
struct TuningRow
{
    int place = 0; ///< index into TuningPlan::places
    /// single, levels: the transducer. hadamard: the row of the matrix. focus: the transducer, or
    /// -1 for all of them, focused.
    int element = 0;
    int phaseLevel = 0;     ///< 0 .. 255, of the transducer
    int dutyLevel = 0;      ///< 0 .. 255, of all driven transducers except the reference; 0: off
    int referenceFirst = 0; ///< levels: the first transducer of the reference
    int referenceStep = 0;  ///< levels: step between its transducers
    int referenceDutyLevel = 0;                      ///< levels: 0: off
    Eigen::Vector3d focus = Eigen::Vector3d::Zero(); ///< focus: position, metres
};

/// Drive of a row, each m long: phase level L is e^{+j 2 pi L/256}, duty level L the amplitude
/// base::dutyAmplitude(L).
struct TuningDrive
{
    std::vector<std::uint8_t> phase;
    std::vector<std::uint8_t> duty;
};

/// Rows to play one after the other with a microphone at each of the places in turn, and the data
/// needed to play or read them.
struct TuningPlan
{
    TuningMethod method = TuningMethod::SINGLE;
    std::string array; ///< name, for users
    int transducers = 0;
    double soundSpeed_m_s = 343.2; ///< for planned foci
    std::vector<int> off;          ///< never driven because dead in the array's file; ascending
    Eigen::Matrix3Xd places;       ///< 3 x P, planned microphone places, array frame
    std::vector<TuningRow> rows;   ///< ascending by place

    int size() const { return static_cast<int>(rows.size()); }
    /// Throws InputError unless \a other has as many transducers as the plan's array.
    void requireFor(const TransducerArray& other) const;
    bool isOff(int element) const;
    /// Order of the Hadamard matrix: the smallest power of two above the number of transducers.
    int order() const;
};

/// Options of makeTuningPlan().
struct TuningPlanOptions
{
    TuningMethod method = TuningMethod::SINGLE;
    Eigen::Matrix3Xd places; ///< 3 x P, P >= 1, finite, metres, array frame
    int dutyLevel = 255;     ///< 1 .. 255: of every driven transducer
    double temperature_C = 20.0;
};

/// Returns the plan for \a options. Throws InputError for a place that is not finite or nearer than
/// 5 mm to a transducer, and if no transducer is left to drive.
TuningPlan makeTuningPlan(const TransducerArray& array, const TuningPlanOptions& options);

/// Returns the drive of \a row in \a plan. \a array: the tuned array, for foci; not used by other
/// methods.
TuningDrive driveOf(const TuningPlan& plan, const TuningRow& row, const TransducerArray* array);

/// Returns the text of a plan's file.
std::string toCsv(const TuningPlan& plan);
/// Reads the output of toCsv(); \a source: its name in messages. Throws InputError: "source:line:
/// what it is; what it should be".
TuningPlan tuningPlanFromCsv(const std::string& text, const std::string& source);

/// Returns the places in \a text, x, y, z in metres per line; skips lines that begin with # and a
/// first line of names. Throws InputError.
Eigen::Matrix3Xd placesFromCsv(const std::string& text, const std::string& source);

} // namespace midair::haptics
