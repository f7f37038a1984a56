#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// A drive that keeps to a cap of pressure, and the field that it makes.
struct CappedField
{
    double factor =
        1.0; ///< on all amplitudes; 1: as it was; 0: silent, since nothing less keeps to the cap
    Eigen::VectorXcf played;     ///< m, as the device plays it
    Eigen::VectorXf achieved_Pa; ///< n, |G q| of that, of the first of the arrays
};

/// Keeps the peak pressure at control points to a cap: looks at the field as the device plays it,
/// in its levels, and scales the whole drive down until no point has more; silences it where the
/// device's levels can't.
///
/// The cap holds for all that the device makes of the drive afterwards. Lower amplitudes (ramp,
/// thermal budget, modulation) are less pressure where all transducers play at one amplitude, as
/// they do by default; where they don't, each is rounded by itself, and what that may add is kept
/// free. Parts of the array that may sound alone keep to the cap alone too.
class PressureCap
{
public:
    using Play = std::function<Eigen::VectorXcf(const device::DriveSignal&)>;

    /// \a max_Pa > 0, peak. \a play tells what a device of \a ability makes of a drive, as
    /// activations (m). Throws base::InputError for another \a max_Pa.
    PressureCap(double max_Pa, Play play, device::DriveAbility ability = {});

    double max_Pa() const { return _max_Pa; }

    /// Where the cap is to hold: at \a points (3 x n), for each of \a arrays, which differ in what
    /// is believed of them (obstacles in the sound's way or not).
    struct Where
    {
        const Eigen::Matrix3Xd& points;
        std::vector<const haptics::TransducerArray*> arrays; ///< at least one
        const haptics::Medium& medium;
        bool modulated = false; ///< amplitudes will be lowered even where the device doesn't
        int threads = 1;
        base::StopToken stop = {}; ///< where it asks for that, base::Stopped is thrown
    };

    /// Lowers the duties of \a signal as far as needed.
    CappedField hold(const Where& where, device::DriveSignal& signal) const;

    /// Of fields that are played in turn: lowers all of them by one factor, so that what they are
    /// to each other stays. Gives it; 0: silent. Throws base::InputError for an activation that is
    /// not finite.
    double holdAll(const Where& where, std::vector<Eigen::VectorXcf>& fields) const;

    /// Of what is to be played, one field or several. Throws as holdAll().
    double hold(const Where& where, haptics::FieldSequence& sequence) const;
    /// What is said where all amplitudes were lowered by \a factor < 1.
    std::string message(double factor) const;

private:
    double loudest(const Where& where, const device::DriveSignal& signal, CappedField& field) const;

    double _max_Pa;
    Play _play;
    device::DriveAbility _ability;
    float _coarsest; ///< most that rounding to levels takes off an amplitude, or adds
};

} // namespace midair::bridge
