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

/// A limit on the level at listening places, enforced by PressureCap. A field keeps it if neither
/// its rms pressure at a place and at four points around it, with the phases as played, nor the
/// level that 99 of 100 sets of phases stay below (6.6 dB over the incoherent sum) exceeds the
/// limit.
class EarBound
{
public:
    /// \a limit_dB: dB re 20 uPa, rms, over 0. Fields belong to the array of \a exposure, which is
    /// used by one thread at a time.
    EarBound(double limit_dB, std::shared_ptr<haptics::Exposure> exposure);

    double limit_dB() const { return _limit_dB; }

    /// Returns the pressure of \a played (m, as the device plays it) at the loudest place divided
    /// by the limit's: at most 1 if it keeps the limit; NaN if it is undefined. \a rounding: the
    /// largest change of an amplitude when it is lowered and rounded on its own; 0 if only the
    /// field's level changes. As the errors of such rounding are unknown, they count as noise on
    /// all amplitudes, with the same 6.6 dB.
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

/// Measures the exposure of an array's output at places around it, at the user's places and at the
/// ears of a head that may move, and provides the limit for fields. The data for the places is
/// computed when the first field is to be played. One thread uses it; reading() is for any thread.
class EarWatch
{
public:
    /// Places around the array; 32 with two ears.
    static constexpr int kAround = 30;
    /// Ears that moved by at most this distance count as unmoved.
    static constexpr double kTolerance_m = 0.01;

    /// Listens to \a array in \a medium and at the user's \a places (3 x n, array frame, m). The
    /// measurement continues if these are unchanged.
    void setPlace(const haptics::TransducerArray& array,
                  const haptics::Medium& medium,
                  const Eigen::Matrix3Xd& places);
    /// dB re 20 uPa, rms; 0: no limit.
    void setLimit(double limit_dB);
    double limit_dB() const { return _limit_dB; } ///< any thread

    /// Returns true if \a ears (3 x n, array frame, m) are unmoved within the tolerance.
    bool isUnmoved(const Eigen::Matrix3Xd& ears) const;
    /// Sets the ears. Positions that are not finite are left out.
    void setEars(const Eigen::Matrix3Xd& ears);

    /// Returns the limit for the fields; null if there is none.
    const EarBound* bound();

    /// Starts the measurement of \a fields (K times m), played in turn from \a now_s (steady
    /// clock); empty: silence.
    void play(const std::vector<Eigen::VectorXcf>& fields, double now_s);

    /// The figures at \a now_s. Any thread.
    haptics::ExposureFigures reading(double now_s) const;
    /// Levels at each ear, then at each of the user's places; empty before the first sound. Any
    /// thread.
    std::vector<haptics::PlaceExposure> each(double now_s) const { return _meter.readEach(now_s); }

private:
    void listen();
    Eigen::Index unnamed() const; ///< number of places around the array; valid after listen()

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
