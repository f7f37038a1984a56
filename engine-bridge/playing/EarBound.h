#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/Exposure.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Reads listening places, "0 0 0.6; 30 0 60 cm", into \a places (3 x n, m), as
/// base::parsePlaces() does.
bool readPlaces(const std::string& text, Eigen::Matrix3Xd& places);

/// A limit on the level at listening places, for PressureCap to hold. A field keeps to it if
/// neither its rms pressure in a place and in four more around it, with its phases as played, nor
/// what 99 of 100 sets of phases stay below (6.6 dB over the incoherent sum) is over the limit.
class EarBound
{
public:
    /// \a limit_dB: dB re 20 uPa, rms, over 0. Fields are those of the array of \a exposure, which
    /// is used by one thread at a time.
    EarBound(double limit_dB, std::shared_ptr<haptics::Exposure> exposure);

    double limit_dB() const { return _limit_dB; }

    /// Returns the pressure of \a played (m, as the device plays it) at the loudest place, over
    /// that of the limit: at most 1 if it keeps to it; NaN if it is none. \a rounding: the most
    /// that an amplitude changes when it is lowered and rounded by itself; 0 if the field stays the
    /// same but for its level. Since nobody knows the errors of such a rounding, they count like
    /// noise on all amplitudes, with the same 6.6 dB.
    double excess(const Eigen::VectorXcf& played,
                  float rounding,
                  const device::DriveAbility& ability) const;

private:
    Eigen::VectorXf loudest_Pa(const Eigen::VectorXcf& played,
                               const device::DriveAbility& ability) const;

    double _limit_dB;
    double _limit_Pa; ///< rms
    std::shared_ptr<haptics::Exposure> _exposure;
};

/// Listens to what an array plays: at places around it, at those that the user names, and at the
/// ears of a head that may move. Measures the exposure, and has the limit for the fields.
///
/// What it needs to know of the places is computed when a field is first to be played. One thread
/// uses it; reading() is for any.
class EarWatch
{
public:
    /// Places around the array; with two ears there are 32.
    static constexpr int kAround = 30;
    /// Ears that moved by no more than this count as unmoved.
    static constexpr double kTolerance_m = 0.01;

    /// Listens to \a array in \a medium, with \a places of the user (3 x n, array frame, m), from
    /// now on; the measurement goes on where these are as before.
    void setPlace(const haptics::TransducerArray& array,
                  const haptics::Medium& medium,
                  const Eigen::Matrix3Xd& places);
    /// dB re 20 uPa, rms; 0: no limit.
    void setLimit(double limit_dB);
    double limit_dB() const { return _limit_dB; } ///< any thread

    /// Returns true if \a ears (3 x n, array frame, m) are where they were, by the tolerance.
    bool isUnmoved(const Eigen::Matrix3Xd& ears) const;
    /// Listens at \a ears from now on. What isn't finite is left out.
    void setEars(const Eigen::Matrix3Xd& ears);

    /// Returns the limit for the fields; null: there is none.
    const EarBound* bound();

    /// \a fields (K times m) are played in turn from \a now_s (steady clock) on; none: silence.
    void play(const std::vector<Eigen::VectorXcf>& fields, double now_s);

    /// The figures at \a now_s. Any thread.
    haptics::ExposureFigures reading(double now_s) const;
    /// What each of the ears, then each of the user's places hears; nothing before the first sound.
    /// Any thread.
    std::vector<haptics::PlaceExposure> each(double now_s) const { return _meter.readEach(now_s); }

private:
    void listen();
    Eigen::Index unnamed() const; ///< how many places nobody has named; after listen()

    haptics::TransducerArray _array;
    haptics::Medium _medium;
    Eigen::Matrix3Xd _places = Eigen::Matrix3Xd(3, 0);
    Eigen::Matrix3Xd _ears = Eigen::Matrix3Xd(3, 0);
    std::atomic<double> _limit_dB{0.0};
    std::shared_ptr<haptics::Exposure> _exposure; ///< null: not computed yet
    std::unique_ptr<EarBound> _bound;
    haptics::ExposureMeter _meter;
};

} // namespace midair::bridge
