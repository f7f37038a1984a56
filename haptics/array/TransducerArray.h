#pragma once

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
    T4010A1_HARMONICS, ///< the paper's zonal harmonics of order 0..3; -2.2 dB at 50 degrees
    T4010A1_TABLE, ///< its data sheet's, measured at 0, 10, .. 90 degrees; -6 dB at 50; 0 behind
    POINT          ///< D = 1
};

/// Returns D(theta) of \a model at cos(theta) = \a cosTheta in [-1, 1].
double directivity(Directivity model, double cosTheta);

/// Returns "t4010a1-harmonics", "t4010a1-table" or "point".
const char* directivityName(Directivity model);
/// Returns the model of that name. Throws InputError, with the known names, for any other.
Directivity directivityFromName(const std::string& name);

/// Shortest distance R to a transducer that the model uses, about its radius; smaller ones are
/// raised to it.
constexpr double kNearestDistance_m = 5e-3;

/// Range of source amplitudes, Pa m: far beyond any transducer's, and such that single precision
/// holds every pressure. Figures don't depend on where in it an array is.
constexpr double kLeastSource_Pa_m = 1e-30;
constexpr double kMostSource_Pa_m = 1e30;

/// P0 of one T4010A1 (Nippon Ceramic), by its data sheet: 121.5 dB SPL (rms) at 0.30 m.
constexpr double kT4010A1Source_Pa_m = 10.1;

/// Time constant of the T4010A1 (Nippon Ceramic), s: the Butterworth-Van Dyke circuit that the
/// AUTD3 emulator has of it (80 mH, 200 pF, 700 ohm, a source of 150 ohm) rings with 2L/R = 188 us.
/// No measured envelope is published; circuits of others give 160 to 280 us.
constexpr double kT4010A1Ringing_s = 190e-6;

/// Longest time constant that an array may have, s: 50 times that of any 40 kHz transducer.
constexpr double kMostRinging_s = 0.01;

/// Largest gain of a transducer.
constexpr double kMostGain = 1000.0;

/// Phases and amplitudes that a device can play; the solver rounds to them.
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
    /// P0: peak pressure times distance on axis at full drive, by which fields are solved for. An
    /// array's may be fitted to the pressure of its focus, which loses by scatter of the phases and
    /// by saturation. kLeastSource_Pa_m .. kMostSource_Pa_m; in files at most 1e5.
    double sourceAmplitude_Pa_m = kT4010A1Source_Pa_m;
    /// P0 of a transducer by itself, for the level at ears, which loses nothing of that: see
    /// heardAmplitude_Pa_m(). 0: not known, or up to the same maximum.
    double exposureAmplitude_Pa_m = 0.0;
    /// How it decreases off the axis; the same data sheet's table.
    Directivity directivity = Directivity::T4010A1_TABLE;
    /// 0 .. kMostRinging_s; time constant tau of the transducers: after its drive goes from q0 to
    /// q1, the envelope of one is q1 + (q0 - q1) e^{-t/tau}. Fields are solved for as steady ones;
    /// the figures with ringing and PressureProbe know it. 0: it follows at once.
    double ringing_s = kT4010A1Ringing_s;
    Eigen::Matrix3Xd positions; ///< 3 x m, metres
    Eigen::Matrix3Xd normals;   ///< 3 x m, unit length, the direction of emission
    /// m or empty: phase that each transducer adds to its drive
    Eigen::VectorXd phaseOffset_rad;
    Eigen::VectorXd gain;   ///< m or empty: factor on the amplitude
    std::vector<int> board; ///< m: board of each transducer, ascending from 0
    /// Transducers that are never driven, ascending; set by setDead(). Their gain is 0, so that
    /// fields are solved for without them.
    std::vector<int> dead;
    DriveResolution drive;

    int size() const { return static_cast<int>(positions.cols()); }

    /// Returns P0 for the level at ears: the larger of sourceAmplitude_Pa_m and
    /// exposureAmplitude_Pa_m. Where that is 0 and the directivity is a T4010A1's, the transducers
    /// are known by their data sheet: it is at least kT4010A1Source_Pa_m.
    double heardAmplitude_Pa_m() const;

    /// Makes the transducers \a which, each 0 .. m - 1, in any order, dead: sets their gains to 0.
    /// Those that were dead before stay so.
    void setDead(const std::vector<int>& which);

    /// Sets the gains of the transducers in \a which: index 0 .. m - 1, and a gain above 0. Those
    /// that are dead must not be among them.
    void setGains(const std::vector<std::pair<int, double>>& which);

    /// Applies what users say of single transducers: \a dead, "17, 400-410", in addition to those
    /// that are dead already, and \a weak, their gains: "17:0.5, 400-410:0.8". Throws InputError,
    /// which names the entry, for texts that aren't understood, for numbers that the array doesn't
    /// have, and for a transducer that is both.
    void mark(const std::string& dead, const std::string& weak);

    /// The paper's device: 16 boards of 249 transducers as the eight sides of a prism around the y
    /// axis, 3984 in all; P0 = 2.73 Pa m and the paper's harmonics, with which P0 was derived; at
    /// ears the data sheet's.
    static TransducerArray octagonalPrism();
    /// One board of 249 in the plane z = 0, facing +z; P0 and directivity of the data sheet.
    static TransducerArray singleBoard();
    /// Loads "octagon", "board", a named array (names() lists them), or the JSON file of that path.
    /// Throws InputError.
    static TransducerArray load(const std::string& nameOrPath);

    /// Returns the names that load() knows: "octagon", "board", then every NAME.json in the folders
    /// of the environment variable OSG_MIDAIR_ARRAYS (separated by colons), of the installation and
    /// of the source tree.
    static std::vector<std::string> names();

    /// Returns the file that load() reads for \a nameOrPath now; empty for what is built in and for
    /// names of nothing.
    static std::string fileOf(const std::string& nameOrPath);

    /// Reads the array that \a json describes (format: samples/guides/ARRAYS.md); \a source:
    /// its name in messages. Throws InputError: "source: path in the file: what it is; what it must
    /// be".
    static TransducerArray fromJson(const std::string& json, const std::string& source);

    /// Returns a text that fromJson() reads back as an equal array. Throws InputError if the array
    /// is not valid.
    std::string toJson() const;

    /// Writes toJson() to \a path. Throws InputError if that fails.
    void save(const std::string& path) const;

    /// Returns false if lengths disagree or a value is out of range; \a error then says which.
    /// Loaded arrays are valid.
    bool isValid(std::string* error = nullptr) const;
};

} // namespace midair::haptics
