#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/Mutex.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <array>
#include <vector>

namespace midair::haptics
{

/// Tells which transducers a place hears directly: those with D > 0 towards it whose straight line
/// to it passes beside all boards. A board is the rectangle around the transducers of one number in
/// TransducerArray::board, if there are at least four in one plane; it hides what is behind it, of
/// its own transducers, too. What isn't such a board hides nothing.
class FreeLines
{
public:
    explicit FreeLines(const TransducerArray& array);

    /// Returns true if nothing is between transducer \a i of the array and \a place (metres, array
    /// frame).
    bool isFree(Eigen::Index i, const Eigen::Vector3d& place) const;

private:
    struct Rectangle
    {
        Eigen::Vector3d corner; ///< of its transducers, one
        Eigen::Vector3d normal; ///< unit length, as the transducers'
        Eigen::Vector3d u;      ///< unit length, in the plane
        Eigen::Vector3d v;
        Eigen::Vector2d low; ///< metres along u and v from the corner
        Eigen::Vector2d high;
    };

    void addBoard(const TransducerArray& array, Eigen::Index first, Eigen::Index last);

    Eigen::Matrix3Xd _positions;
    std::vector<Rectangle> _boards;
    std::vector<int> _own; ///< m: number of its rectangle; -1: none
};

/// Returns the fraction, 0 .. 1, of the energy of a change of the drive that lies 20 Hz to 20 kHz
/// from the carrier, when fields follow each other at \a rate_Hz (> 0). The air demodulates the
/// ultrasound, so a change of the envelope at frequency f is heard at f (Suzuki, Fujiwara, Makino,
/// Shinoda, "Reducing amplitude fluctuation by gradual phase shift in midair ultrasound haptics",
/// IEEE Transactions on Haptics 13, 2020). A change D that is held for T = 1/rate is a pulse, whose
/// energy spectrum is
///     |D|^2 T^2 sinc^2(f T),  sinc x = sin(pi x)/(pi x),  in all |D|^2 T
/// (Oppenheim, Schafer, zero-order hold).
double audibleShare(double rate_Hz);

/// Limits near 40 kHz that are known for the public and for workers, dB re 20 uPa, rms: those in
/// bold in SAFETY.md, which names where they were read. Who has to choose one is told both.
constexpr double kPublicEarLimit_dB = 100.0;
constexpr double kWorkersEarLimit_dB = 110.0;

/// Reference of sound pressure levels, Pa rms.
constexpr double kHearing_Pa = 20e-6;

/// Returns the level of a mean square \a square_Pa2 (rms squared), dB re 20 uPa; 0 for silence and
/// for what is quieter than 0 dB, NaN for NaN.
double soundLevel_dB(double square_Pa2);
/// Returns the mean square, Pa^2, of a level.
double meanSquareOf_Pa2(double level_dB);

/// Places that hear the array: at most \a count of a sphere round the origin with a radius of 0.5
/// m, or of the array's with 0.1 m more if that is larger. Those behind boards, which hear nothing,
/// are left out; the others are spread evenly, the first one is the loudest at full drive. 3 x n,
/// array frame.
Eigen::Matrix3Xd placesAround(const TransducerArray& array, int count);

/// What ears at listening places hear of a field: at the array's frequency alone, with the P0 that
/// the array has for ears (TransducerArray::heardAmplitude_Pa_m()), in a free field without a room;
/// all pressures have kHeadMargin_dB on top for the head. Transducers count where D > 0 and with a
/// free line (FreeLines).
class Exposure
{
public:
    /// The sound at a place varies like speckle: its |p|^2 is exponential, and in 99 of 100 places
    /// at most this much over its mean, ln(100) = 6.63 dB.
    static constexpr double kSpeckle = 4.6051701859880914;
    /// A field is looked at in the place itself and at four places this far from it.
    static constexpr double kAround_m = 0.03;
    static constexpr int kSpots = 5;

    /// \a places: 3 x n, metres, array frame, finite.
    Exposure(const TransducerArray& array, const Medium& medium, const Eigen::Matrix3Xd& places);

    Eigen::Index size() const { return _places.cols(); }
    const Eigen::Matrix3Xd& places() const { return _places; }

