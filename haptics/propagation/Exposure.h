#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/Mutex.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <array>
#include <complex>
#include <vector>

namespace midair::haptics
{

/// Finds the transducers with a direct line to a place: D > 0 towards it, and the straight line
/// passes beside all boards. A board is the rectangle around the transducers of one number in
/// TransducerArray::board, if there are at least four in one plane; it hides what is behind it,
/// also from its own transducers. Other boards hide nothing.
class FreeLines
{
public:
    explicit FreeLines(const TransducerArray& array);

    /// Returns true if nothing is between transducer \a i and \a place (metres, array frame).
    bool isFree(Eigen::Index i, const Eigen::Vector3d& place) const;
    /// The same by way of \a reflector, which the way to \a image, the mirror image of the place,
    /// meets.
    bool isFreeBy(const Reflector& reflector, Eigen::Index i, const Eigen::Vector3d& image) const;

private:
    struct Rectangle
    {
        Eigen::Vector3d corner; ///< one of the corners of its transducers
        Eigen::Vector3d normal; ///< unit length, same as the transducers'
        Eigen::Vector3d u;      ///< unit length, in the plane
        Eigen::Vector3d v;
        Eigen::Vector2d low; ///< metres along u and v from the corner
        Eigen::Vector2d high;
    };

    void addBoard(const TransducerArray& array, Eigen::Index first, Eigen::Index last);
    bool isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& place, int own) const;

    Eigen::Matrix3Xd _positions;
    std::vector<Rectangle> _boards;
    std::vector<int> _own; ///< m: index of its rectangle; -1: none
};

/// Returns the fraction, 0 .. 1, of the energy of a drive change that lies 20 Hz to 20 kHz from the
/// carrier, when fields follow each other at \a rate_Hz (> 0). Air demodulates the ultrasound, so
/// an envelope change at frequency f is heard at f (Suzuki, Fujiwara, Makino, Shinoda, "Reducing
/// amplitude fluctuation by gradual phase shift in midair ultrasound haptics", IEEE Transactions on
/// Haptics 13, 2020). A change D held for T = 1/rate is a pulse with the energy spectrum
///     |D|^2 T^2 sinc^2(f T),  sinc x = sin(pi x)/(pi x),  in all |D|^2 T
/// (Oppenheim, Schafer, zero-order hold).
double audibleShare(double rate_Hz);

/// Known limits near 40 kHz for the public and for workers, dB re 20 uPa, rms: those in bold in
/// SAFETY.md, which cites the sources. Users who have to choose a limit see both.
constexpr double kPublicEarLimit_dB = 100.0;
constexpr double kWorkersEarLimit_dB = 110.0;

/// Reference of sound pressure levels, Pa rms.
constexpr double kHearing_Pa = 20e-6;

/// Returns the level of a mean square \a square_Pa2 (rms squared), dB re 20 uPa; 0 for silence and
/// below 0 dB, NaN for NaN.
double soundLevel_dB(double square_Pa2);
/// Returns the mean square, Pa^2, of a level.
double meanSquareOf_Pa2(double level_dB);

/// Listening places: at most \a count on a sphere around the origin with a radius of 0.5 m, or of
/// the array's radius plus 0.1 m if that is larger. Places behind boards, which hear nothing, are
/// left out; the others are spread evenly, the loudest at full drive first. 3 x n, array frame.
Eigen::Matrix3Xd placesAround(const TransducerArray& array, int count);

/// Sound of a field at listening places: at the array's frequency alone, with
/// TransducerArray::heardAmplitude_Pa_m() as P0, in a free field without a room; all pressures
/// include kHeadMargin_dB. Transducers count if D > 0 and their line is free (FreeLines).
class Exposure
{
public:
    /// Sound at a place varies like speckle: |p|^2 is exponential, and in 99 of 100 places at most
    /// this factor above its mean, ln(100) = 6.63 dB.
    static constexpr double kSpeckle = 4.6051701859880914;
    /// A field is evaluated at the place itself and at four places at this distance.
    static constexpr double kAround_m = 0.03;
    static constexpr int kSpots = 5;

    /// \a places: 3 x n, metres, array frame, finite.
    Exposure(const TransducerArray& array, const Medium& medium, const Eigen::Matrix3Xd& places);

    Eigen::Index size() const { return _places.cols(); }
    const Eigen::Matrix3Xd& places() const { return _places; }

    /// Changes the \a medium. For small differences, such as tenths of a kelvin, the stored entries
    /// are only rotated by the difference, within 2e-6 of each entry.
    void setMedium(const Medium& medium);

    /// Moves place \a l.
    void move(Eigen::Index l, const Eigen::Vector3d& place);

