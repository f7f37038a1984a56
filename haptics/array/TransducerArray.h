#pragma once

#include "haptics/array/Reflector.h"

#include <Eigen/Core>

#include <string>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// Model of how a transducer's amplitude decreases with the angle theta from its normal; D(0) = 1,
/// D >= 0.
enum class Directivity
{
    T4010A1_HARMONICS, ///< zonal harmonics of order 0..3 from the paper; -2.2 dB at 50 degrees
    T4010A1_TABLE,     ///< data sheet, measured at 0, 10, .. 90 degrees; -6 dB at 50; 0 behind
    POINT              ///< D = 1
};

/// Returns D(theta) of \a model at cos(theta) = \a cosTheta in [-1, 1].
double directivity(Directivity model, double cosTheta);

/// Returns "t4010a1-harmonics", "t4010a1-table" or "point".
const char* directivityName(Directivity model);
/// Returns the model of that name. Throws InputError, with the known names, for any other.
Directivity directivityFromName(const std::string& name);

/// Smallest distance R to a transducer in the model, about its radius; smaller distances count as
/// this.
constexpr double kNearestDistance_m = 5e-3;

/// Range of source amplitudes, Pa m: far beyond any transducer's, and such that single precision
/// holds every pressure. Figures don't depend on the position within it.
constexpr double kLeastSource_Pa_m = 1e-30;
constexpr double kMostSource_Pa_m = 1e30;

/// P0 of one T4010A1 (Nippon Ceramic) from its data sheet: 121.5 dB SPL (rms) at 0.30 m.
constexpr double kT4010A1Source_Pa_m = 10.1;

/// Time constant of the T4010A1 (Nippon Ceramic), s: the Butterworth-Van Dyke circuit in the AUTD3
/// emulator (80 mH, 200 pF, 700 ohm, source of 150 ohm) rings with 2L/R = 188 us. No measured
/// envelope is published; circuits from other sources give 160 to 280 us.
constexpr double kT4010A1Ringing_s = 190e-6;

/// Longest time constant that an array may have, s: 50 times that of any 40 kHz transducer.
constexpr double kMostRinging_s = 0.01;

/// Largest gain of a transducer.
constexpr double kMostGain = 1000.0;

/// Phases and amplitudes that a device can play; solvers round to them.
struct DriveResolution
{
    int phaseLevels = 256; ///< phases are multiples of 2 pi / phaseLevels; 0: continuous
    std::vector<float> amplitudeLevels; ///< ascending, in [0, 1], the last one 1; empty: continuous
};

/// Transducers of an array, in the array frame (right-handed, metres, origin at the centre of the
/// workspace, y along the prism's axis).
struct TransducerArray
{
    std::string name;
    double frequency_Hz = 40e3;
    /// P0 for solving: peak pressure times distance on axis at full drive. It may be fitted to the
    /// pressure of a focus, which scattered phases and saturation reduce. kLeastSource_Pa_m ..
    /// kMostSource_Pa_m; in files at most 1e5.
    double sourceAmplitude_Pa_m = kT4010A1Source_Pa_m;
    /// P0 of a single transducer, without these losses, for the level at ears: see
    /// heardAmplitude_Pa_m(). 0: unknown, or up to the same maximum.
    double exposureAmplitude_Pa_m = 0.0;
    /// Decrease off the axis; default: the table of the same data sheet.
    Directivity directivity = Directivity::T4010A1_TABLE;
    /// 0 .. kMostRinging_s; time constant tau: after a transducer's drive changes from q0 to q1,
    /// its envelope is q1 + (q0 - q1) e^{-t/tau}. Solvers assume steady fields; PressureProbe and
    /// the ringing figures use tau. 0: no ringing.
    double ringing_s = kT4010A1Ringing_s;
    Eigen::Matrix3Xd positions; ///< 3 x m, metres
    Eigen::Matrix3Xd normals;   ///< 3 x m, unit length, direction of emission
    /// m or empty: phase added to each transducer's drive
    Eigen::VectorXd phaseOffset_rad;
    Eigen::VectorXd gain;   ///< m or empty: amplitude factor
    std::vector<int> board; ///< m: board of each transducer, ascending from 0
    /// Transducers that are never driven, ascending; set by setDead(). Their gain is 0, so solvers
    /// don't use them.
    std::vector<int> dead;
    DriveResolution drive;
    /// What stands beside the array and reflects its sound; G includes it. At most kMostReflectors.
    std::vector<Reflector> reflectors;

    int size() const { return static_cast<int>(positions.cols()); }

    /// Returns P0 for the level at ears: the larger of sourceAmplitude_Pa_m and
    /// exposureAmplitude_Pa_m. If the latter is 0 and the directivity is a T4010A1's, at least the
    /// data sheet's kT4010A1Source_Pa_m.
    double heardAmplitude_Pa_m() const;

    /// Marks the transducers \a which (0 .. m - 1, any order) as dead: sets their gains to 0.
    /// Transducers that were dead before stay dead.
    void setDead(const std::vector<int>& which);

    /// Sets the gains of the transducers in \a which: index 0 .. m - 1 and gain above 0. None of
    /// them may be dead.
    void setGains(const std::vector<std::pair<int, double>>& which);

    /// Applies user settings of single transducers: \a dead, "17, 400-410", in addition to those
    /// already dead, and \a weak, gains: "17:0.5, 400-410:0.8". Throws InputError, which names the
    /// entry, for syntax errors, indices that the array doesn't have, and a transducer in both
    /// lists.
    void mark(const std::string& dead, const std::string& weak);

    /// The paper's device: 16 boards of 249 transducers on the eight sides of a prism around the y
    /// axis, 3984 in all; P0 = 2.73 Pa m with the paper's harmonics, from which P0 was derived; for
    /// ears the data sheet's P0.
    static TransducerArray octagonalPrism();
    /// One board of 249 in the plane z = 0, facing +z; P0 and directivity from the data sheet.
    static TransducerArray singleBoard();
    /// Loads "octagon", "board", a named array (see names()), or the JSON file at that path. Throws
    /// InputError.
    static TransducerArray load(const std::string& nameOrPath);

    /// Returns the names that load() knows: "octagon", "board", then every NAME.json in the folders
    /// of the environment variable OSG_MIDAIR_ARRAYS (separated by colons), of the installation and
    /// of the source tree.
    static std::vector<std::string> names();

    /// Returns the file that load() would read now for \a nameOrPath; empty for built-in arrays and
    /// unknown names.
    static std::string fileOf(const std::string& nameOrPath);

    /// Reads an array from \a json (format: samples/guides/ARRAYS.md); \a source: its name in
    /// messages. Throws InputError: "source: path in the file: what it is; what it must be".
    static TransducerArray fromJson(const std::string& json, const std::string& source);

    /// Returns JSON text that fromJson() reads back as an equal array. Throws InputError if the
    /// array is not valid.
    std::string toJson() const;

    /// Writes toJson() to \a path. Throws InputError on failure.
    void save(const std::string& path) const;

    /// Returns false if lengths disagree or a value is out of range; \a error then names it. Loaded
    /// arrays are valid.
    bool isValid(std::string* error = nullptr) const;
};

} // namespace midair::haptics