    /// Listens in another \a medium from now on. Where it differs little, as from tenth to tenth of
    /// a kelvin, what is known is turned by the difference, within 2e-6 of each entry.
    void setMedium(const Medium& medium);

    /// Moves place \a l.
    void move(Eigen::Index l, const Eigen::Vector3d& place);

    /// Returns for each place (n) sum_i (P0 D_i g_i |q_i| / R_i)^2 e^{-2 beta R_i} / 2, Pa^2: the
    /// mean square that \a q (m, activations) has with any phases, on average.
    Eigen::VectorXf incoherent_Pa2(const Eigen::VectorXcf& q) const;
    /// The same for squared amplitudes (m).
    Eigen::VectorXf incoherentOf_Pa2(const Eigen::VectorXf& squares) const;

    /// Returns for each place (n) the mean square of \a q, with its phases, in the place itself.
    Eigen::VectorXf coherent_Pa2(const Eigen::VectorXcf& q) const;

    /// Returns the complex peak pressures (kSpots x n) of \a q in and around each place. The first
    /// call computes what the later ones need.
    Eigen::MatrixXcf spots_Pa(const Eigen::VectorXcf& q);

    /// Returns for each place (n) the mean square of fields that are played in turn (K >= 1 times
    /// m): the larger of coherent and incoherent, averaged over the fields. A place that happens to
    /// be in a minimum counts as its surroundings, one in a beam as it is.
    Eigen::VectorXd heard_Pa2(const std::vector<Eigen::VectorXcf>& fields) const;

private:
    /// Puts the entries of G at \a place into column \a column of the matrices.
    void listen(const Eigen::Vector3d& place,
                Eigen::Index column,
                Eigen::MatrixXf& real,
                Eigen::MatrixXf& imaginary) const;
    Eigen::Vector3d spot(Eigen::Index l, Eigen::Index k) const;
    void listenTo(Eigen::Index l);
    void square(Eigen::Index l);
    void listenAround(Eigen::Index l);

    TransducerArray _array;
    Medium _medium;
    FreeLines _lines;
    Eigen::MatrixX3f _from; ///< m x 3, the transducers' places
    Eigen::Matrix3Xd _places;
    Eigen::MatrixXf _square;    ///< m x n, |G|^2 / 2
    Eigen::MatrixXf _real;      ///< m x n, G
    Eigen::MatrixXf _imaginary; ///< m x n
    Eigen::MatrixXf _spotsReal; ///< m x (kSpots n), empty: not needed so far
    Eigen::MatrixXf _spotsImaginary;
};

/// Averages over time what listening places hear: L_eq = 10 log10(mean 10^{L/10}) since the first
/// field, and L_max, the highest mean over one second. What is told by play() sounds until the next
/// one. All members from any thread.
class ExposureMeter
{
public:
    /// From \a now_s (steady clock) on the \a places (3 x n) hear \a square_Pa2 (n, mean squares;
    /// all 0: silence). Another number of places begins anew. NaN counts as infinite. \a unnamed:
    /// how many of the places, the first ones, nobody has named.
    void play(double now_s,
              const Eigen::Matrix3Xd& places,
              const Eigen::VectorXd& square_Pa2,
              Eigen::Index unnamed = 0);

    /// Returns the figures at \a now_s, but for the limit.
    ExposureFigures read(double now_s) const;
    /// Returns what each of the named places hears at \a now_s, in their order; nothing before the
    /// first play().
    std::vector<PlaceExposure> readEach(double now_s) const;

private:
    // Seconds begin every 0.1 s; a shorter sound counts with the silence around it.
    static constexpr int kBins = 10;
    static constexpr double kBin_s = 0.1;

    /// All that changes with time.
    struct State
    {
        Eigen::Matrix3Xd places;
        Eigen::VectorXd square_Pa2;              ///< n, now
        Eigen::VectorXd sum;                     ///< n, Pa^2 s since the start
        std::array<Eigen::VectorXd, kBins> bins; ///< n each, Pa^2 s in the last full tenths
        Eigen::VectorXd bin;                     ///< n, Pa^2 s in the tenth that runs
        Eigen::VectorXd mostEach_Pa2;            ///< n, the highest mean over a second
        Eigen::Index unnamed = 0;                ///< of the places, the first ones
        int next = 0;                            ///< of bins, the oldest one
        double inBin_s = 0.0;                    ///< how much of it has passed
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