    /// Returns for each place (n) sum_i (P0 D_i g_i |q_i| / R_i)^2 e^{-2 beta R_i} / 2, Pa^2: the
    /// mean square of \a q (m, activations), averaged over random phases; images count as
    /// transducers with phases of their own.
    Eigen::VectorXf incoherent_Pa2(const Eigen::VectorXcf& q) const;
    /// The same for squared amplitudes (m).
    Eigen::VectorXf incoherentOf_Pa2(const Eigen::VectorXf& squares) const;

    /// Returns for each place (n) the mean square of \a q, with its phases, at the place itself.
    Eigen::VectorXf coherent_Pa2(const Eigen::VectorXcf& q) const;

    /// Returns the complex peak pressures (kSpots x n) of \a q at and around each place. The first
    /// call computes matrices for later ones.
    Eigen::MatrixXcf spots_Pa(const Eigen::VectorXcf& q);

    /// Returns for each place (n) the mean square of fields in turn (K >= 1 times m): the larger of
    /// coherent and incoherent, averaged over the fields. A place in a minimum counts like its
    /// surroundings, a place in a beam with its own value.
    Eigen::VectorXd heard_Pa2(const std::vector<Eigen::VectorXcf>& fields) const;

private:
    /// Stores the entries of G at \a place in column \a column of the matrices.
    void listen(const Eigen::Vector3d& place,
                Eigen::Index column,
                Eigen::MatrixXf& real,
                Eigen::MatrixXf& imaginary) const;
    std::complex<double> wave(Eigen::Index i, const Eigen::Vector3d& at) const;
    std::complex<double>
    reflected(Eigen::Index i, const Eigen::Vector3d& place, double& square) const;
    Eigen::Vector3d spot(Eigen::Index l, Eigen::Index k) const;
    void listenTo(Eigen::Index l);
    void square(Eigen::Index l);
    void listenAround(Eigen::Index l);

    TransducerArray _array;
    Medium _medium;
    FreeLines _lines;
    Eigen::MatrixX3f _from; ///< m x 3, positions of the transducers
    Eigen::Matrix3Xd _places;
    Eigen::MatrixXf _square;    ///< m x n, |G|^2 / 2, of each path on its own
    Eigen::MatrixXf _real;      ///< m x n, G
    Eigen::MatrixXf _imaginary; ///< m x n
    Eigen::MatrixXf _spotsReal; ///< m x n, empty: not needed so far
    Eigen::MatrixXf _spotsImaginary;
};

/// Averages levels at listening places over time: L_eq = 10 log10(mean 10^{L/10}) since the first
/// field, and L_max, the highest mean over one second. Values of play() hold until the next call.
/// Any thread.
class ExposureMeter
{
public:
    /// Sets the present mean squares \a square_Pa2 (n; all 0: silence) at \a places (3 x n) from \a
    /// now_s (steady clock) on. A changed number of places restarts the averages. NaN counts as
    /// infinite. \a unnamed: number of leading places without a name.
    void play(double now_s,
              const Eigen::Matrix3Xd& places,
              const Eigen::VectorXd& square_Pa2,
              Eigen::Index unnamed = 0);

    /// Returns the figures at \a now_s, except the limit.
    ExposureFigures read(double now_s) const;
    /// Returns the figures of each named place at \a now_s, in order; empty before the first
    /// play().
    std::vector<PlaceExposure> readEach(double now_s) const;

private:
    // Seconds begin every 0.1 s; shorter sounds are averaged with the silence around them.
    static constexpr int kBins = 10;
    static constexpr double kBin_s = 0.1;

    /// State that changes with time.
    struct State
    {
        Eigen::Matrix3Xd places;
        Eigen::VectorXd square_Pa2;              ///< n, present
        Eigen::VectorXd sum;                     ///< n, Pa^2 s since the start
        std::array<Eigen::VectorXd, kBins> bins; ///< n each, Pa^2 s in the last full tenths
        Eigen::VectorXd bin;                     ///< n, Pa^2 s in the present tenth
        Eigen::VectorXd mostEach_Pa2;            ///< n, highest mean over a second
        Eigen::Index unnamed = 0;                ///< number of leading places without a name
        int next = 0;                            ///< index of the oldest bin
        double inBin_s = 0.0;                    ///< elapsed part of it
        double start_s = 0.0;
        double now_s = 0.0;
        double most_Pa2 = 0.0; ///< the highest mean over a second
        Eigen::Vector3d mostAt = Eigen::Vector3d::Zero();
    };

    static void advance(State& state, double now_s);
    static void closeBin(State& state);

    mutable base::Mutex _mutex;
    State _state MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::haptics
